//! The partition of the vertices into blocks: pieces of space with equal numbers of vertices.
//!
//! Each piece is halved across its longest side, at the median of its vertices. Each pass uses other directions than
//! the one before, so that its block borders cross the earlier ones. The pieces depend only on the positions.

use glam::{DMat3, DVec3};
use mesh_core::as_u32;
use mesh_core::parallel;

use crate::blocks::flat_mesh::FlatMesh;

/// The vertices of a flat mesh in blocks of equal size; only the last may be smaller.
#[derive(Clone, Debug)]
pub struct Partition {
    /// The vertices, block by block, without the held ones.
    order: Vec<u32>,
    /// The place of each vertex in this order; for held vertices, a number far beyond its end.
    rank: Vec<u32>,
    /// The binary logarithm of the number of vertices of each block.
    shift: u32,
    /// The faces with all corners in one block, block by block.
    inner: Lists,
    /// The faces with some corners in each block, block by block.
    mixed: Lists,
}

/// Lists of faces, one after the other.
#[derive(Clone, Debug)]
struct Lists {
    faces: Vec<u32>,
    /// The start of each list, and the end of the last one.
    starts: Vec<u32>,
}

impl Lists {
    /// Builds `lists` lists from pairs of a face and the number of its list. The iterator is run twice, and must give
    /// the same order.
    fn new<I: Iterator<Item = (u32, usize)>>(lists: usize, faces: impl Fn() -> I) -> Self {
        let mut starts = vec![0; lists + 1];
        faces().for_each(|(_, list)| starts[list] += 1);
        let mut total = 0;
        for start in &mut starts {
            total += core::mem::replace(start, total);
        }
        let mut sorted = vec![0; total as usize];
        let mut place = starts.clone();
        for (face, list) in faces() {
            sorted[place[list] as usize] = face;
            place[list] += 1;
        }
        Self { faces: sorted, starts }
    }

    fn get(&self, list: usize) -> &[u32] {
        &self.faces[self.starts[list] as usize..self.starts[list + 1] as usize]
    }
}

/// A vertex and its coordinates in the directions of the pass.
#[derive(Clone, Copy, Debug)]
struct Site {
    at: [f32; 3],
    vertex: u32,
}

/// Marks of faces with corners in several blocks, and of faces in no block.
const MIXED: u32 = u32::MAX;
const GONE: u32 = u32::MAX - 1;

/// The binary logarithm of the number of vertices of a block, which fits into the cache of one core.
const REGION: u32 = 12;
/// The binary logarithm of the size of a block that holds everything.
const WHOLE: u32 = 31;

impl FlatMesh<'_> {
    /// The blocks of a pass, of 4096 vertices each.
    #[must_use]
    pub fn partition(&self, pass: usize) -> Partition {
        Partition::new(self, REGION, pass)
    }
}

impl Partition {
    /// A partition with a single block.
    pub(super) fn whole(flat: &FlatMesh<'_>) -> Self {
        Self::new(flat, WHOLE, 0)
    }

    /// The blocks of 2^`shift` vertices in pass `pass`.
    fn new(flat: &FlatMesh<'_>, shift: u32, pass: usize) -> Self {
        let directions = directions(pass);
        let center = flat.vertices().next().map_or(DVec3::ZERO, |v| flat.positions[v as usize]);
        let site = |vertex: u32| {
            let at = directions * (flat.positions[vertex as usize] - center);
            Site { at: at.as_vec3().to_array(), vertex }
        };
        let mut sites: Vec<Site> = flat.own_vertices().map(site).collect();
        halve(&mut sites, 1 << shift);
        let order: Vec<u32> = sites.into_iter().map(|site| site.vertex).collect();
        let mut rank = vec![u32::MAX; flat.vertex_capacity()];
        for (place, &v) in order.iter().enumerate() {
            rank[v as usize] = as_u32(place);
        }
        let blocks = order.len().div_ceil(1 << shift);
        let blocks_of =
            |face: usize| flat.triangle(face).map(|t| t.map(|v| rank[v as usize] >> shift));
        let tags = parallel::collect(flat.face_capacity(), |face| match blocks_of(face) {
            Some([a, b, c]) if a == b && b == c && (a as usize) < blocks => a,
            Some([a, b, c]) if (a.min(b).min(c) as usize) < blocks => MIXED,
            _ => GONE,
        });
        let of_face = || tags.iter().enumerate().map(|(face, &tag)| (as_u32(face), tag));
        let in_one =
            || of_face().filter(|&(_, tag)| tag < GONE).map(|(face, tag)| (face, tag as usize));
        let several = || of_face().filter(|&(_, tag)| tag == MIXED).map(|(face, _)| face);
        let in_each = || {
            several().flat_map(|face| {
                let [a, b, c] = blocks_of(face as usize).unwrap_or_default();
                let others = [(b != a).then_some(b), (c != a && c != b).then_some(c)];
                let all = core::iter::once(a).chain(others.into_iter().flatten());
                // Held vertices are in no block.
                all.filter(|&block| (block as usize) < blocks)
                    .map(move |block| (face, block as usize))
            })
        };
        let (inner, mixed) =
            parallel::both(|| Lists::new(blocks, in_one), || Lists::new(blocks, in_each));
        Self { order, rank, shift, inner, mixed }
    }

