//! Bobenko's Willmore energy as a cost of its own.

use dcurv::intersection_angle;
use glam::DVec3;

use super::edge_term::EdgeTerm;

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
    const LENGTH_EXPONENT: i32 = 0;

    #[inline]
    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64 {
        2.0 * intersection_angle(a, b, left, right)
    }
}
