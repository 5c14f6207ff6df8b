//! Distances between a mesh and the exact surface, in both directions.

use glam::DVec3;
use mesh_core::TriMesh;
use mesh_metric::{Surface, sample_surface};
use rayon::prelude::*;

use super::bound::Distances;
use super::surfaces::Shape;
use xtask_common::Failure;

/// Number of samples per direction.
pub(super) const SAMPLES: usize = 400_000;

/// The distances of a mesh from a surface: means over both directions, uniform by area, and the larger one of the two
/// maxima. Samples of the surface are samples of a fine mesh, moved onto it.
pub fn distances(
    shape: Shape,
    fine: &Surface,
    mesh: &TriMesh,
    samples: usize,
) -> Result<Distances, Failure> {
    let surface = Surface::new(mesh).map_err(Failure::mesh)?;
    let there: Vec<f64> = sample_surface(&surface, samples, 1)
        .par_iter()
        .map(|sample| shape.distance(sample.position))
        .collect();
    let exact: Vec<_> = sample_surface(fine, samples, 2)
        .par_iter()
        .map(|sample| shape.closest_point(sample.position))
        .collect();
    let back = surface.distances(&exact);
    let vertices = mesh.topology().vertices().map(|v| shape.distance(mesh.position(v)));
    let mean = |d: &[f64]| d.iter().sum::<f64>() / d.len().max(1) as f64;
    let square = |d: &[f64]| d.iter().map(|x| x * x).sum::<f64>() / d.len().max(1) as f64;
    let max = there.iter().chain(&back).copied().chain(vertices).fold(0.0, f64::max);
    Ok(Distances {
        mean: 0.5 * (mean(&there) + mean(&back)),
        rms: (0.5 * (square(&there) + square(&back))).sqrt(),
        max,
    })
}

/// Moves the vertices of a fine mesh so that its faces lie on both sides of the surface, by the same mean
/// distance.
///
/// With its vertices on the surface, a mesh lies inside where the surface is convex. A mesh simplified from it inherits
/// this offset, which is not an error of the simplification. Its share grows as the result gets closer to the fine
/// mesh: with 8,000 faces made from 320,000, it is 13 % of the least mean distance.
pub(super) fn balance(shape: Shape, mesh: &mut TriMesh) {
    let topology = mesh.topology();
    // The mean of a quadratic function that vanishes at the corners is 3/4 of its value at the centroid.
    let gap = |f| {
        let [a, b, c] = mesh.triangle(f);
        let centroid = (a + b + c) / 3.0;
        let area = 0.5 * (b - a).cross(c - a).length();
        (0.75 * (shape.closest_point(centroid) - centroid), area)
    };
    let shifts: Vec<DVec3> = topology
        .vertices()
        .map(|v| {
            let gaps = topology.faces_of_vertex(v).map(gap);
            let (sum, all) = gaps
                .fold((DVec3::ZERO, 0.0), |(sum, all), (gap, area)| (sum + area * gap, all + area));
            sum / all
        })
        .collect();
    let vertices: Vec<_> = topology.vertices().collect();
    for (v, shift) in vertices.into_iter().zip(shifts) {
        mesh.positions_mut()[v.index()] += shift;
    }
}

#[cfg(test)]
mod tests {
    use super::super::surfaces::{Fineness, Shape};
    use super::{balance, distances};
    use mesh_core::TriMesh;
    use mesh_metric::Surface;
    use mesh_shapes::Sphere;

    /// An octahedron in a sphere: the centres of the faces are farthest.
    #[test]
    fn an_octahedron_is_as_far_from_the_sphere_as_it_is() {
        let fine = Shape::Sphere.mesh(Fineness::Quick).unwrap();
        let soup = Sphere { radius: 1.0 }.geodesic(1).unwrap();
        let mesh = TriMesh::from_soup(&soup).unwrap();
        let fine = Surface::new(&fine).unwrap();
        let found = distances(Shape::Sphere, &fine, &mesh, 20_000).unwrap();
        let [a, b, c] = mesh.triangle(mesh.topology().faces().next().unwrap());
        let depth = 1.0 - ((a + b + c) / 3.0).length();
        assert!((found.max / depth - 1.0).abs() < 0.01, "{found:?}");
        assert!(found.mean < found.rms && found.rms < found.max);
    }

    /// The offset is 3/4 of the height of the centroid before, and almost zero afterwards.
    #[test]
    fn a_balanced_sphere_is_as_much_inside_as_outside() {
        let mut mesh = Shape::Sphere.mesh(Fineness::Quick).unwrap();
        let inside = |mesh: &TriMesh| {
            let samples = mesh_metric::sample_surface(&Surface::new(mesh).unwrap(), 50_000, 3);
            samples.iter().map(|s| 1.0 - s.position.length()).sum::<f64>() / samples.len() as f64
        };
        let before = inside(&mesh);
        balance(Shape::Sphere, &mut mesh);
        assert!(before > 0.0 && inside(&mesh).abs() < 0.03 * before, "{before}");
    }
}
