//! The greedy loop: collapses the cheapest edges and updates their neighbourhood.
//!
//! [`Schedule`] chooses the order of the edges:
//!
//! - [`Schedule::Lazy`], and [`Schedule::Parallel`] if blocks are not possible, takes the cheapest few percent of the
//!   edges by keys that may be out of date, and visits them in the order in which they are stored ([`Rounds`]).
//!   Neighbours are then in the cache, and only edges that are about to collapse are evaluated.
//! - [`Schedule::Exact`] keeps all keys up to date in a heap ([`Heap`]), and is exact.
//!
//! An edge found to cost more than the threshold returns to the queue, with its new bound as the key.

use core::ops::ControlFlow;

use mesh_core::{EdgeId, TriMesh};

use crate::cost::Cost;
use crate::engine::schedule::heap::Heap;
use crate::engine::schedule::queue::Entry;
use crate::engine::schedule::rounds::{Round, Rounds, Visit};
use crate::engine::start::Start;
use crate::engine::stepper::{Stepper, Turn};
use crate::engine::target_check::TargetCheck;
use crate::placement::Placement;
use crate::policies::{Policies, Schedule};
use crate::protect::Protect;
use crate::record::run::{Progress, Run};
use crate::record::target::{StopReason, Target};

/// Collapses edges of the mesh, the cheapest first, until a limit is reached.
///
/// The mesh keeps removed elements, so that the log and caller-owned maps stay valid; compact it
/// afterwards. `observe` is called every thousand collapses and may end the run.
///
/// Takes O(n log n) time for bounded valences.
pub fn collapse_edges<C: Cost, P: Placement>(
    mesh: &mut TriMesh,
    policies: Policies<C, P>,
    protect: &Protect,
    limits: &Target,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    collapse_edges_from(mesh, policies, Start::default(), protect, limits, observe)
}

/// [`collapse_edges`] with start data, for example from an earlier run. The returned run contains the constraints that
/// followed the mesh, in their final state.
pub fn collapse_edges_from<C: Cost, P: Placement>(
    mesh: &mut TriMesh,
    policies: Policies<C, P>,
    start: Start,
    protect: &Protect,
    limits: &Target,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    let schedule = policies.schedule;
    let mut stepper = Stepper::new(mesh, policies, start, protect);
    let entries = stepper.entries();
    let faces = stepper.mesh().topology().face_count();
    if limits.cost.is_none() && limits.collapses.is_none() {
        // Most collapses remove two faces.
        stepper.expect_collapses(faces.saturating_sub(limits.face_target(faces)) / 2);
    }
    let mut watch = TargetCheck::new(limits, faces, observe);
    let stop = match schedule {
        Schedule::Lazy | Schedule::Parallel => run_in_rounds(&mut stepper, entries, &mut watch),
        Schedule::Exact => run_in_order(&mut stepper, entries, &mut watch),
    };
    stepper.finish(stop)
}

/// The `count` edges that cost least to collapse.
pub fn cheapest_edges<C: Cost, P: Placement>(
    mesh: &mut TriMesh,
    policies: Policies<C, P>,
    start: Start,
    protect: &Protect,
    count: usize,
) -> Vec<EdgeId> {
    let mut entries = Stepper::new(mesh, policies, start, protect).entries();
    if count < entries.len() {
        let by_cost = |a: &Entry, b: &Entry| a.cost.total_cmp(&b.cost).then(a.edge.cmp(&b.edge));
        entries.select_nth_unstable_by(count, by_cost);
        entries.truncate(count);
    }
    entries.into_iter().map(|entry| entry.edge).collect()
}

/// The number of edges that are evaluated ahead of their turns.
const LOOK_AHEAD: usize = 32;

/// The number of chunks of this size if several threads share the work.
const CHUNKS: usize = 4;