    /// The number of blocks.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.order.len().div_ceil(1 << self.shift)
    }

    /// One block in `one_in`, but at least `fewest`, in ascending order, evenly spread, and none at the ends.
    pub(super) fn some(&self, one_in: usize, fewest: usize) -> Vec<usize> {
        evenly(self.blocks(), one_in, fewest)
    }

    /// The place in the order at which a block starts.
    pub(super) fn first(&self, block: usize) -> usize {
        block << self.shift
    }

    /// The vertices of a block.
    pub(super) fn vertices(&self, block: usize) -> &[u32] {
        let end = self.order.len().min((block + 1) << self.shift);
        &self.order[self.first(block)..end]
    }

    /// The faces with all corners in a block.
    pub(super) fn inner(&self, block: usize) -> &[u32] {
        self.inner.get(block)
    }

    /// The faces with some, but not all, corners in a block.
    pub(super) fn mixed(&self, block: usize) -> &[u32] {
        self.mixed.get(block)
    }

    pub(super) fn rank(&self, v: u32) -> u32 {
        self.rank[v as usize]
    }

    pub(super) fn block_of(&self, v: u32) -> usize {
        (self.rank[v as usize] >> self.shift) as usize
    }
}

fn evenly(of: usize, one_in: usize, fewest: usize) -> Vec<usize> {
    let count = of.div_ceil(one_in.max(1)).max(of.min(fewest));
    (0..count).map(|i| (2 * i + 1) * of / (2 * count)).collect()
}

/// Orthogonal directions, different in every pass.
fn directions(pass: usize) -> DMat3 {
    // The first thousand are all different.
    let angle = 0.785 * pass as f64;
    DMat3::from_rotation_z(angle) * DMat3::from_rotation_x(0.6 * angle)
}

/// Sorts the sites so that the sites of each block are consecutive.
fn halve(sites: &mut [Site], size: usize) {
    let blocks = sites.len().div_ceil(size);
    if blocks < 2 {
        return;
    }
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for site in &*sites {
        for i in 0..3 {
            low[i] = low[i].min(site.at[i]);
            high[i] = high[i].max(site.at[i]);
        }
    }
    let axis =
        (1..3).fold(
            0,
            |longest, i| {
                if high[i] - low[i] > high[longest] - low[longest] { i } else { longest }
            },
        );
    let middle = blocks / 2 * size;
    // Sites with equal coordinates are sorted by vertex.
    sites.select_nth_unstable_by(middle, |a, b| {
        a.at[axis].total_cmp(&b.at[axis]).then(a.vertex.cmp(&b.vertex))
    });
    let (left, right) = sites.split_at_mut(middle);
    parallel::both(|| halve(left, size), || halve(right, size));
}

#[cfg(test)]
mod tests {
    use super::{Site, evenly, halve};

    #[test]
    fn blocks_are_cut_across_their_longest_side() {
        for axis in 0..3 {
            let site = |vertex: u32| {
                let mut at = [(vertex % 2) as f32, (vertex % 3) as f32, (vertex % 5) as f32];
                at[axis] = (vertex * 7 % 60) as f32;
                Site { at, vertex }
            };
            let mut sites: Vec<Site> = (0..60).map(site).collect();
            halve(&mut sites, 30);
            let is_first = |site: &Site| site.at[axis] < 30.0;
            assert!(
                sites[..30].iter().all(is_first) && !sites[30..].iter().any(is_first),
                "{axis}"
            );
        }
    }

    #[test]
    fn some_of_all_are_spread_evenly() {
        assert_eq!(evenly(0, 16, 2), []);
        assert_eq!(evenly(1, 16, 2), [0]);
        assert_eq!(evenly(2, 16, 2), [0, 1]);
        assert_eq!(evenly(8, 16, 2), [2, 6]);
        assert_eq!(evenly(16, 16, 3), [2, 8, 13]);
        assert_eq!(evenly(48, 16, 2), [8, 24, 40]);
        for (of, one_in, fewest) in [(49, 16, 2), (1000, 16, 3), (7, 1, 2), (9, 0, 1)] {
            let some = evenly(of, one_in, fewest);
            assert_eq!(some.len(), of.div_ceil(one_in.max(1)));
            let gaps: Vec<usize> = some.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let gap = of / some.len();
            assert!(gaps.iter().all(|&g| (gap..=gap + 1).contains(&g)), "{of}: {some:?}");
            // The gap at each end is half of the gap between two.
            let ends = [some[0], of - 1 - some[some.len() - 1]];
            assert!(ends.iter().all(|&end| 2 * end <= gap + 1 && 2 * end + 2 >= gap), "{some:?}");
        }
    }
}
