//! Bobenko's Willmore energy as a cost.

use dcurv::intersection_angle;
use glam::DVec3;

use super::edge_term::EdgeTerm;

/// The Willmore energy `W = sum over vertices of (sum of beta(e) - 2 pi)` (BAR06 sec. 2), up to a
/// constant: twice the sum of `beta(e)` over all interior edges.
///
/// BAR06 does not minimise W directly because `beta` is equal for an edge and its flipped edge. But a
/// flip changes the triangles at the four sides and so their angles: W does change. Unlike the virtual
/// energy of the paper, W is a true potential, so greedy descent terminates. No unit. On closed meshes
/// it is [`dcurv::total_willmore_energy`] plus `2 pi` per vertex.
///
/// Shape constraint: [`KeepShape`](crate::ShapeConstraint::KeepShape), as for
/// [`VirtualWillmore`](crate::VirtualWillmore).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Willmore;

impl EdgeTerm for Willmore {
    const LENGTH_EXPONENT: i32 = 0;

    #[inline]
    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64 {
        2.0 * intersection_angle(a, b, left, right)
    }
}
