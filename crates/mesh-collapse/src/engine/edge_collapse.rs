//! The greedy loop: collapse the cheapest edges, bring their neighbourhood up to date, go on.
//!
//! How edges wait for their turn is what [`Schedule`] chooses:
//!
//! - [`Schedule::Lazy`], and [`Schedule::Parallel`] where these will not do, takes the cheapest few percent
//!   of them at a time, by keys that may be out of date, and visits them in the order in which they are
//!   stored ([`Rounds`]). Neighbours are then in the cache, and no edge is evaluated that is not about
//!   to be collapsed.
//! - [`Schedule::Exact`] keeps all keys up to date in a heap ([`Heap`]), and is exact.
//!
//! An edge that is known to cost more than a threshold goes back to where it waits, with what is known
//! as its key.

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
/// Takes O(n log n) time as long as valences are bounded.
pub fn collapse_edges<C: Cost, P: Placement>(
    mesh: &mut TriMesh,
    policies: Policies<C, P>,
    protect: &Protect,
    limits: &Target,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    collapse_edges_from(mesh, policies, Start::default(), protect, limits, observe)
}

/// The same for a run that does not begin with nothing. It returns the constraints that followed the mesh as they
/// are then.
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
        // Most collapses take two faces.
        stepper.expect_collapses(faces.saturating_sub(limits.face_target(faces)) / 2);
    }
    let mut watch = TargetCheck::new(limits, faces, observe);
    let stop = match schedule {
        Schedule::Lazy | Schedule::Parallel => run_in_rounds(&mut stepper, entries, &mut watch),
        Schedule::Exact => run_in_order(&mut stepper, entries, &mut watch),
    };
    stepper.finish(stop)
}

/// So many of the edges that cost least to collapse.
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

/// How many edges are looked at before they have their turn.
const LOOK_AHEAD: usize = 32;

/// How many chunks of these are, where that keeps several threads busy.
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
    // How many collapses there were when all costs were looked at anew.
    let mut checked = None;
    loop {
        if let Some(reason) = stepper.reached(watch) {
            return reason;
        }
        if !rounds.take(&mut round) {
            let Some(others) = stepper.others() else { return StopReason::NothingLeft };
            rounds.refill(stepper.mesh().topology(), &others);
            continue;
        }
        if round.least > watch.cost() {
            if stepper.is_part() || checked == Some(stepper.collapses()) {
                return StopReason::Cost;
            }
            // These are the costs of the time when the edges came, and some may have fallen since.
            checked = Some(stepper.collapses());
            let entries = stepper.entries();
            rounds.refill(stepper.mesh().topology(), &entries);
            continue;
        }
        let ceiling = round.ceiling.min(watch.cost());
        for (chunk, ahead) in round.visits.chunks(LOOK_AHEAD).enumerate() {
            if looks_ahead && chunk.is_multiple_of(CHUNKS) {
                let coming = &round.visits[chunk * LOOK_AHEAD..];
                stepper.look_ahead(&coming[..coming.len().min(CHUNKS * LOOK_AHEAD)], ceiling);
            }
            // The early bounds of edges whose turn comes soon bring their surroundings into the
            // cache, many at a time: the edges do not wait for each other, as collapses do.
            bounds.clear();
            bounds.extend(ahead.iter().map(|visit| stepper.early_bound(visit.edge)));
            for (i, (&visit, &bound)) in ahead.iter().zip(&bounds).enumerate() {
                if !stepper.mesh().topology().contains_edge(visit.edge) {
                    continue;
                }
                if let Some(reason) = stepper.reached(watch) {
                    return reason;
                }
                let turn = if bound > ceiling {
                    Turn::Above(bound)
                } else {
                    if looks_ahead {
                        stepper.recall(chunk % CHUNKS * LOOK_AHEAD + i);
                    }
                    stepper.take_turn(visit.edge, ceiling, &mut rounds)
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
            let Some(others) = stepper.others() else { return StopReason::NothingLeft };
            heap = Heap::new(stepper.mesh().topology().edge_capacity(), others);
            continue;
        };
        if key > watch.cost() {
            if stepper.is_part() || checked == Some(stepper.collapses()) {
                return StopReason::Cost;
            }
            // Some costs may have fallen beyond the reach that is looked at after each collapse.
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

/// Evaluates all edges within reach of the last collapse again. Those whose key has changed are put
/// into the heap anew; the old entry is noticed to be out of date.
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
