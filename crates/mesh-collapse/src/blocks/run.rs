//! A run in blocks: passes until few enough faces are left, then a collapse in one piece.

use core::ops::ControlFlow;
use std::time::Instant;

use mesh_core::{FaceId, HalfEdgeId, Handle, TriMesh, VertexId, VertexMap, as_u32, parallel};

use crate::blocks::block::{Block, Done, Reduced};
use crate::blocks::block_mesh::Goal;
use crate::blocks::bucket_queue::BUCKETS;
use crate::blocks::cost_threshold::{CostThreshold, Forecast};
use crate::blocks::flat_mesh::{FlatMesh, Ordered};
use crate::blocks::partition::Partition;
use crate::blocks::pass::{FORECAST, LEAST_ASKED, aim, last_piece, merge_steps};
use crate::blocks::rules::Rules;
use crate::geometry::quadric::Quadric;
use crate::record::log::{CollapseLog, LogEntry};
use crate::record::run::{Phase, Progress, Run};
use crate::record::snapshot::Snapshot;
use crate::record::target::{StopReason, Target};
use crate::rejection::Rejections;

/// The smallest number of faces that is cut into blocks after the first pass.
const FEWEST_AGAIN: usize = 50_000;
/// The number of blocks between two calls that ask whether to go on.
const WAVE: usize = 64;

/// The result of a run in blocks.
pub struct BlockRun {
    /// The resulting mesh, without gaps.
    pub left: Snapshot,
    /// For each vertex of the original, the vertex that it was merged into.
    pub vertex_map: VertexMap<Option<VertexId>>,
    /// The accumulated quadric of each vertex; empty if nothing has collapsed.
    pub quadrics: Vec<Quadric>,
    /// The report of the run; it cannot be truncated.
    pub run: Run,
}

/// The state of a run.
struct Passes<'a, 'o> {
    rules: Rules,
    extent: Extent<'a>,
    target: usize,
    faces_before: usize,
    observe: &'o mut dyn FnMut(&Progress) -> ControlFlow<()>,
    start: Instant,
    /// For each vertex of the original, itself or the vertex that it was merged into.
    merged_into: Vec<u32>,
    log: Vec<LogEntry>,
    log_faces: u32,
    collapses: usize,
    rejections: Rejections,
    max_cost: f64,
    stop: Option<StopReason>,
    snapshots: Vec<Snapshot>,
}

/// The limits of a run, and the data that it keeps.
#[derive(Clone, Copy)]
pub struct Extent<'a> {
    /// When to stop.
    pub limits: &'a Target,
    /// Whether the number of faces has to be exact.
    pub precision: Precision,
    /// Whether the mesh after each pass is kept.
    pub snapshots: bool,
}

/// How closely a run reaches the target number of faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// As close as collapses can.
    Exact,
    /// As close as a pass; for a run that another one continues.
    About,
}

impl Precision {
    /// The number of faces that the last pass should leave.
    fn end(self, target: usize) -> usize {
        match self {
            Self::Exact => last_piece(target),
            Self::About => target,
        }
    }

    /// Whether this number of faces is close enough.
    fn is_met(self, faces: usize, target: usize) -> bool {
        match self {
            Self::Exact => faces <= target,
            Self::About => 10 * faces <= 11 * target,
        }
    }
}

/// Collapses edges of a mesh in blocks.
pub fn collapse_in_blocks(
    mesh: &TriMesh,
    rules: Rules,
    extent: Extent<'_>,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> BlockRun {
    let capacity = mesh.topology().vertex_capacity();
    collapse_flat_mesh(FlatMesh::new(mesh), capacity, rules, extent, observe)
}

