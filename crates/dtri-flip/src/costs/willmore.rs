//! Bobenko's Willmore energy as a cost of its own.

use dcurv::intersection_angle;
use glam::DVec3;
use mesh_core::{EdgeMap, TriMesh};

use super::edge_sum::EdgeTerm;
use crate::cost::{Change, FlipCost, Reach};
use crate::quad::Quad;

/// The Willmore energy `W = sum over vertices of (sum of beta(e) - 2 pi)` itself (BAR06 sec. 2),
/// up to a constant: twice the sum of `beta(e)` over all edges between two triangles.
///
/// BAR06 does not flip by it because `beta` of the flipped edge is that of the edge. But a flip
/// gives the four sides other triangles, and so other angles: W does change. Other than the
/// virtual energy of the paper it is a true potential, so a greedy run ends by itself. Without
/// unit. On closed meshes it is [`dcurv::total_willmore_energy`] plus `2 pi` for each vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Willmore;

impl EdgeTerm for Willmore {
    #[inline]
    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64 {
        2.0 * intersection_angle(a, b, left, right)
    }
}

impl FlipCost for Willmore {
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
        0
    }
}
