//! The mean distance between a mesh and the original, which decides between small meshes.

use glam::DVec3;
use mesh_core::TriMesh;
use mesh_metric::Surface;

use crate::error::RefineError;
use crate::fit::spread::{Spot, Spread};

const SEED: u64 = 1;

/// The average of the mean distances of both surfaces, as reports have it, from about `points` points on each. Every
/// triangle has one, so that small parts of a mesh count, too. With 10,000 points the mean is known within two percent.
///
/// # Errors
/// The mesh has no faces.
pub fn mean_distance(
    original: &Surface,
    mesh: &TriMesh,
    points: usize,
) -> Result<f64, RefineError> {
    Ok(measure(original, mesh, points)?.mean)
}

/// Distances at points of both surfaces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measured {
    /// The average of the means of both directions.
    pub(crate) mean: f64,
    /// The largest one.
    pub(crate) max: f64,
}

/// As [`mean_distance`], with the largest distance.
pub(crate) fn measure(
    original: &Surface,
    mesh: &TriMesh,
    points: usize,
) -> Result<Measured, RefineError> {
    let surface = Surface::new(mesh)?;
    let [forward, backward] =
        [(original, &surface), (&surface, original)].map(|pair| measure_from(pair, points));
    Ok(Measured { mean: 0.5 * (forward.mean + backward.mean), max: forward.max.max(backward.max) })
}

fn measure_from((from, to): (&Surface, &Surface), points: usize) -> Measured {
    let corners = |t: u32| from.triangle(t as usize);
    let spread = Spread::new(from.in_space(), corners, points.max(from.triangle_count()), SEED);
    let spots: Vec<Spot> = spread.spots(corners, 0..spread.len()).collect();
    let points: Vec<DVec3> = spots.iter().map(|spot| spot.point).collect();
    let distances = to.closest_to_neighbours(&points).into_iter().map(|closest| closest.distance);
    let add = |[sum, all, max]: [f64; 3], (spot, distance): (&Spot, f64)| {
        [sum + spot.share * distance, all + spot.share, max.max(distance)]
    };
    let [sum, all, max] = spots.iter().zip(distances).fold([0.0; 3], add);
    Measured { mean: if all > 0.0 { sum / all } else { 0.0 }, max }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cubes, of which the second is small: it weighs little, but is not missed.
    #[test]
    fn a_small_part_is_not_missed() {
        let cubes = |shift: f64| {
            let cube = TriMesh::from_soup(&mesh_shapes::polyhedra::cube()).unwrap();
            let triangles: Vec<[u32; 3]> = cube.topology().triangles().collect();
            let count = u32::try_from(cube.positions().len()).unwrap();
            let second = triangles.iter().map(|t| t.map(|v| v + count));
            let small = cube.positions().iter().map(|p| DVec3::X * 9.0 + 1e-3 * (*p + shift));
            let positions: Vec<DVec3> = cube.positions().iter().copied().chain(small).collect();
            let all: Vec<[u32; 3]> = triangles.iter().copied().chain(second).collect();
            TriMesh::from_triangles(&positions, &all).unwrap()
        };
        let original = Surface::new(&cubes(0.0)).unwrap();
        assert!(mean_distance(&original, &cubes(0.0), 8_000).unwrap() < 1e-15);
        let mean = mean_distance(&original, &cubes(0.5), 8_000).unwrap();
        // A millionth of the area is up to a thousandth of half a side away.
        assert!(mean > 1e-11 && mean < 1e-9, "{mean}");
    }

    #[test]
    fn the_mean_counts_both_directions() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let square = TriMesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap();
        let half = TriMesh::from_triangles(&corners[..3], &[[0, 1, 2]]).unwrap();
        let [square_surface, half_surface] = [&square, &half].map(|m| Surface::new(m).unwrap());
        // The other half is at most √½ from the diagonal, and a third of that in the mean.
        let expected = 0.5 * (0.5 * 0.5_f64.sqrt() / 3.0);
        let of = |surface, mesh| mean_distance(surface, mesh, 8_000).unwrap();
        for mean in [of(&square_surface, &half), of(&half_surface, &square)] {
            assert!((mean / expected - 1.0).abs() < 0.03);
        }
        assert!(of(&square_surface, &square) < 1e-12);
    }
}