/// Collapses edges of a flat mesh in blocks. The ids of its vertices are below `capacity`.
pub fn collapse_flat_mesh(
    mut flat: FlatMesh<'_>,
    capacity: usize,
    rules: Rules,
    extent: Extent<'_>,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> BlockRun {
    let faces = flat.face_count();
    let Extent { limits, precision, snapshots } = extent;
    let target = limits.face_target(faces);
    let mut passes = Passes {
        rules,
        extent,
        target,
        faces_before: faces,
        observe,
        start: Instant::now(),
        merged_into: (0..as_u32(capacity)).collect(),
        log: Vec::new(),
        log_faces: as_u32(faces),
        collapses: 0,
        rejections: Rejections::default(),
        max_cost: 0.0,
        stop: None,
        snapshots: Vec::new(),
    };
    let mut pass = 0;
    while passes.goes_on(flat.face_count(), 0) {
        let faces = flat.face_count();
        let Some(aim) = aim(pass, faces, precision.end(target), FEWEST_AGAIN) else { break };
        flat = passes.pass(&flat, pass, aim);
        pass += 1;
        if snapshots {
            passes.snapshots.push(snapshot(&flat, passes.collapses, rules.record).0);
        }
        if 20 * flat.face_count() > 19 * faces {
            break;
        }
    }
    if passes.stop.is_none() && !precision.is_met(flat.face_count(), target) {
        flat = passes.in_one_piece(flat);
    }
    passes.finish(&flat)
}

impl Passes<'_, '_> {
    /// Whether the run goes on: false if the clock, the observer or the number of faces ends it.
    fn goes_on(&mut self, faces: usize, collapses: usize) -> bool {
        let progress = Progress {
            phase: Phase::Collapse,
            faces_before: self.faces_before,
            faces,
            face_target: self.target,
            collapses: self.collapses + collapses,
        };
        if faces <= self.target {
            self.stop = Some(StopReason::Faces);
        } else if self.extent.limits.time.is_some_and(|time| self.start.elapsed() >= time) {
            self.stop = Some(StopReason::Time);
        } else if (self.observe)(&progress).is_break() {
            self.stop = Some(StopReason::Cancelled);
        }
        self.stop.is_none()
    }

