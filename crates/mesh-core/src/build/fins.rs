//! Which faces stay joined at an edge of more than two faces.
//!
//! A wall that stands on a floor has three faces at each edge of its foot: two of the floor, one of the wall. Two of
//! them can stay joined, and it should be the floor. So closed parts stay whole where they can. Of the others, a part
//! that goes on around the end of the foot comes before one that ends there, and what runs straight on before what
//! bends.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::build::edges::{EdgeTable, across, edge_ends, proper_pair, same_direction};
use crate::topology::disjoint_sets::DisjointSets;
use crate::topology::pairing::side_ends;

/// At edges of more faces, bends do not count: comparing each face with each would take too long.
const MOST_COMPARED: usize = 32;

/// The parts of a surface, joined along edges of two faces.
pub(crate) struct Parts {
    of: DisjointSets,
    /// Per part, by its smallest face: whether it has an edge of one face.
    is_open: Vec<bool>,
    /// Per two parts, the sum of [`bend`] times the length over the edges where they meet, and the sum of the lengths.
    bends: BTreeMap<[u32; 2], [f64; 2]>,
}

impl Parts {
    pub(crate) fn new(
        position: impl Fn(u32) -> DVec3,
        triangles: &[[u32; 3]],
        edges: &EdgeTable,
    ) -> Self {
        let mut of = DisjointSets::new(triangles.len());
        for [a, b] in edges.iter().filter_map(|edge| proper_pair(triangles, edge)) {
            of.union(a / 3, b / 3);
        }
        let mut is_open = vec![false; triangles.len()];
        for edge in edges.iter().filter(|edge| edge.len() == 1) {
            is_open[of.find(edge[0] / 3) as usize] = true;
        }
        let mut bends: BTreeMap<_, [f64; 2]> = BTreeMap::new();
        for edge in edges.iter().filter(|edge| (3..=MOST_COMPARED).contains(&edge.len())) {
            let [from, to] = edge_ends(triangles, edge[0]);
            let length = position(from).distance(position(to));
            let (more, fewer) = by_direction(triangles, edge);
            for (&a, &b) in more.iter().flat_map(|a| fewer.iter().map(move |b| (a, b))) {
                let [sum, total] = bends.entry(parts_of(&mut of, a, b)).or_default();
                *sum += bend(&position, triangles, a, b) * length;
                *total += length;
            }
        }
        Self { of, is_open, bends }
    }

    /// Groups of the sides of an edge that stay joined among themselves, each with as many sides along the edge as
    /// back: first the closed parts if they go up in pairs, then the others.
    pub(crate) fn groups(&mut self, triangles: &[[u32; 3]], edge: &[u32]) -> [Vec<u32>; 2] {
        let (open, closed): (Vec<u32>, Vec<u32>) =
            edge.iter().partition(|&&side| self.is_open[self.of.find(side / 3) as usize]);
        let (along, back) = by_direction(triangles, &closed);
        if along.len() == back.len() {
            [closed, self.without_fins(triangles, &open)]
        } else {
            [self.without_fins(triangles, edge), Vec::new()]
        }
    }

    /// The sides without those that find no partner.
    fn without_fins(&mut self, triangles: &[[u32; 3]], sides: &[u32]) -> Vec<u32> {
        let (more, mut kept) = by_direction(triangles, sides);
        let mut parts: Vec<u32> = kept.iter().map(|&side| self.of.find(side / 3)).collect();
        parts.sort_unstable();
        let compared = if sides.len() <= MOST_COMPARED { kept.clone() } else { Vec::new() };
        let mut ranked: Vec<(bool, bool, f64, u32)> = more
            .iter()
            .map(|&side| {
                let part = self.of.find(side / 3);
                let goes_on = parts.binary_search(&part).is_ok();
                let bends = compared.iter().map(|&other| {
                    let found = self.bends.get(&parts_of(&mut self.of, side, other));
                    let [sum, length] = found.copied().unwrap_or_default();
                    sum / length
                });
                (self.is_open[part as usize], !goes_on, bends.fold(f64::INFINITY, f64::min), side)
            })
            .collect();
        ranked.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
        kept.extend(ranked.iter().take(kept.len()).map(|&(.., side)| side));
        kept
    }
}

/// The parts of two sides, smaller first.
fn parts_of(parts: &mut DisjointSets, a: u32, b: u32) -> [u32; 2] {
    let (a, b) = (parts.find(a / 3), parts.find(b / 3));
    [a.min(b), a.max(b)]
}

/// Sides of one edge by direction, the more frequent direction first.
fn by_direction(triangles: &[[u32; 3]], sides: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let (with_first, against): (Vec<u32>, Vec<u32>) =
        sides.iter().partition(|&&side| same_direction(triangles, sides[0], side));
    if with_first.len() < against.len() { (against, with_first) } else { (with_first, against) }
}

/// The cosine of the angle between two faces at an edge: -1 if the surface runs straight on.
fn bend(position: impl Fn(u32) -> DVec3, triangles: &[[u32; 3]], a: u32, b: u32) -> f64 {
    let [from, to] = side_ends(triangles, a).map(&position);
    let axis = (to - from).normalize_or_zero();
    let arm = |side| across(&position, triangles, side, from, axis).normalize_or_zero();
    arm(a).dot(arm(b))
}
