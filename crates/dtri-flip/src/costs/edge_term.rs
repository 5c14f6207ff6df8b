//! The term of one edge, for costs that are sums over edges.

use glam::DVec3;

/// The term of one edge from `a` to `b`, with its left and right apex.
pub(crate) trait EdgeTerm: Sync + Sized {
    /// Unit of a term as a power of length.
    const LENGTH_EXPONENT: i32;

    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64;
}
