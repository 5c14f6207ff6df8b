//! Collapses by the greedy loop in blocks, for metrics that block meshes do not support.
//!
//! Each block is collapsed separately, as its own mesh. Then all collapses are sorted by the largest cost so far in
//! their block, and the list is cut off at the wanted number of faces. The remaining collapses are repeated on the
//! whole mesh, which takes less than a tenth of the time.

use core::ops::ControlFlow;
use std::time::Instant;

use mesh_core::{TriMesh, as_u32, parallel};

use crate::blocks::flat_mesh::FlatMesh;
use crate::blocks::partition::Partition;
use crate::blocks::pass::{FORECAST, LEAST_ASKED, aim, by_cost_so_far};
use crate::blocks::submesh::Submesh;
use crate::constraint::Constraints;
use crate::cost::garland_heckbert::AccumulatedQuadrics;
use crate::engine::start::Start;
use crate::engine::vertex_freedom::VertexFreedom;
use crate::geometry::edge_patch::Collapse;
use crate::geometry::quadric::Quadric;
use crate::protect::Protect;
use crate::record::log::LogEntry;
use crate::record::run::{Phase, Progress, Run};
use crate::record::target::{StopReason, Target};
use crate::rejection::Rejections;

/// A run of the greedy loop on a mesh, with the quadrics of its vertices, other start data, and limits.
pub type Drive<'a> = dyn Fn(
        &mut TriMesh,
        Vec<Quadric>,
        Start,
        &Target,
        &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Run
    + Sync
    + 'a;

/// The smallest number of faces that is cut into blocks after the first pass.
const FEWEST_AGAIN: usize = 30_000;
/// The ratio to the wanted number of faces below which the mesh is collapsed in one piece, mostly on one thread. With
/// 1.25 mean errors are equal; with 1.1 they are up to 0.6 % higher.
const LAST: f64 = 1.15;
/// Some blocks are collapsed first, to estimate the cost that leaves the wanted number of faces. They are collapsed to
/// this fraction of the aim of the pass.
const BEYOND: f64 = 0.6;
/// The number of blocks between two calls that ask whether to go on.
const WAVE: usize = 32;

/// The result of a block.
struct Reduced {
    /// The collapses, with the handles of the mesh, except the numbers of faces.
    entries: Vec<LogEntry>,
    /// The numbers of faces before and after.
    faces: [usize; 2],
    rejections: Rejections,
}

impl Reduced {
    fn costs(&self) -> impl Iterator<Item = f64> + '_ {
        self.entries.iter().map(|entry| entry.cost)
    }

    /// Removes all entries from the first collapse on that costs more.
    fn cut_off(&mut self, cost: f64) {
        let end = self.costs().position(|of_edge| of_edge > cost);
        if let Some(end) = end {
            self.faces[1] = self.entries[end].faces_before as usize;
            self.entries.truncate(end);
        }
    }

    /// The number of faces that a collapse removed.
    fn faces_gone(&self, collapse: usize) -> usize {
        let after = self.entries.get(collapse + 1).map(|next| next.faces_before as usize);
        self.entries[collapse].faces_before as usize - after.unwrap_or(self.faces[1])
    }
}

/// The state of a run.
struct Passes<'a> {
    mesh: &'a mut TriMesh,
    quadrics: AccumulatedQuadrics,
    fixed: VertexFreedom,
    run: Run,
}

/// Collapses edges of a mesh by the greedy loop, in blocks as far as possible. `quadrics` are the quadrics that the
/// vertices have accumulated in an earlier run; empty if there was none.
pub fn collapse_driven(
    mesh: &mut TriMesh,
    quadrics: Vec<Quadric>,
    protect: &Protect,
    limits: &Target,
    drive: &Drive<'_>,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    let start = Instant::now();
    let faces_before = mesh.topology().face_count();
    let face_target = limits.face_target(faces_before);
    // A mesh with quadrics of an earlier run has already had a first pass.
    let first = usize::from(!quadrics.is_empty());
    let quadrics = match quadrics.is_empty() {
        true => AccumulatedQuadrics::new(mesh),
        false => AccumulatedQuadrics::from_vec(quadrics),
    };
    let end = (LAST * face_target as f64) as usize;
    let fixed = VertexFreedom::new(mesh, protect, Constraints::default(), None);
    let mut passes = Passes { mesh, quadrics, fixed, run: Run::new() };
    for number in first.. {
        let faces = passes.mesh.topology().face_count();
        let Some(aim) = aim(number, faces, end, FEWEST_AGAIN) else { break };
        let stop = passes.pass(number, aim, drive, &mut |faces, collapses| {
            let phase = Phase::Collapse;
            let now = Progress { phase, faces_before, faces, face_target, collapses };
            let is_late = limits.time.is_some_and(|time| start.elapsed() >= time);
            let late = is_late.then_some(StopReason::Time);
            late.or_else(|| observe(&now).is_break().then_some(StopReason::Cancelled))
        });
        if let Some(stop) = stop {
            return Run { stop, ..passes.run };
        }
        if 20 * passes.mesh.topology().face_count() > 19 * faces {
            break;
        }
    }
    let time = limits.time.map(|time| time.saturating_sub(start.elapsed()));
    let limits = Target { faces: Some(face_target), ratio: None, time, ..*limits };
    let done = passes.run.collapses;
    passes.in_one_piece(&limits, drive, &mut |now| {
        observe(&Progress { faces_before, collapses: done + now.collapses, ..*now })
    })
}