    /// Collapses all blocks up to the cost that leaves about `aim` faces.
    fn pass(&mut self, flat: &FlatMesh<'_>, number: usize, aim: usize) -> FlatMesh<'static> {
        let partition = flat.partition(number);
        let end = forecast_ceiling(flat, &partition, &self.rules, aim);
        let mut reduced = self.reduce_all(flat, &partition, end);
        let left: usize = reduced.iter().map(Reduced::face_count).sum();
        // The sampled blocks were not typical. The forecasts of all blocks are known now.
        let is_too_few = left < aim - aim / 5 && left < self.target + self.target / 5;
        if is_too_few && self.stop.is_none() {
            let all: Vec<&Forecast> = reduced.iter().map(Reduced::forecast).collect();
            let lower = CostThreshold::leaving(aim as f64 / flat.face_count() as f64, &all);
            drop(reduced);
            reduced = self.reduce_all(flat, &partition, lower.min(end));
        }
        let done: Vec<Done> =
            reduced.iter_mut().map(|block| core::mem::take(&mut block.done)).collect();
        self.note(&done);
        drop(done);
        FlatMesh::join(reduced)
    }

    fn reduce_all(
        &mut self,
        flat: &FlatMesh<'_>,
        partition: &Partition,
        end: CostThreshold,
    ) -> Vec<Reduced> {
        let rules = self.rules;
        let blocks = partition.blocks();
        let (mut reduced, mut collapses) = (Vec::with_capacity(blocks), 0);
        for first in (0..blocks).step_by(WAVE) {
            // After a stop, the other blocks are handed on unchanged.
            let end = if self.stop.is_none() { end } else { CostThreshold::NONE };
            let wave = parallel::collect_each(WAVE.min(blocks - first), |i| {
                Block::new(flat, partition, first + i, &rules).reduce(&rules, end)
            });
            collapses += wave.iter().map(Reduced::collapses).sum::<usize>();
            reduced.extend(wave);
            if self.stop.is_none() && first + WAVE < blocks {
                let left = flat.face_count().saturating_sub(2 * collapses);
                self.goes_on(left.max(self.target + 1), collapses);
            }
        }
        reduced
    }

    /// Collapses the rest as one block, to the wanted number of faces.
    fn in_one_piece(&mut self, flat: FlatMesh<'_>) -> FlatMesh<'static> {
        let goal = Goal { end: BUCKETS, faces: self.target };
        let rules = self.rules;
        let block = Block::whole(flat, &rules);
        let (mut reduced, is_whole) =
            block.reduce_to(&rules, goal, &mut |faces, done| self.goes_on(faces, done));
        if is_whole {
            let is_there = reduced.face_count() <= self.target;
            self.stop = Some(if is_there { StopReason::Faces } else { StopReason::NothingLeft });
        }
        self.note(&[core::mem::take(&mut reduced.done)]);
        FlatMesh::join(vec![reduced])
    }

    /// Records the work of some blocks.
    fn note(&mut self, blocks: &[Done]) {
        for Done { merged, rejections, max_cost, .. } in blocks {
            merged.iter().for_each(|&[gone, kept]| self.merged_into[gone as usize] = kept);
            self.collapses += merged.len();
            self.rejections.add(rejections);
            self.max_cost = self.max_cost.max(*max_cost);
        }
        merge_steps(blocks, &mut self.log, &mut self.log_faces);
    }

    /// The resulting mesh, with vertices and faces in the order of the original.
    fn finish(mut self, flat: &FlatMesh<'_>) -> BlockRun {
        let (merged_into, collapses, record) =
            (&mut self.merged_into, self.collapses, self.rules.record);
        let ((left, order), ()) =
            parallel::both(|| snapshot(flat, collapses, record), || follow(merged_into));
        let mut of_id = vec![None; merged_into.len()];
        for (new, id) in left.vertices.iter().enumerate() {
            of_id[id.index()] = Some(VertexId::new(as_u32(new)));
        }
        let vertex_map = parallel::collect(merged_into.len(), |v| of_id[merged_into[v] as usize]);
        let count = if flat.quadrics.is_empty() { 0 } else { order.len() };
        let quadrics = parallel::collect(count, |v| flat.quadrics[order[v] as usize]);
        let run = Run {
            stop: self.stop.unwrap_or(StopReason::Faces),
            collapses: self.collapses,
            log: CollapseLog::from_entries(self.log),
            rejections: self.rejections,
            max_cost: self.max_cost,
            snapshots: self.snapshots,
            ..Run::new()
        };
        BlockRun { left, vertex_map: VertexMap::from_vec(vertex_map), quadrics, run }
    }
}

/// A flat mesh as a snapshot after `collapses` collapses, and the flat-mesh id of each of its vertices.
fn snapshot(flat: &FlatMesh<'_>, collapses: usize, is_recorded: bool) -> (Snapshot, Vec<u32>) {
    let Ordered { mesh, vertices, faces } = flat.to_ordered_mesh();
    let snapshot = Snapshot {
        vertices: vertices.iter().map(|&(id, _)| VertexId::new(id)).collect(),
        half_edges: original_half_edges(&mesh, flat, &faces, is_recorded),
        mesh,
        collapses,
    };
    (snapshot, vertices.into_iter().map(|(_, v)| v).collect())
}

/// Sets each entry to the end of its chain of merges.
fn follow(merged_into: &mut [u32]) {
    for v in 0..merged_into.len() {
        let mut root = as_u32(v);
        while merged_into[root as usize] != root {
            root = merged_into[root as usize];
        }
        // Shortens the chain for later look-ups.
        let mut on_the_way = as_u32(v);
        while on_the_way != root {
            on_the_way = core::mem::replace(&mut merged_into[on_the_way as usize], root);
        }
    }
}

/// The half-edge of the original for each half-edge; empty unless collapses are recorded.
fn original_half_edges(
    left: &TriMesh,
    flat: &FlatMesh<'_>,
    faces: &[(u32, u32)],
    is_recorded: bool,
) -> Vec<HalfEdgeId> {
    if !is_recorded {
        return Vec::new();
    }
    let topology = left.topology();
    let mut all = vec![HalfEdgeId::new(0); topology.half_edge_capacity()];
    for (face, &(_, f)) in faces.iter().enumerate() {
        let sides = topology.face_half_edges(FaceId::from_index(face));
        for (side, id) in sides.into_iter().zip(flat.half_edges(f as usize)) {
            all[side.index()] = HalfEdgeId::new(id);
            if topology.is_exterior(side.twin()) {
                all[side.twin().index()] = HalfEdgeId::new(id).twin();
            }
        }
    }
    all
}

/// The threshold that leaves about `aim` faces, estimated from some of the blocks.
fn forecast_ceiling(
    flat: &FlatMesh<'_>,
    partition: &Partition,
    rules: &Rules,
    aim: usize,
) -> CostThreshold {
    let share = aim as f64 / flat.face_count() as f64;
    let asked = partition.some(FORECAST, LEAST_ASKED);
    let forecasts = parallel::collect_each(asked.len(), |i| {
        // Some blocks lose more faces than others, so each goes below the mean share.
        Block::new(flat, partition, asked[i], rules).forecast(rules, 0.4 * share)
    });
    CostThreshold::leaving(share, &forecasts.iter().collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::SplitMix64;
    use mesh_shapes::{Irregular, Plane, Wave};

    /// A run that another one continues does not end in one piece, unless there are no passes.
    #[test]
    fn a_run_that_another_goes_on_with_ends_with_a_pass() {
        let wave = Wave { amplitude: 0.15, wavelength: 1.1, half_width: 1.0 };
        for (cells, has_passes) in [(220, true), (150, false)] {
            let soup = wave.irregular_mesh(cells, Irregular { jitter: 0.2, seed: 4 }).unwrap();
            let mesh = TriMesh::from_soup(&soup).unwrap();
            let target = 40_000;
            let limits = Target { faces: Some(target), ..Target::default() };
            let go_on = &mut |_: &Progress| ControlFlow::Continue(());
            let rules = Rules::new(&mesh);
            let extent = Extent { limits: &limits, precision: Precision::About, snapshots: false };
            let done = collapse_in_blocks(&mesh, rules, extent, go_on);
            let left = done.left.mesh.topology().face_count();
            let is_exact = left == target || left + 1 == target;
            assert_eq!(is_exact, !has_passes, "{left}");
            assert!((target - target / 5..=target + target / 10).contains(&left), "{left}");
        }
    }

    /// A flat mesh that is rough exactly in the sampled blocks. These suggest a high threshold, at which the other
    /// blocks would lose nearly all faces.
    #[test]
    fn a_pass_that_went_too_far_is_made_again() {
        let soup = Plane { half_width: 1.0 }.mesh(260, Default::default()).unwrap();
        let mut mesh = TriMesh::from_soup(&soup).unwrap();
        // Small heights do not change the partition.
        let mut random = SplitMix64::new(1);
        let partition = FlatMesh::new(&mesh).partition(0);
        let asked = partition.some(FORECAST, LEAST_ASKED);
        assert!(8 * asked.len() <= partition.blocks());
        for v in asked.iter().flat_map(|&block| partition.vertices(block)) {
            mesh.positions_mut()[*v as usize].z = 1e-3 * random.uniform();
        }
        let (rules, target) = (Rules::new(&mesh), 60_000);
        let limits = Target { faces: Some(target), ..Target::default() };
        let go_on = &mut |_: &Progress| ControlFlow::Continue(());
        let extent = Extent { limits: &limits, precision: Precision::Exact, snapshots: false };
        let done = collapse_in_blocks(&mesh, rules, extent, go_on);
        assert_eq!(done.run.stop, StopReason::Faces);
        let left = done.left.mesh.topology().face_count();
        assert!(left == target || left + 1 == target, "{left}");
    }
}
