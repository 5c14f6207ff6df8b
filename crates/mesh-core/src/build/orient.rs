//! Consistent orientation of the faces of a soup.

use crate::build::edges::{EdgeTable, NONE, same_direction};
use crate::index::as_u32;

/// Which triangles to reverse, and the conflicts that remain.
pub(crate) struct Orientation {
    /// Per triangle, whether to reverse it.
    pub(crate) flipped: Vec<bool>,
    /// The two sides of each edge whose faces still disagree.
    pub(crate) conflicts: Vec<[u32; 2]>,
}

/// Orients faces consistently across all edges that have two faces.
///
/// Each part connected through such edges is traversed breadth-first from its first face. The majority of its
/// faces keeps its orientation; in a tie the first face does. A part that is not orientable keeps the given
/// orientation where that leaves fewer conflicts.
pub(crate) fn orient(triangles: &[[u32; 3]], edges: &EdgeTable) -> Orientation {
    let mut across = vec![NONE; 3 * triangles.len()];
    for edge in edges.iter() {
        if let &[a, b] = edge {
            across[a as usize] = b;
            across[b as usize] = a;
        }
    }
    let mut flipped = vec![false; triangles.len()];
    let mut seen = vec![false; triangles.len()];
    let mut conflicts = Vec::new();
    let mut part = Vec::new();
    for seed in 0..triangles.len() {
        if seen[seed] {
            continue;
        }
        collect_part(triangles, &across, seed, &mut part, &mut seen, &mut flipped);
        settle_part(triangles, &across, &part, &mut flipped, &mut conflicts);
    }
    Orientation { flipped, conflicts }
}

/// Collects the faces reachable from `seed` and decides which to reverse to agree with it.
fn collect_part(
    triangles: &[[u32; 3]],
    across: &[u32],
    seed: usize,
    part: &mut Vec<u32>,
    seen: &mut [bool],
    flipped: &mut [bool],
) {
    part.clear();
    part.push(as_u32(seed));
    seen[seed] = true;
    let mut read = 0;
    while read < part.len() {
        let face = part[read];
        read += 1;
        for side in 3 * face..3 * face + 3 {
            let opposite = across[side as usize];
            if opposite == NONE || seen[opposite as usize / 3] {
                continue;
            }
            let neighbour = opposite / 3;
            seen[neighbour as usize] = true;
            flipped[neighbour as usize] =
                flipped[face as usize] ^ same_direction(triangles, side, opposite);
            part.push(neighbour);
        }
    }
}

/// Lets the majority of the part's faces keep its orientation and lists the conflicts left over.
fn settle_part(
    triangles: &[[u32; 3]],
    across: &[u32],
    part: &[u32],
    flipped: &mut [bool],
    conflicts: &mut Vec<[u32; 2]>,
) {
    let inner_edges = || {
        part.iter().flat_map(|&face| 3 * face..3 * face + 3).filter_map(|side| {
            let opposite = across[side as usize];
            (opposite != NONE && side < opposite).then_some([side, opposite])
        })
    };
    let given = |&[a, b]: &[u32; 2]| same_direction(triangles, a, b);
    let after = |flipped: &[bool], edge: &[u32; 2]| {
        given(edge) ^ flipped[edge[0] as usize / 3] ^ flipped[edge[1] as usize / 3]
    };
    let left = inner_edges().filter(|edge| after(flipped, edge)).count();
    if left > 0 && inner_edges().filter(given).count() <= left {
        part.iter().for_each(|&face| flipped[face as usize] = false);
    }
    let reversed = part.iter().filter(|&&face| flipped[face as usize]).count();
    if 2 * reversed > part.len() {
        part.iter().for_each(|&face| flipped[face as usize] ^= true);
    }
    if left > 0 {
        conflicts.extend(inner_edges().filter(|edge| after(flipped, edge)));
    }
}
