//! A run in regions: pass after pass until few enough faces are left, and then in one piece.

use core::ops::ControlFlow;
use std::time::Instant;

use glam::DVec3;
use mesh_core::{TriMesh, VertexId, VertexMap};

use crate::collapse::log::{CollapseLog, LogEntry};
use crate::collapse::refusal::Refusals;
use crate::collapse::run::{Phase, Progress, Run};
use crate::collapse::stop::{Limits, StopReason};
use crate::regions::partition::Partition;
use crate::regions::pass::{Done, each, forecast, join, merge_steps, reduce};
use crate::regions::rules::Rules;
use crate::regions::sheet::Sheet;
use crate::regions::tile::Goal;
use crate::regions::waiting::BUCKETS;

/// The number of vertices of a region: what fits into the cache of one core.
const REGION: usize = 4096;
/// A pass leaves no fewer than one in so many faces; by then, rims stand out.
const PASS: usize = 4;
/// So many times the faces that are wanted are collapsed in one piece.
const LAST: f64 = 2.0;
/// Regions of which one is looked at beforehand.
const FORECAST: usize = 12;
/// Regions that are at work between two questions whether to go on.
const WAVE: usize = 64;

/// What is left of a mesh, and how it came about.
pub(crate) struct Regional {
    pub(crate) mesh: TriMesh,
    /// For each vertex of the original, the one that it has become.
    pub(crate) became: VertexMap<Option<VertexId>>,
    /// What was done; it cannot be cut off.
    pub(crate) run: Run,
}

/// The state of a run.
struct Passes<'a, 'o> {
    rules: Rules,
    limits: &'a Limits,
    target: usize,
    faces_before: usize,
    observe: &'o mut dyn FnMut(&Progress) -> ControlFlow<()>,
    start: Instant,
    /// By vertex of the original: itself, or the one that it was merged into.
    merged_into: Vec<u32>,
    log: Vec<LogEntry>,
    log_faces: u32,
    collapses: usize,
    refusals: Refusals,
    max_cost: f64,
    stop: Option<StopReason>,
}

