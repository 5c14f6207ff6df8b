//! Triangles with the same three vertices.

use crate::build::edges::{EdgeTable, NONE, edge_ends, previous};
use crate::build::touching::is_closed_around;
use crate::index::as_u32;
use crate::topology::disjoint_sets::DisjointSets;

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

/// The duplicates that are no walls. A wall is where closed parts lie on each other with the same triangles: two copies of
/// each, which face opposite ways. All along its rim there are other faces, and with both copies as many sides run along
/// each edge as back. (A sheet that is given once per side has an edge with no other faces.)
pub(crate) fn without_walls(
    duplicates: &[Duplicate],
    triangles: &[[u32; 3]],
    edges: &EdgeTable,
) -> Vec<Duplicate> {
    // Per face that faces the opposite way as its only copy, the number of the pair.
    let mut pair = vec![NONE; triangles.len()];
    let mut copies = vec![0_u8; triangles.len()];
    for Duplicate { original, .. } in duplicates {
        let copies = &mut copies[*original as usize];
        *copies = copies.saturating_add(1);
    }
    for (number, &Duplicate { face, original }) in duplicates.iter().enumerate() {
        let [a, b] = [original, face].map(|face| triangles[face as usize]);
        let is_reversed = (0..3).any(|k| a == [b[(k + 2) % 3], b[(k + 1) % 3], b[k]]);
        if is_reversed && copies[original as usize] == 1 {
            pair[face as usize] = as_u32(number);
            pair[original as usize] = as_u32(number);
        }
    }
    let mut sheets = DisjointSets::new(duplicates.len());
    for edge in edges.iter().filter(|edge| edge.len() > 2) {
        let pairs =
            || edge.iter().map(|&side| pair[side as usize / 3]).filter(|&pair| pair != NONE);
        pairs().zip(pairs().skip(1)).for_each(|(a, b)| sheets.union(a, b));
    }
    let (mut is_held, mut is_torn) = (vec![false; duplicates.len()], vec![false; duplicates.len()]);
    for edge in edges.iter() {
        let of = |side: &u32| pair[*side as usize / 3];
        let Some(doubled) = edge.iter().map(of).find(|&pair| pair != NONE) else { continue };
        let is_rim = edge.len() == 2 || edge.iter().map(of).any(|pair| pair == NONE);
        if is_rim {
            let sheet = sheets.find(doubled) as usize;
            let list = if is_closed_around(triangles, edge) { &mut is_held } else { &mut is_torn };
            list[sheet] = true;
        }
    }
    let mut is_wall = |&Duplicate { face, .. }: &Duplicate| match pair[face as usize] {
        NONE => false,
        pair => {
            let sheet = sheets.find(pair) as usize;
            is_held[sheet] && !is_torn[sheet]
        }
    };
    duplicates.iter().copied().filter(|duplicate| !is_wall(duplicate)).collect()
}
