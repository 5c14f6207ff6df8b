//! The term of one edge, for costs that are sums over edges.

use glam::DVec3;
use mesh_core::TriMesh;

/// The term of one edge from `a` to `b`, with its left and right apex.
pub(crate) trait EdgeTerm: Sync + Sized {
    /// Unit of a term as a power of length.
    const LENGTH_EXPONENT: i32;
    /// Whether the term counts once for each interior end of the edge, instead of once.
    const COUNTS_AT_INTERIOR_ENDS: bool = false;

    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64;

    /// The rest of the total, which no flip changes.
    fn constant(&self, _mesh: &TriMesh) -> f64 {
        0.0
    }
}
