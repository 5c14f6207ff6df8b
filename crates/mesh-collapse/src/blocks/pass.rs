//! The join of all blocks after a pass, and the order of their collapses.

use std::borrow::Cow;

use mesh_core::{HalfEdgeId, VertexId, as_u32, parallel};

use crate::blocks::block::{Block, Done, Reduced};
use crate::blocks::block_mesh::Step;
use crate::blocks::cost_threshold::{CostThreshold, Forecast};
use crate::blocks::flat_mesh::FlatMesh;
use crate::blocks::rules::Rules;
use crate::record::log::LogEntry;

/// The smallest number of faces that is cut into blocks. In a smaller mesh, block borders would be visible, the
/// collapse in one piece works across them, and sampling one of few blocks takes longer than it saves.
const FEWEST: usize = 75_000;
/// A pass leaves at least one in this many faces. With fewer, block borders would become visible.
const PASS: usize = 4;
/// The ratio to the wanted number of faces below which the mesh is collapsed in one piece.
const LAST: f64 = 1.25;
/// One in this many blocks is sampled.
pub(super) const FORECAST: usize = 16;
/// The smallest number of sampled blocks.
pub(super) const LEAST_ASKED: usize = 2;

/// The number of faces at which the collapse in one piece starts, for a target of `target` faces.
pub(super) fn last_piece(target: usize) -> usize {
    (LAST * target as f64) as usize
}

/// The number of faces that a pass should leave if the last pass leaves `end`; `None` if another pass is not
/// worthwhile. `fewest_again` is the smallest number of faces that is cut into blocks again.
pub(super) fn aim(pass: usize, faces: usize, end: usize, fewest_again: usize) -> Option<usize> {
    let fewest = if pass == 0 { FEWEST } else { fewest_again };
    let aim = end.max(faces / PASS);
    (faces >= fewest && 10 * aim <= 9 * faces).then_some(aim)
}

impl FlatMesh<'static> {
    /// Joins all blocks of a flat mesh, in the order in which they were cut out.
    #[must_use]
    pub fn join(blocks: Vec<Reduced>) -> Self {
        let largest = blocks.iter().flat_map(|block| &block.vertices).max();
        let capacity = largest.map_or(0, |&v| v as usize + 1);
        Self::join_all(blocks, capacity)
    }

    /// [`FlatMesh::join`] for a flat mesh with `capacity` vertices.
    fn join_all(blocks: Vec<Reduced>, capacity: usize) -> Self {
        let mut number = vec![u32::MAX; capacity];
        let left = blocks.iter().flat_map(|block| &block.vertices);
        for (new, &v) in left.enumerate() {
            number[v as usize] = as_u32(new);
        }
        let lists = blocks.into_iter().map(|block| {
            let Reduced { positions, quadrics, vertex_ids, .. } = block;
            let Reduced { triangles, face_ids, half_edges, .. } = block;
            ((triangles, face_ids, half_edges), (positions, quadrics, vertex_ids))
        });
        let (faces, vertices): (Vec<_>, Vec<_>) = lists.unzip();
        let (triangles, face_ids, half_edges): (Vec<_>, Vec<_>, Vec<_>) =
            faces.into_iter().collect();
        let (positions, quadrics, vertex_ids): (Vec<_>, Vec<_>, Vec<_>) =
            vertices.into_iter().collect();
        let of_faces = move || {
            let mut triangles = joined(triangles);
            parallel::update(&mut triangles, |_, t| *t = t.map(|corner| number[corner as usize]));
            (triangles, joined(face_ids), joined(half_edges))
        };
        let of_vertices = || (joined(positions), joined(quadrics), joined(vertex_ids));
        let ((triangles, face_ids, half_edges), (positions, quadrics, vertex_ids)) =
            parallel::both(of_faces, of_vertices);
        Self {
            whole: None,
            held: 0,
            positions: Cow::Owned(positions),
            quadrics,
            vertex_ids,
            triangles,
            face_ids,
            half_edges,
        }
    }
}

/// Concatenates lists. Each list is freed once it is copied, to save memory.
fn joined<T>(lists: Vec<Vec<T>>) -> Vec<T> {
    let mut all = Vec::with_capacity(lists.iter().map(Vec::len).sum());
    lists.into_iter().for_each(|mut list| all.append(&mut list));
    all
}

