//! Distances between a mesh and the exact surface, both ways.

use mesh_core::TriMesh;
use mesh_metric::{Surface, sample_surface};
use rayon::prelude::*;

use super::bound::Distances;
use super::surfaces::Shape;
use crate::failure::Failure;

/// Samples in either direction.
pub(crate) const SAMPLES: usize = 400_000;

/// The distances of a mesh from a surface: means over both directions, uniform by area, and the larger
/// of the two largest ones. Samples of the surface are those of a fine mesh, moved onto it.
pub(crate) fn distances(
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

#[cfg(test)]
mod tests {
    use super::distances;
    use crate::limit_study::surfaces::{Fineness, Shape};
    use mesh_core::TriMesh;
    use mesh_core::shapes::Sphere;
    use mesh_metric::Surface;

    /// An octahedron in a sphere: the centre of a face is farthest.
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
}