impl Passes<'_> {
    /// Collapses all blocks until about `aim` faces are left. `reached` is called from time to time with the numbers of
    /// faces and collapses, and may return a reason to stop.
    fn pass(
        &mut self,
        number: usize,
        aim: usize,
        drive: &Drive<'_>,
        reached: &mut dyn FnMut(usize, usize) -> Option<StopReason>,
    ) -> Option<StopReason> {
        let faces = self.mesh.topology().face_count();
        let share = aim as f64 / faces as f64;
        let partition = FlatMesh::new(self.mesh).partition(number);
        let blocks = partition.blocks();
        let first = partition.some(FORECAST, LEAST_ASKED);
        let is_other = |block: &usize| first.binary_search(block).is_err();
        let others: Vec<usize> = (0..blocks).filter(is_other).collect();
        let mut threshold = None;
        let (mut reduced, mut collapses) = (Vec::with_capacity(blocks), 0);
        for wave in first.chunks(WAVE).chain(others.chunks(WAVE)) {
            let left = faces.saturating_sub(2 * collapses).max(aim);
            if let Some(stop) = reached(left, self.run.collapses + collapses) {
                self.carry_out(&reduced, aim);
                return Some(stop);
            }
            if threshold.is_none() && reduced.len() >= first.len() {
                threshold = Some(cost_leaving(share, &reduced));
            }
            let goal = |faces: usize| match threshold {
                Some(cost) => Target { cost: Some(cost), ..Target::default() },
                None => {
                    let faces = (BEYOND * share * faces as f64) as usize;
                    Target { faces: Some(faces), ..Target::default() }
                }
            };
            let done = parallel::collect_each(wave.len(), |i| {
                self.reduce(&partition, wave[i], &goal, drive)
            });
            collapses += done.iter().map(|block| block.entries.len()).sum::<usize>();
            reduced.extend(done);
        }
        reduced.iter_mut().for_each(|block| block.cut_off(threshold.unwrap_or(f64::INFINITY)));
        self.carry_out(&reduced, aim);
        None
    }

    /// Collapses a block separately.
    fn reduce(
        &self,
        partition: &Partition,
        block: usize,
        goal: &dyn Fn(usize) -> Target,
        drive: &Drive<'_>,
    ) -> Reduced {
        let mut submesh = Submesh::new(self.mesh, partition, block);
        let faces = submesh.mesh.topology().face_count();
        let quadrics = submesh.quadrics(self.quadrics.as_slice());
        let start = Start {
            borders: Some(submesh.quadrics(self.fixed.borders())),
            is_free: Some(core::mem::take(&mut submesh.is_free)),
            ..Start::default()
        };
        let go_on = &mut |_: &Progress| ControlFlow::Continue(());
        let run = drive(&mut submesh.mesh, quadrics, start, &goal(faces), go_on);
        Reduced {
            entries: run.log.entries().iter().map(|entry| submesh.of_mesh(entry)).collect(),
            faces: [faces, submesh.mesh.topology().face_count()],
            rejections: run.rejections,
        }
    }

    /// Applies the collapses of the blocks to the mesh, the cheapest first, until few enough faces are left.
    fn carry_out(&mut self, blocks: &[Reduced], aim: usize) {
        let mut faces = self.mesh.topology().face_count();
        let mut counts = vec![0; blocks.len()];
        for (_, block, i) in by_cost_so_far(blocks.iter().map(Reduced::costs)) {
            if faces <= aim {
                break;
            }
            let reduced = &blocks[block as usize];
            self.run.push(LogEntry { faces_before: as_u32(faces), ..reduced.entries[i as usize] });
            faces -= reduced.faces_gone(i as usize);
            counts[block as usize] = i as usize + 1;
        }
        // The order does not change the resulting mesh, and block by block uses the cache well.
        for (block, count) in blocks.iter().zip(counts) {
            block.entries[..count].iter().for_each(|entry| self.follow(entry));
            self.run.rejections.add(&block.rejections);
        }
    }

    /// Applies a collapse of a part to the mesh.
    fn follow(&mut self, entry: &LogEntry) {
        let LogEntry { half_edge, position, .. } = *entry;
        #[expect(clippy::expect_used, reason = "the part had all that decides over it")]
        let legal = self.mesh.topology().check_collapse(half_edge).expect("a legal collapse");
        let collapse = Collapse::new(self.mesh, &legal, position);
        let collapsed = self.mesh.collapse(legal, position);
        self.quadrics.merge(&collapse);
        self.fixed.collapsed(self.mesh, &collapse, collapsed.merged_edges);
    }

    /// Collapses the remaining mesh to the end.
    fn in_one_piece(
        mut self,
        limits: &Target,
        drive: &Drive<'_>,
        observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Run {
        if self.run.collapses == 0 {
            let (quadrics, borders) = (self.quadrics.into_vec(), self.fixed.borders().to_vec());
            let start = Start { borders: Some(borders), ..Start::default() };
            return drive(self.mesh, quadrics, start, limits, observe);
        }
        let partition = Partition::whole(&FlatMesh::new(self.mesh));
        let mut submesh = Submesh::new(self.mesh, &partition, 0);
        let quadrics = submesh.quadrics(self.quadrics.as_slice());
        let borders = Some(submesh.quadrics(self.fixed.borders()));
        let start = Start { borders, ..Start::default() };
        let run = drive(&mut submesh.mesh, quadrics, start, limits, observe);
        for entry in run.log.entries() {
            let entry = submesh.of_mesh(entry);
            self.follow(&entry);
            self.run.push(entry);
        }
        self.run.rejections.add(&run.rejections);
        Run { stop: run.stop, ..self.run }
    }
}

