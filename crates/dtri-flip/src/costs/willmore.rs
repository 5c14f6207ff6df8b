//! Bobenko's Willmore energy as a cost.

use core::f64::consts::TAU;

use dcurv::intersection_angle;
use glam::DVec3;
use mesh_core::TriMesh;

use super::edge_term::EdgeTerm;

/// The Willmore energy `W = sum over interior vertices of (sum of beta(e) - 2 pi)` (BAR06 sec. 2), as
/// [`dcurv::total_willmore_energy`].
///
/// BAR06 does not minimise W directly because `beta` is equal for an edge and its flipped edge. But a
/// flip changes the triangles at the four sides and so their angles: W does change. Unlike the virtual
/// energy of the paper, W is a true potential, so greedy descent terminates. No unit.
///
/// Boundary: a boundary edge has no `beta`, so a boundary vertex has no energy. An interior edge counts
/// once for each interior end.
///
/// Shape constraint: [`KeepShape`](crate::ShapeConstraint::KeepShape), as for
/// [`VirtualWillmore`](crate::VirtualWillmore).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Willmore;

impl EdgeTerm for Willmore {
    const LENGTH_EXPONENT: i32 = 0;
    const COUNTS_AT_INTERIOR_ENDS: bool = true;

    #[inline]
    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64 {
        intersection_angle(a, b, left, right)
    }

    fn constant(&self, mesh: &TriMesh) -> f64 {
        let topology = mesh.topology();
        let has_energy =
            |&v: &_| !topology.is_boundary_vertex(v) && !topology.is_isolated_vertex(v);
        -TAU * topology.vertices().filter(has_energy).count() as f64
    }
}
