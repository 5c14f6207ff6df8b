//! Triangles with the same three vertices.

use crate::build::edges::{EdgeTable, edge_ends, previous};

/// A triangle that repeats an earlier one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Duplicate {
    /// The triangle.
    pub(crate) face: u32,
    /// The first triangle with the same vertices.
    pub(crate) original: u32,
}

/// Every triangle that has the same vertices as an earlier one, in any order, sorted by triangle.
pub(crate) fn find_duplicates(triangles: &[[u32; 3]], edges: &EdgeTable) -> Vec<Duplicate> {
    let mut duplicates = Vec::new();
    let mut candidates: Vec<(u32, u32)> = Vec::new();
    for edge in edges.iter().filter(|edge| edge.len() > 1) {
        // Triangles with the same vertices share all their edges, so it is enough to look at the
        // edge of their two smallest vertices.
        candidates.clear();
        candidates.extend(edge.iter().filter_map(|&side| {
            let apex = triangles[side as usize / 3][previous(side) as usize % 3];
            let is_largest = edge_ends(triangles, side)[1] < apex;
            is_largest.then_some((apex, side / 3))
        }));
        candidates.sort_unstable();
        for same in candidates.chunk_by(|a, b| a.0 == b.0) {
            let original = same[0].1;
            duplicates.extend(same[1..].iter().map(|&(_, face)| Duplicate { face, original }));
        }
    }
    duplicates.sort_unstable_by_key(|duplicate| duplicate.face);
    duplicates
}