/// The cost at which blocks leave this share of all faces, estimated from some blocks.
fn cost_leaving(share: f64, blocks: &[Reduced]) -> f64 {
    let faces: usize = blocks.iter().map(|block| block.faces[0]).sum();
    let mut left = ((1.0 - share) * faces as f64) as usize;
    for (cost, block, i) in by_cost_so_far(blocks.iter().map(Reduced::costs)) {
        let gone = blocks[block as usize].faces_gone(i as usize);
        if gone > left {
            return cost;
        }
        left -= gone;
    }
    f64::INFINITY
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::sync::atomic::{AtomicUsize, Ordering};
    use glam::DVec3;
    use mesh_core::{HalfEdgeId, VertexId};
    use mesh_shapes::Plane;

    /// A block with this many faces. Each collapse removes two.
    fn block(faces: usize, costs: &[f64]) -> Reduced {
        let entry = |(i, &cost): (usize, &f64)| LogEntry {
            half_edge: HalfEdgeId::new(0),
            removed: VertexId::new(0),
            kept: VertexId::new(1),
            position: DVec3::ZERO,
            cost,
            faces_before: (faces - 2 * i) as u32,
        };
        Reduced {
            entries: costs.iter().enumerate().map(entry).collect(),
            faces: [faces, faces - 2 * costs.len()],
            rejections: Rejections::default(),
        }
    }

    #[test]
    fn the_cost_leaves_as_many_faces_as_wanted() {
        let blocks = [block(20, &[1.0, 3.0, 2.0, 9.0]), block(12, &[0.5, 4.0])];
        // In order: 0.5, 1, 3, 2 (which follows 3), 4, 9.
        let cost = |left: f64| cost_leaving(left / 32.0, &blocks);
        assert_eq!([32.0, 30.0, 28.0].map(cost), [0.5, 1.0, 3.0]);
        assert_eq!([24.0, 22.0, 20.0].map(cost), [4.0, 9.0, f64::INFINITY]);
    }

    /// The edge of a block is not a boundary of the mesh.
    #[test]
    fn blocks_have_the_borders_of_the_whole() {
        let soup = Plane { half_width: 1.0 }.mesh(200, Default::default()).unwrap();
        let mut mesh = TriMesh::from_soup(&soup).unwrap();
        let at_border = AtomicUsize::new(0);
        let drive = |submesh: &mut TriMesh,
                     _: Vec<Quadric>,
                     start: Start,
                     _: &Target,
                     _: &mut dyn FnMut(&Progress) -> ControlFlow<()>| {
            let Start { borders, is_free: Some(is_free), .. } = start else { return Run::new() };
            let (borders, positions) = (borders.unwrap(), submesh.positions());
            for v in (0..is_free.len()).filter(|&v| is_free[v]) {
                let is_at_border = positions[v].abs().max_element() == 1.0;
                assert_eq!(borders[v] != Quadric::default(), is_at_border, "{}", positions[v]);
                at_border.fetch_add(usize::from(is_at_border), Ordering::Relaxed);
            }
            Run::new()
        };
        let limits = Target { faces: Some(40_000), ..Target::default() };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        collapse_driven(&mut mesh, Vec::new(), &Protect::default(), &limits, &drive, go_on);
        // All boundary edges except those next to the cuts.
        let count = at_border.into_inner();
        assert!((700..=800).contains(&count), "{count}");
    }

    #[test]
    fn what_costs_more_is_forgotten() {
        let mut reduced = block(20, &[1.0, 3.0, 2.0, 9.0]);
        assert_eq!([0, 1, 3].map(|i| reduced.faces_gone(i)), [2, 2, 2]);
        reduced.cut_off(9.0);
        assert_eq!((reduced.entries.len(), reduced.faces), (4, [20, 12]));
        reduced.cut_off(2.5);
        assert_eq!((reduced.entries.len(), reduced.faces), (1, [20, 18]));
        reduced.cut_off(0.0);
        assert_eq!((reduced.entries.len(), reduced.faces), (0, [20, 20]));
    }
}
