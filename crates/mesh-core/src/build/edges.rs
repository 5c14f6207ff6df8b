//! The edges of triangles that need not be manifold.
//!
//! *Side* `3 f + k` of triangle `f` runs from its corner `k` to the next one. Corner `3 f + k` has
//! the same number, so a corner is where its side starts.

use glam::DVec3;

use crate::index::as_u32;
pub(crate) use crate::topology::pairing::next;
use crate::topology::pairing::{bucket_by_smaller_vertex, larger_end, side_ends};

/// Stands for no side, no fan, no element.
pub(crate) const NONE: u32 = u32::MAX;

/// The previous side of the triangle.
#[inline]
pub(crate) fn previous(side: u32) -> u32 {
    if side.is_multiple_of(3) { side + 2 } else { side - 1 }
}

/// The sides of triangles, grouped by the edge that they lie on.
pub(crate) struct EdgeTable {
    /// Sides; the sides of one edge are contiguous and ascending.
    sides: Vec<u32>,
    /// One past the last side of each edge.
    ends: Vec<u32>,
}

impl EdgeTable {
    /// Groups the sides of triangles whose indices are in range and which repeat no vertex. Edges
    /// come in order of their smaller, then of their larger vertex.
    pub(crate) fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let (starts, mut sides) = bucket_by_smaller_vertex(vertex_count, triangles);
        let larger = |side: u32| larger_end(triangles, side);
        let mut ends = Vec::with_capacity(sides.len() / 2 + 1);
        for bucket in starts.windows(2) {
            let (start, end) = (bucket[0] as usize, bucket[1] as usize);
            let sides = &mut sides[start..end];
            sides.sort_unstable_by_key(|&side| (larger(side), side));
            let mut edge_end = start;
            for edge in sides.chunk_by(|&a, &b| larger(a) == larger(b)) {
                edge_end += edge.len();
                ends.push(as_u32(edge_end));
            }
        }
        Self { sides, ends }
    }

    /// The sides of every edge.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let mut start = 0;
        self.ends.iter().map(move |&end| {
            let edge = &self.sides[start..end as usize];
            start = end as usize;
            edge
        })
    }
}

/// The ends of the edge that a side lies on, smaller index first.
pub(crate) fn edge_ends(triangles: &[[u32; 3]], side: u32) -> [u32; 2] {
    let [from, to] = side_ends(triangles, side);
    [from.min(to), from.max(to)]
}

/// Whether two sides of one edge run in the same direction.
pub(crate) fn same_direction(triangles: &[[u32; 3]], a: u32, b: u32) -> bool {
    side_ends(triangles, a)[0] == side_ends(triangles, b)[0]
}

/// How far the apex of a side's triangle lies from the side, as a vector; the side contains `origin` and runs along `axis`.
pub(crate) fn across(
    position: impl Fn(u32) -> DVec3,
    triangles: &[[u32; 3]],
    side: u32,
    origin: DVec3,
    axis: DVec3,
) -> DVec3 {
    let arm = position(triangles.as_flattened()[previous(side) as usize]) - origin;
    arm - arm.dot(axis) * axis
}

/// The edge's two sides, if there are two and they run in opposite directions.
pub(crate) fn proper_pair(triangles: &[[u32; 3]], edge: &[u32]) -> Option<[u32; 2]> {
    match *edge {
        [a, b] if !same_direction(triangles, a, b) => Some([a, b]),
        _ => None,
    }
}
