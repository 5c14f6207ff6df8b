//! Test points of a patch, and their distances from the mesh.

use core::f64::consts::TAU;

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};

use crate::closest::{Feature, closest_point};
use crate::patch::Patch;

/// Number of angles of the full test, by default.
pub(crate) const TEST_ANGLES: u32 = 16;

/// Sines and cosines of evenly spaced angles.
#[derive(Clone, Debug, Default)]
pub(crate) struct TestAngles(Vec<[f64; 2]>);

impl TestAngles {
    pub(crate) fn new(count: u32) -> Self {
        let angle = |j: u32| TAU * f64::from(j) / f64::from(count);
        Self((0..count).map(|j| angle(j).sin_cos().into()).collect())
    }

    /// Changes the number of angles.
    pub(crate) fn set_count(&mut self, count: u32) {
        if self.0.len() != count as usize {
            *self = Self::new(count);
        }
    }

    /// The points of the full test, u = 1 and u = 1/2, in the frame of the patch.
    pub(crate) fn full_test<'t>(&'t self, patch: &'t Patch) -> impl Iterator<Item = DVec3> + 't {
        self.ring(patch, 1.0).chain(self.ring(patch, 0.5))
    }

    /// The points with parameter `u`, in the frame of the patch.
    pub(crate) fn ring<'t>(&'t self, patch: &'t Patch, u: f64) -> impl Iterator<Item = DVec3> + 't {
        let arms = patch.arms(u);
        self.0.iter().map(move |&[sin, cos]| patch.point_of_arms(arms, sin, cos))
    }
}

/// The ends of both principal arcs, in the frame of the patch: where SN10 (section 3) measures the
/// error that determines the size.
pub(crate) fn arc_ends(patch: &Patch) -> impl Iterator<Item = DVec3> + '_ {
    (0..4).map(|j| patch.local_point(1.0, 0.25 * TAU * f64::from(j)))
}

/// A test point with its distances from the faces measured so far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TestPoint {
    pub(crate) at: DVec3,
    pub(crate) distance: f64,
    /// The distance from the nearest face whose closest point is on the boundary of the mesh.
    to_boundary: f64,
}

impl TestPoint {
    pub(crate) fn new(at: DVec3) -> Self {
        Self { at, distance: f64::INFINITY, to_boundary: f64::INFINITY }
    }

    /// The error at this point. With `overhang` it is 0 beyond the boundary.
    ///
    /// A point is beyond the boundary if the boundary is as near as any face. This holds in any order of
    /// the faces, also if the boundary is part of another sheet of the surface.
    pub(crate) fn error(&self, overhang: bool) -> f64 {
        let is_beyond = self.to_boundary <= BOUNDARY_SLACK * self.distance;
        if overhang && is_beyond { 0.0 } else { self.distance }
    }
}

/// Rounding slack for the comparison with the distance from the boundary.
const BOUNDARY_SLACK: f64 = 1.0 + 1e-12;

/// A face that distances are measured from.
pub(crate) struct MeasuredFace<'a> {
    mesh: &'a TriMesh,
    face: FaceId,
    corners: [DVec3; 3],
    /// Square of the largest distance from the first corner to another corner.
    square_size: f64,
}

impl<'a> MeasuredFace<'a> {
    pub(crate) fn new(mesh: &'a TriMesh, face: FaceId, corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let square_size = a.distance_squared(b).max(a.distance_squared(c));
        Self { mesh, face, corners, square_size }
    }

    /// Updates the distances of a test point.
    #[inline]
    pub(crate) fn measure(&self, point: &mut TestPoint) {
        // (a + b)² ≤ 2 (a² + b²), with slack for rounding and for an equally near boundary.
        let square_reach = 2.000_001 * (point.distance * point.distance + self.square_size);
        if point.at.distance_squared(self.corners[0]) > square_reach {
            return;
        }
        let (closest, feature) = closest_point(point.at, self.corners);
        let distance = closest.distance(point.at);
        point.distance = point.distance.min(distance);
        if distance < point.to_boundary && self.is_on_boundary(feature) {
            point.to_boundary = distance;
        }
    }

    fn is_on_boundary(&self, feature: Feature) -> bool {
        let (topology, face) = (self.mesh.topology(), self.face);
        match feature {
            Feature::Corner(i) => topology.is_boundary_vertex(topology.face_vertices(face)[i]),
            Feature::Side(i) => topology.is_boundary_edge(topology.face_half_edges(face)[i].edge()),
            Feature::Inside => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A boundary face and a ridge of two faces share an edge in space, but not in the mesh.
    #[test]
    fn a_boundary_on_another_sheet_counts_in_any_order_of_faces() {
        let points: [[f64; 3]; 7] = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.5, 1.0, 0.0],
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.5, 1.0, -2.0],
            [0.5, -1.0, -2.0],
        ];
        let mesh = TriMesh::from_triangles(&points, &[[0, 1, 2], [3, 4, 5], [4, 3, 6]]).unwrap();
        let mut faces: Vec<FaceId> = mesh.topology().faces().collect();
        let measured = |faces: &[FaceId], at: DVec3| {
            let mut point = TestPoint::new(at);
            for &face in faces {
                MeasuredFace::new(&mesh, face, mesh.triangle(face)).measure(&mut point);
            }
            point
        };
        for _ in 0..2 {
            let point = measured(&faces, DVec3::new(0.5, -0.1, 0.5));
            let distance = 0.26_f64.sqrt();
            assert!((point.error(false) - distance).abs() < 1e-15, "{point:?}");
            assert_eq!(point.error(true), 0.0, "{point:?}");
            faces.reverse();
        }
        // A point nearer to the other sheet is not beyond the boundary.
        let point = measured(&faces, DVec3::new(0.5, -0.5, 0.0));
        assert!(point.error(true) > 0.2, "{point:?}");
    }
}
