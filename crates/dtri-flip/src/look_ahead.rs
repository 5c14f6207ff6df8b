//! Look-ahead: sequences of flips that lower the cost where no single flip does (DHKL01 sec. 3).
//!
//! A sequence starts at an edge. Each further flip is at a side of a quadrilateral that the sequence
//! has flipped. DHKL01 uses sequences of two flips. Flips are performed, evaluated and undone.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use mesh_core::{EdgeId, FaceTree, TriMesh, as_u32, parallel};

use crate::cost::{Change, FlipCost};
use crate::flip_state::FlipState;
use crate::progress::{Monitor, Phase, Progress};
use crate::quad::Quad;
use crate::report::Stop;
use crate::rules::Rules;
use crate::run::Run;

/// A sequence of flips with the change of each.
type Sequence = Vec<(EdgeId, Change)>;

/// The change of the best sequence that starts with this edge, if it lowers the cost.
#[inline]
pub(crate) fn best_change<C: FlipCost>(
    rules: &Rules<'_, C>,
    state: &mut FlipState<'_, C>,
    edge: EdgeId,
    look_ahead: usize,
) -> Option<Change> {
    if look_ahead < 2 {
        return None;
    }
    best_sequence(rules, state, edge, look_ahead).map(|sequence| total(&sequence))
}

/// [`best_change`] of many edges in parallel, on copies of the mesh. Returns the reason if the monitor
/// stops the search.
pub(crate) fn best_changes<C: FlipCost>(
    run: &Run<'_, C>,
    edges: &[EdgeId],
    look_ahead: usize,
    monitor: &mut Monitor<'_>,
) -> Result<Vec<Option<Change>>, Stop> {
    if look_ahead < 2 {
        return Ok(vec![None; edges.len()]);
    }
    let (rules, spare) = (&run.rules, Mutex::new(Vec::<Scratch<C>>::new()));
    let copy =
        || Scratch { mesh: run.mesh.clone(), cache: run.cache.clone(), tree: run.tree.clone() };
    let mut changes = Vec::with_capacity(edges.len());
    for block in edges.chunks(block_length(look_ahead)) {
        let now = || Progress {
            phase: Phase::Greedy,
            flips: run.log.len() as u64,
            cost: run.running_cost,
            remaining: (edges.len() - changes.len()) as u64,
        };
        if let Some(stop) = monitor.check(now) {
            return Err(stop);
        }
        changes.extend(parallel::collect_with(
            block.len(),
            || Lent::new(&spare, copy),
            |lent, i| {
                let Scratch { mesh, cache, tree } = lent.copy.as_mut()?;
                let tree = tree.as_mut();
                let mut state = FlipState { cost: rules.cost, mesh, cache, tree };
                best_change(rules, &mut state, block[i], look_ahead)
            },
        ));
    }
    Ok(changes)
}

/// Number of edges between two checks of the clock. The effort grows sixfold with each further flip.
fn block_length(look_ahead: usize) -> usize {
    const FOR_TWO: usize = 1 << 14;
    (FOR_TWO / 6_usize.saturating_pow(as_u32(look_ahead) - 2)).max(32)
}

/// The copy of the state that one thread flips.
struct Scratch<C: FlipCost> {
    mesh: TriMesh,
    cache: C::Cache,
    tree: Option<FaceTree>,
}

/// A copy that returns to the pool on drop, for the next block.
struct Lent<'s, C: FlipCost> {
    copy: Option<Scratch<C>>,
    spare: &'s Mutex<Vec<Scratch<C>>>,
}

impl<'s, C: FlipCost> Lent<'s, C> {
    fn new(spare: &'s Mutex<Vec<Scratch<C>>>, make: impl Fn() -> Scratch<C>) -> Self {
        let taken = spare.lock().unwrap_or_else(PoisonError::into_inner).pop();
        Self { copy: Some(taken.unwrap_or_else(make)), spare }
    }
}

impl<C: FlipCost> Drop for Lent<'_, C> {
    fn drop(&mut self) {
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).extend(self.copy.take());
    }
}

/// The best sequence of up to `look_ahead` flips that starts with this edge and lowers the cost. Among
/// equal ones the first found wins, which is the shortest. `None` after the time limit.
pub(crate) fn best_sequence<C: FlipCost>(
    rules: &Rules<'_, C>,
    state: &mut FlipState<'_, C>,
    edge: EdgeId,
    look_ahead: usize,
) -> Option<Sequence> {
    if look_ahead < 2 {
        return None;
    }
    let mut search = Search {
        rules,
        look_ahead,
        sequence: Sequence::new(),
        open: Vec::new(),
        best: None,
        tried: 0,
    };
    search.extend(state, edge);
    search.best
}

fn total(sequence: &[(EdgeId, Change)]) -> Change {
    sequence.iter().fold(Change::default(), |sum, &(_, change)| sum.then(change))
}

struct Search<'r, 'a, C: FlipCost> {
    rules: &'r Rules<'a, C>,
    look_ahead: usize,
    sequence: Sequence,
    /// Sides of the quadrilaterals flipped so far.
    open: Vec<EdgeId>,
    best: Option<Sequence>,
    tried: u32,
}

/// Number of flips between two checks of the clock.
const INTERVAL: u32 = 1024;

impl<C: FlipCost> Search<'_, '_, C> {
    /// Appends an edge to the sequence if it may flip, evaluates the sequence, searches from there, and
    /// removes the edge again.
    fn extend(&mut self, state: &mut FlipState<'_, C>, edge: EdgeId) {
        if self.is_over() {
            self.best = None;
            return;
        }
        let change = self.rules.change(state.mesh, state.cache, edge);
        let flip = self.rules.allow(state.mesh, state.tree.as_deref(), edge);
        let (Some(change), Ok(flip)) = (change, flip) else { return };
        let Some(quad) = state.flip(flip) else { return };
        self.sequence.push((edge, change));
        self.evaluate();
        if self.sequence.len() < self.look_ahead {
            self.search_sides(state, &quad);
        }
        self.sequence.pop();
        state.flip_back(edge);
    }

    /// Whether the time limit has passed. Once true, it stays true.
    fn is_over(&mut self) -> bool {
        let Some(deadline) = self.rules.deadline else { return false };
        if self.tried != u32::MAX {
            self.tried = (self.tried + 1) % INTERVAL;
            if self.tried == 0 && Instant::now() >= deadline {
                self.tried = u32::MAX;
            }
        }
        self.tried == u32::MAX
    }

    fn evaluate(&mut self) {
        let change = total(&self.sequence);
        // A later sequence must be better by more than rounding.
        let better = self.best.as_ref().is_none_or(|sequence| {
            let best = total(sequence).gain();
            change.gain() > best + 1e-10 * best.abs()
        });
        if better && self.rules.is_gain(change) {
            self.best = Some(self.sequence.clone());
        }
    }

    fn search_sides(&mut self, state: &mut FlipState<'_, C>, quad: &Quad) {
        let known = self.open.len();
        for side in quad.sides {
            if !self.open.contains(&side.edge()) {
                self.open.push(side.edge());
            }
        }
        for i in 0..self.open.len() {
            let edge = self.open[i];
            if self.sequence.last().is_none_or(|&(last, _)| last != edge) {
                self.extend(state, edge);
            }
        }
        self.open.truncate(known);
    }
}
