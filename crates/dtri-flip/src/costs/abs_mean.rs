//! F2: the absolute mean curvature.

use dcurv::dihedral_angle;
use glam::DVec3;
use mesh_core::{EdgeMap, TriMesh};

use super::edge_sum::EdgeTerm;
use crate::cost::{Change, FlipCost, Reach};
use crate::quad::Quad;

/// `F2 = sum over vertices of |Hbar|`, with `|Hbar| = 1/4 sum of |e| |beta|` (DHKL01 sec. 3).
///
/// Every edge between two triangles counts at both ends, so `F2 = 1/2 sum over edges of
/// |e| |beta|`, with the dihedral angles `beta`; boundary edges have none. In model units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AbsMean;

impl EdgeTerm for AbsMean {
    #[inline]
    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64 {
        0.5 * a.distance(b) * dihedral_angle(a, b, left, right).abs()
    }
}

impl FlipCost for AbsMean {
    type Cache = EdgeMap<f64>;

    fn prepare(&self, mesh: &TriMesh) -> EdgeMap<f64> {
        self.all_terms(mesh)
    }

    fn update(&self, mesh: &TriMesh, cache: &mut EdgeMap<f64>, flipped: &Quad) {
        self.update_terms(mesh, cache, flipped);
    }

    fn total(&self, mesh: &TriMesh) -> f64 {
        self.sum(mesh)
    }

    #[inline]
    fn change(&self, mesh: &TriMesh, cache: &EdgeMap<f64>, quad: &Quad) -> Change {
        self.change_of_terms(mesh, cache, quad)
    }

    #[inline]
    fn change_if_lower(&self, mesh: &TriMesh, cache: &EdgeMap<f64>, quad: &Quad) -> Option<Change> {
        self.lower_change_of_terms(mesh, cache, quad)
    }

    fn reach(&self) -> Reach {
        Reach::AdjacentTriangles
    }

    fn length_exponent(&self) -> i32 {
        1
    }
}