fn run_in_rounds<C: Cost, P: Placement>(
    stepper: &mut Stepper<'_, C, P>,
    entries: Vec<Entry>,
    watch: &mut TargetCheck<'_>,
) -> StopReason {
    let mut rounds = Rounds::new(stepper.mesh().topology(), &entries);
    drop(entries);
    let mut round = Round::default();
    let mut bounds = Vec::with_capacity(LOOK_AHEAD);
    let looks_ahead = stepper.looks_ahead();
    // The number of collapses at the last evaluation of all costs.
    let mut checked = None;
    loop {
        if let Some(reason) = stepper.reached(watch) {
            return reason;
        }
        if !rounds.take(&mut round) {
            if stepper.readmit_later(&mut rounds) {
                continue;
            }
            let Some(others) = stepper.others() else { return StopReason::NothingLeft };
            rounds.refill(stepper.mesh().topology(), &others);
            continue;
        }
        if round.least > watch.cost() {
            if stepper.is_part() || checked == Some(stepper.collapses()) {
                return StopReason::Cost;
            }
            // The keys are costs from the time when the edges were added. Some may have fallen since.
            checked = Some(stepper.collapses());
            let entries = stepper.entries();
            rounds.refill(stepper.mesh().topology(), &entries);
            continue;
        }
        let threshold = round.threshold.min(watch.cost());
        for (chunk, ahead) in round.visits.chunks(LOOK_AHEAD).enumerate() {
            if looks_ahead && chunk.is_multiple_of(CHUNKS) {
                let coming = &round.visits[chunk * LOOK_AHEAD..];
                stepper.look_ahead(&coming[..coming.len().min(CHUNKS * LOOK_AHEAD)], threshold);
            }
            // The early bounds of the next edges bring their surroundings into the cache. Unlike collapses, these
            // accesses are independent of each other.
            bounds.clear();
            bounds.extend(ahead.iter().map(|visit| stepper.early_bound(visit.edge)));
            for (i, (&visit, &bound)) in ahead.iter().zip(&bounds).enumerate() {
                if !stepper.mesh().topology().contains_edge(visit.edge) {
                    continue;
                }
                if let Some(reason) = stepper.reached(watch) {
                    return reason;
                }
                let turn = if bound > threshold {
                    Turn::Above(bound)
                } else {
                    if looks_ahead {
                        stepper.recall(chunk % CHUNKS * LOOK_AHEAD + i);
                    }
                    stepper.take_turn(visit.edge, threshold, &mut rounds)
                };
                if let Turn::Above(cost) = turn {
                    rounds.push_above(Visit { cost, ..visit });
                }
            }
        }
    }
}

fn run_in_order<C: Cost, P: Placement>(
    stepper: &mut Stepper<'_, C, P>,
    entries: Vec<Entry>,
    watch: &mut TargetCheck<'_>,
) -> StopReason {
    let mut heap = Heap::new(stepper.mesh().topology().edge_capacity(), entries);
    let mut stale = Vec::new();
    let mut checked = None;
    loop {
        if let Some(reason) = stepper.reached(watch) {
            return reason;
        }
        let Some(Entry { cost: key, edge }) = heap.pop(stepper.mesh().topology()) else {
            if stepper.readmit_later(&mut heap) {
                continue;
            }
            let Some(others) = stepper.others() else { return StopReason::NothingLeft };
            heap = Heap::new(stepper.mesh().topology().edge_capacity(), others);
            continue;
        };
        if key > watch.cost() {
            if stepper.is_part() || checked == Some(stepper.collapses()) {
                return StopReason::Cost;
            }
            // Some costs may have fallen outside the reach that is updated after each collapse.
            checked = Some(stepper.collapses());
            let entries = stepper.entries();
            heap = Heap::new(stepper.mesh().topology().edge_capacity(), entries);
            continue;
        }
        match stepper.take_turn(edge, heap.least().min(watch.cost()), &mut heap) {
            Turn::Collapsed => refresh(stepper, &mut heap, &mut stale),
            Turn::Above(cost) => heap.push(edge, cost),
            Turn::Refused => {}
        }
    }
}

/// Evaluates all edges within reach of the last collapse again. Edges with a new key are pushed again; the heap
/// recognises the old entry as out of date.
fn refresh<C: Cost, P: Placement>(
    stepper: &mut Stepper<'_, C, P>,
    heap: &mut Heap,
    stale: &mut Vec<EdgeId>,
) {
    stepper.list_stale(stale);
    for &edge in &*stale {
        match stepper.key(edge) {
            Some(cost) => heap.push(edge, cost),
            None => heap.refuse(edge),
        }
    }
    heap.tidy(stepper.mesh().topology());
}