impl FlatMesh<'_> {
    /// The part that belongs to no block: the held vertices, and the faces whose corners are all held.
    fn idle(&self) -> Reduced {
        let first = as_u32(self.vertex_capacity() - self.held);
        let vertices: Vec<u32> = (first..first + as_u32(self.held)).collect();
        let faces = (0..as_u32(self.face_capacity())).filter_map(|face| {
            let triangle = self.triangle(face as usize)?;
            triangle.iter().all(|&v| v >= first).then_some((self.face_id(face as usize), triangle))
        });
        let (face_ids, triangles) = if self.held > 0 { faces.unzip() } else { Default::default() };
        let quadric = |&v: &u32| self.quadrics.get(v as usize).copied().unwrap_or_default();
        Reduced {
            vertex_ids: vertices.iter().map(|&v| self.vertex_id(v)).collect(),
            positions: vertices.iter().map(|&v| self.positions[v as usize]).collect(),
            quadrics: vertices.iter().map(quadric).collect(),
            triangles,
            face_ids,
            vertices,
            ..Reduced::default()
        }
    }

    /// A pass over all blocks: collapses the edges that cost less than a threshold. It cannot record collapses.
    ///
    /// # Panics
    /// The rules ask for a record of the collapses.
    #[must_use]
    pub fn reduce(
        &self,
        pass: usize,
        rules: &Rules,
        threshold: CostThreshold,
    ) -> FlatMesh<'static> {
        assert!(!rules.record, "nothing is recorded here");
        let partition = self.partition(pass);
        let mut reduced = parallel::collect_each(partition.blocks(), |i| {
            Block::new(self, &partition, i, rules).reduce(rules, threshold.block_of(i))
        });
        reduced.push(self.idle());
        let joined = FlatMesh::join_all(reduced, self.vertex_capacity());
        FlatMesh { held: self.held, ..joined }
    }

    /// The number of faces that a pass would remove at each cost, estimated from one in `one_in` blocks, each collapsed
    /// until this share of its faces is left.
    #[must_use]
    pub fn forecast(&self, pass: usize, rules: &Rules, share: f64, one_in: usize) -> Forecast {
        let partition = self.partition(pass);
        let asked = partition.some(one_in, 3);
        let forecasts = parallel::collect_each(asked.len(), |i| {
            Block::new(self, &partition, asked[i], rules).forecast(rules, share)
        });
        Forecast::of_all(&forecasts, self.face_count() as u64)
    }
}

/// The order of the collapses of several blocks, by the largest cost so far in the block. The result lists that cost,
/// the block, and the place in the block.
pub(super) fn by_cost_so_far(
    blocks: impl Iterator<Item = impl Iterator<Item = f64>>,
) -> Vec<(f64, u32, u32)> {
    let mut order = Vec::new();
    for (block, costs) in blocks.enumerate() {
        let mut largest = 0.0_f64;
        for (i, cost) in costs.enumerate() {
            largest = largest.max(cost);
            order.push((largest, as_u32(block), as_u32(i)));
        }
    }
    // The sort is stable: each block stays in order, and for equal costs earlier blocks come first.
    parallel::sort_by(&mut order, |a, b| a.0.total_cmp(&b.0));
    order
}

/// Merges the collapses of the blocks of one pass into one order.
pub(super) fn merge_steps(blocks: &[Done], log: &mut Vec<LogEntry>, faces_before: &mut u32) {
    let order = by_cost_so_far(blocks.iter().map(|done| done.steps.iter().map(|step| step.cost)));
    let mut entries = parallel::collect(order.len(), |place| {
        let (_, block, i) = order[place];
        let Step { removed, kept, half_edge, faces, position, cost } =
            blocks[block as usize].steps[i as usize];
        LogEntry {
            half_edge: HalfEdgeId::new(half_edge),
            removed: VertexId::new(removed),
            kept: VertexId::new(kept),
            position,
            cost,
            // For now, the number of faces removed by the collapse.
            faces_before: faces,
        }
    });
    for entry in &mut entries {
        let gone = core::mem::replace(&mut entry.faces_before, *faces_before);
        *faces_before -= gone;
    }
    if log.is_empty() {
        *log = entries;
        return;
    }
    // Growth by doubling would waste memory.
    log.reserve_exact(entries.len());
    log.append(&mut entries);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pass_leaves_a_fourth_or_what_the_last_piece_is_made_of() {
        assert_eq!(last_piece(400_000), 500_000);
        assert_eq!(aim(0, 1_000_000, 1_000, 30_000), Some(250_000));
        assert_eq!(aim(0, 1_000_000, 500_000, 30_000), Some(500_000));
        // A pass is not worthwhile near the target, or with too few faces.
        assert_eq!(aim(0, 1_000_000, 900_000, 30_000), Some(900_000));
        assert_eq!(aim(0, 1_000_000, 900_001, 30_000), None);
        assert_eq!([75_000, 74_999].map(|faces| aim(0, faces, 100, 30_000)), [Some(18_750), None]);
        assert_eq!([30_000, 29_999].map(|faces| aim(1, faces, 100, 30_000)), [Some(7_500), None]);
    }

    #[test]
    fn collapses_of_several_blocks_come_by_the_largest_cost_so_far() {
        let costs = [vec![1.0, 5.0, 2.0], vec![], vec![0.5, 1.0, 6.0]];
        let order = by_cost_so_far(costs.iter().map(|costs| costs.iter().copied()));
        let order: Vec<(u32, u32)> = order.into_iter().map(|(_, block, i)| (block, i)).collect();
        assert_eq!(order, [(2, 0), (0, 0), (2, 1), (0, 1), (0, 2), (2, 2)]);
    }
}