/// Collapses edges of a mesh in regions.
pub(crate) fn collapse_in_regions(
    mesh: &TriMesh,
    rules: Rules,
    limits: &Limits,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Regional {
    let faces = mesh.topology().face_count();
    let target = limits.face_target(faces);
    let mut passes = Passes {
        rules,
        limits,
        target,
        faces_before: faces,
        observe,
        start: Instant::now(),
        merged_into: (0..mesh.topology().vertex_capacity() as u32).collect(),
        log: Vec::new(),
        log_faces: faces as u32,
        collapses: 0,
        refusals: Refusals::default(),
        max_cost: 0.0,
        stop: None,
    };
    let mut sheet = Sheet::new(mesh);
    let mut pass = 0;
    let last = (LAST * target as f64) as usize;
    while passes.goes_on(sheet.face_count(), 0) {
        let faces = sheet.face_count();
        let aim = last.max(faces / PASS);
        if faces < 5 * REGION || 10 * aim > 9 * faces {
            break;
        }
        sheet = passes.pass(&sheet, pass, aim);
        pass += 1;
        if 20 * sheet.face_count() > 19 * faces {
            break;
        }
    }
    if passes.stop.is_none() {
        sheet = passes.in_one_piece(&sheet);
    }
    passes.finish(mesh, sheet)
}

impl Passes<'_, '_> {
    /// Whether neither the clock nor the observer nor the number of faces ends the run.
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
        } else if self.limits.time.is_some_and(|time| self.start.elapsed() >= time) {
            self.stop = Some(StopReason::Time);
        } else if (self.observe)(&progress).is_break() {
            self.stop = Some(StopReason::Cancelled);
        }
        self.stop.is_none()
    }

    /// Collapses all regions to the cost at which about `aim` faces are left.
    fn pass(&mut self, sheet: &Sheet<'_>, number: usize, aim: usize) -> Sheet<'static> {
        let partition = Partition::new(sheet, REGION, number);
        let rules = self.rules;
        let regions = partition.regions();
        let share = aim as f64 / sheet.face_count() as f64;
        let end = ceiling(sheet, &partition, &rules, share);
        let mut reduced = Vec::with_capacity(regions);
        for first in (0..regions).step_by(WAVE) {
            let goal = Goal { end: if self.stop.is_none() { end } else { 0 }, faces: 0 };
            let wave = each(first..regions.min(first + WAVE), |region| {
                reduce(sheet, &partition, region, &rules, goal, &mut |_, _| true).0
            });
            let collapses: usize = wave.iter().map(|region| region.done.merged.len()).sum();
            reduced.extend(wave);
            if self.stop.is_none() {
                self.goes_on(sheet.face_count() - 2 * collapses, collapses);
            }
        }
        let joined = join(sheet, &reduced);
        let done: Vec<Done> = reduced.into_iter().map(|region| region.done).collect();
        self.note(&done);
        joined
    }

    /// Collapses what is left as one region, to the number of faces.
    fn in_one_piece(&mut self, sheet: &Sheet<'_>) -> Sheet<'static> {
        let partition = Partition::new(sheet, sheet.vertex_capacity().max(1), 0);
        let goal = Goal { end: BUCKETS, faces: self.target };
        let rules = self.rules;
        let (reduced, is_whole) = reduce(sheet, &partition, 0, &rules, goal, &mut |faces, done| {
            self.goes_on(faces, done)
        });
        if is_whole {
            let is_there = reduced.face_count() <= self.target;
            self.stop = Some(if is_there { StopReason::Faces } else { StopReason::NothingLeft });
        }
        let reduced = [reduced];
        let joined = join(sheet, &reduced);
        self.note(&reduced.map(|region| region.done));
        joined
    }

    /// Takes down what was done.
    fn note(&mut self, regions: &[Done]) {
        for Done { merged, refusals, max_cost, .. } in regions {
            merged.iter().for_each(|&[gone, kept]| self.merged_into[gone as usize] = kept);
            self.collapses += merged.len();
            self.refusals.add(refusals);
            self.max_cost = self.max_cost.max(*max_cost);
        }
        merge_steps(regions, &mut self.log, &mut self.log_faces);
    }

    /// The mesh that is left: vertices and faces in the order of the original.
    fn finish(mut self, mesh: &TriMesh, sheet: Sheet<'_>) -> Regional {
        let left: Vec<u32> = sheet.vertices().collect();
        let mut order: Vec<(u32, u32)> = left.iter().map(|&v| (sheet.vertex_id(v), v)).collect();
        order.sort_unstable();
        let mut number = vec![u32::MAX; sheet.vertex_capacity()];
        let mut positions: Vec<DVec3> = Vec::with_capacity(order.len());
        let mut of_id = vec![None; mesh.topology().vertex_capacity()];
        for (new, &(id, v)) in order.iter().enumerate() {
            number[v as usize] = new as u32;
            of_id[id as usize] = Some(VertexId::new(new as u32));
            positions.push(sheet.positions[v as usize]);
        }
        let mut faces: Vec<(u32, u32)> = (0..sheet.face_capacity())
            .filter(|&f| sheet.triangle(f).is_some())
            .map(|f| (sheet.face_id(f), f as u32))
            .collect();
        faces.sort_unstable();
        let triangle = |&(_, f): &(u32, u32)| {
            sheet.triangle(f as usize).unwrap_or_default().map(|v| number[v as usize])
        };
        let triangles: Vec<[u32; 3]> = faces.iter().map(triangle).collect();
        #[expect(clippy::expect_used, reason = "collapses that are legal leave a manifold")]
        let left = TriMesh::from_triangles(&positions, &triangles).expect("a manifold");
        // Whatever a vertex was merged into is final once its own way has been followed to the end.
        for v in 0..self.merged_into.len() {
            let mut root = v as u32;
            while self.merged_into[root as usize] != root {
                root = self.merged_into[root as usize];
            }
            let mut on_the_way = v as u32;
            while on_the_way != root {
                on_the_way = core::mem::replace(&mut self.merged_into[on_the_way as usize], root);
            }
        }
        let became = self.merged_into.iter().map(|&v| of_id[v as usize]).collect();
        Regional {
            mesh: left,
            became: VertexMap::from_vec(became),
            run: Run {
                stop: self.stop.unwrap_or(StopReason::NothingLeft),
                collapses: self.collapses,
                log: CollapseLog::from_entries(self.log),
                refusals: self.refusals,
                max_cost: self.max_cost,
                ..Run::new()
            },
        }
    }
}

/// The bucket at which about this share of the faces is left, told by some of the regions.
fn ceiling(sheet: &Sheet<'_>, partition: &Partition, rules: &Rules, share: f64) -> usize {
    let regions = partition.regions();
    let asked = regions.div_ceil(FORECAST).max(regions.min(4));
    let forecasts = each(0..asked, |i| {
        // Those that are asked lie evenly in the order, and none at its ends.
        let region = (2 * i + 1) * regions / (2 * asked);
        let least =
            |faces: usize| Goal { end: BUCKETS, faces: (0.4 * share * faces as f64) as usize };
        forecast(sheet, partition, region, rules, least)
    });
    let mut gone = vec![0_u64; BUCKETS];
    let mut faces = 0;
    for (of_region, by_bucket) in &forecasts {
        faces += *of_region as u64;
        by_bucket.iter().for_each(|&(bucket, count)| gone[bucket] += u64::from(count));
    }
    let allowed = ((1.0 - share) * faces as f64) as u64;
    let mut total = 0;
    gone.iter()
        .position(|&count| {
            total += count;
            total > allowed
        })
        .unwrap_or(BUCKETS)
}
