//! What a cost that is a sum over edges has to say: the term of one edge.

use glam::DVec3;

/// The term of one edge, from `a`, `b`, the left apex and the right apex.
pub(crate) trait EdgeTerm: Sync + Sized {
    /// The power of a length that a term has as its unit.
    const LENGTH_EXPONENT: i32;

    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64;
}
