//! Faces that turn over against the surface they stand for.

use glam::DVec3;
use mesh_core::topology::handle::FaceId;
use mesh_core::{BoundingBox, FaceTree, TriMesh};
use mesh_metric::Surface;

/// Cosine below which a face is opposite to the surface under it.
const OPPOSITE: f64 = -0.2;

/// The original surface, against which faces of a result are compared.
///
/// A result may have any defects, so its faces are given as corners.
#[derive(Debug)]
pub struct Turning<'m> {
    mesh: &'m TriMesh,
    surface: &'m Surface,
    tree: FaceTree,
    size: f64,
}

impl<'m> Turning<'m> {
    /// For a mesh and its surface.
    #[must_use]
    pub fn new(mesh: &'m TriMesh, surface: &'m Surface) -> Self {
        let size = mesh.bounding_box().map_or(0.0, |bounds| bounds.diagonal());
        Self { mesh, surface, tree: FaceTree::new(mesh), size }
    }

    /// Whether the normal of a face is opposite to the normal of the surface, and of all of the surface near by.
    ///
    /// `error` is the largest distance of the result from the surface. Near by is twice as far.
    #[must_use]
    pub fn is_turned(&self, [a, b, c]: [DVec3; 3], error: f64) -> bool {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let reach = 2.0 * error + 1e-9 * self.size;
        let unit = |face: FaceId| self.mesh.face_cross(face).normalize_or_zero();
        normal != DVec3::ZERO
            && samples([a, b, c]).iter().all(|&sample| {
                let nearest = self.surface.closest(sample).face;
                let near = BoundingBox { min: sample - reach, max: sample + reach };
                unit(nearest).dot(normal) < OPPOSITE
                    && self
                        .tree
                        .find(self.mesh, near, |other| {
                            let bounds = BoundingBox::of_triangle(self.mesh.triangle(other));
                            bounds.meets(near) && unit(other).dot(normal) > 0.0
                        })
                        .is_none()
            })
    }

    /// The largest distance of the points of a face at which [`Turning::is_turned`] looks.
    #[must_use]
    pub fn distance(&self, corners: [DVec3; 3]) -> f64 {
        samples(corners).map(|sample| self.surface.distance(sample)).into_iter().fold(0.0, f64::max)
    }
}

/// The centre of a triangle, and a point towards each corner.
fn samples([a, b, c]: [DVec3; 3]) -> [DVec3; 4] {
    [(a + b + c) / 3.0, 0.6 * a + 0.2 * (b + c), 0.6 * b + 0.2 * (a + c), 0.6 * c + 0.2 * (a + b)]
}
