//! Proofs that faces of a mesh are close enough to the original at all their points.
//!
//! Where the two surfaces are height fields over each other, checks of vertices and edges are enough
//! ([`distance_constraint`](crate::tolerance::distance_constraint)). Elsewhere, which is rare, the middle of a face may
//! be too far away. So a mesh is first collapsed without proofs. The faces that cannot be proved afterwards mark the
//! places where the next attempt needs proofs.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh, as_u32, parallel};
use mesh_metric::{CertifyOptions, Surface, one_sided_bounds};

use crate::tolerance::prepared_triangle::Triangle;

/// Which collapses need proofs of their new faces.
#[derive(Clone, Copy)]
pub(super) enum Proofs<'a> {
    None,
    /// Collapses near one of these places.
    Near(&'a [Ball]),
    All,
}

/// A ball around a face that is not proved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ball {
    center: DVec3,
    radius: f64,
}

/// The number of pieces of faces after which an undecided group counts as too far away.
const MAX_PIECES: usize = 3000;

/// The number of faces that are proved as a group. If the proof fails, each face is proved by itself.
const TOGETHER: usize = 16;

impl Proofs<'_> {
    /// Whether the faces around the vertex `hub` need proofs; `rim` are their other corners.
    pub(super) fn are_needed(&self, hub: DVec3, rim: &[DVec3]) -> bool {
        match self {
            Self::None => false,
            Self::All => true,
            Self::Near(places) => {
                let far = rim.iter().map(|p| p.distance_squared(hub)).fold(0.0, f64::max).sqrt();
                places.iter().any(|place| place.center.distance(hub) <= place.radius + far)
            }
        }
    }
}

impl Ball {
    pub(super) fn round(triangle: Triangle) -> Self {
        let center = triangle.iter().sum::<DVec3>() / 3.0;
        let distances = triangle.map(|corner| corner.distance(center));
        Self { center, radius: distances.into_iter().fold(0.0, f64::max) }
    }
}

/// For each face of a mesh, by index, whether it may be within a distance of one of some triangles.
pub(super) fn faces_near(mesh: &TriMesh, triangles: &[Triangle], distance: f64) -> Vec<bool> {
    let mut near = vec![false; mesh.topology().face_capacity()];
    if let Some(surface) = surface_of(triangles) {
        let faces: Vec<FaceId> = mesh.topology().faces().collect();
        let balls: Vec<Ball> = faces.iter().map(|&face| Ball::round(mesh.triangle(face))).collect();
        let centers: Vec<DVec3> = balls.iter().map(|ball| ball.center).collect();
        for ((face, ball), closest) in faces.iter().zip(balls).zip(surface.closest_points(&centers))
        {
            near[face.index()] = closest.distance <= distance + ball.radius;
        }
    }
    near
}

/// Triangles as a surface; `None` without triangles.
fn surface_of(triangles: &[Triangle]) -> Option<Surface> {
    let corners: Vec<[u32; 3]> =
        (0..as_u32(triangles.len())).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Surface::from_triangles(triangles.as_flattened(), &corners).ok()
}

/// Whether every point of the faces is proved to be within the distance of the original.
pub(super) fn are_proved(faces: &[Triangle], original: &Surface, distance: f64) -> bool {
    let Some(surface) = surface_of(faces) else {
        return false;
    };
    let options = CertifyOptions {
        limit: Some(distance),
        max_pieces: MAX_PIECES,
        ..CertifyOptions::default()
    };
    one_sided_bounds(&surface, original, &options).upper <= distance
}

/// The faces of a mesh that are not proved to be within the distance of a surface.
pub(super) fn unproved(mesh: &TriMesh, surface: &Surface, distance: f64) -> Vec<Triangle> {
    let faces: Vec<FaceId> = mesh.topology().faces().collect();
    let some: Vec<&[FaceId]> = faces.chunks(TOGETHER).collect();
    let unproved = parallel::collect_each(some.len(), |i| -> Vec<Triangle> {
        let triangles: Vec<Triangle> = some[i].iter().map(|&face| mesh.triangle(face)).collect();
        if are_proved(&triangles, surface, distance) {
            return Vec::new();
        }
        triangles.into_iter().filter(|&face| !are_proved(&[face], surface, distance)).collect()
    });
    unproved.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_shapes::Plane;

    /// Two triangles form a square. The original rises to a peak above the middle of one of them, away from vertices
    /// and edges.
    #[test]
    fn a_face_that_is_too_far_in_its_middle_is_found_and_what_comes_near_it() {
        let plane = |cells: usize| {
            let soup = Plane { half_width: 1.0 }.mesh(cells, Default::default()).unwrap();
            TriMesh::from_soup(&soup).unwrap()
        };
        let (square, mut hill) = (plane(1), plane(60));
        let one = square.triangle(FaceId::new(0));
        let middle = one.iter().sum::<DVec3>() / 3.0;
        for p in hill.positions_mut() {
            p.z = (0.2 - 0.5 * p.distance(middle)).max(0.0);
        }
        let original = Surface::new(&hill).unwrap();
        assert!(unproved(&square, &original, 0.21).is_empty());
        assert_eq!(unproved(&square, &original, 0.1), [one]);
        let places = [Ball::round(one)];
        let far = middle + 9.0 * DVec3::X;
        let near = Proofs::Near(&places);
        assert!(one.iter().all(|&corner| near.are_needed(corner, &[])));
        assert!(near.are_needed(far, &[far + DVec3::X, middle]));
        assert!(!near.are_needed(far, &[far + DVec3::X]));
        assert!(Proofs::All.are_needed(far, &[]) && !Proofs::None.are_needed(middle, &[far]));
    }
}
