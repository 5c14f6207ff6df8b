//! Look-ahead: rows of flips that lower the cost together where none does alone (DHKL01 sec. 3).
//!
//! A row starts at an edge; each further flip is at a side of a quadrilateral that the row has
//! flipped. DHKL01 tries rows of two. The flips of a row are done, measured and undone.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use mesh_core::{EdgeId, FaceTree, TriMesh, parallel};

use crate::cost::{Change, FlipCost};
use crate::quad::Quad;
use crate::report::Stop;
use crate::rules::Rules;
use crate::run::Run;
use crate::trial::Trial;
use crate::watch::{Phase, Progress, Watch};

/// A row of flips with what each changes.
type Row = Vec<(EdgeId, Change)>;

/// What the best row that begins with this edge changes, if that lowers the cost.
#[inline]
pub(crate) fn best_change<C: FlipCost>(
    rules: &Rules<'_, C>,
    trial: &mut Trial<'_, C>,
    edge: EdgeId,
    look_ahead: usize,
) -> Option<Change> {
    if look_ahead < 2 {
        return None;
    }
    best_row(rules, trial, edge, look_ahead).map(|row| total(&row))
}

/// [`best_change`] of many edges, on copies of the mesh and on all cores; or why to stop before that.
pub(crate) fn best_changes<C: FlipCost>(
    run: &Run<'_, C>,
    edges: &[EdgeId],
    look_ahead: usize,
    watch: &mut Watch<'_>,
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
            waiting: (edges.len() - changes.len()) as u64,
        };
        if let Some(stop) = watch.look(now) {
            return Err(stop);
        }
        changes.extend(parallel::collect_with(
            block.len(),
            || Lent::new(&spare, copy),
            |lent, i| {
                let Scratch { mesh, cache, tree } = lent.copy.as_mut()?;
                let tree = tree.as_mut();
                let mut trial = Trial { cost: rules.cost, mesh, cache, tree };
                best_change(rules, &mut trial, block[i], look_ahead)
            },
        ));
    }
    Ok(changes)
}

/// How many edges are looked at between two looks at the clock: the effort grows sixfold with each
/// step ahead.
fn block_length(look_ahead: usize) -> usize {
    const FOR_TWO: usize = 1 << 14;
    (FOR_TWO / 6_usize.saturating_pow(look_ahead as u32 - 2)).max(32)
}

/// What one thread tries flips on.
struct Scratch<C: FlipCost> {
    mesh: TriMesh,
    cache: C::Cache,
    tree: Option<FaceTree>,
}

/// A copy that goes back to where it was taken from, for the next block.
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

/// The best row of up to `look_ahead` flips that begins with this edge and lowers the cost; of
/// equally good ones the first found, and so the shortest. None when the time is over.
pub(crate) fn best_row<C: FlipCost>(
    rules: &Rules<'_, C>,
    trial: &mut Trial<'_, C>,
    edge: EdgeId,
    look_ahead: usize,
) -> Option<Row> {
    if look_ahead < 2 {
        return None;
    }
    let mut search =
        Search { rules, look_ahead, row: Row::new(), open: Vec::new(), best: None, tried: 0 };
    search.extend(trial, edge);
    search.best
}

fn total(row: &[(EdgeId, Change)]) -> Change {
    row.iter().fold(Change::default(), |sum, &(_, change)| sum.then(change))
}

struct Search<'r, 'a, C: FlipCost> {
    rules: &'r Rules<'a, C>,
    look_ahead: usize,
    row: Row,
    /// The sides of the quadrilaterals flipped so far.
    open: Vec<EdgeId>,
    best: Option<Row>,
    tried: u32,
}

/// How many flips are tried between two looks at the clock.
const INTERVAL: u32 = 1024;

impl<C: FlipCost> Search<'_, '_, C> {
    /// Adds an edge to the row if it may flip, judges the row, goes on from there, and takes the
    /// edge away again.
    fn extend(&mut self, trial: &mut Trial<'_, C>, edge: EdgeId) {
        if self.is_over() {
            self.best = None;
            return;
        }
        let change = self.rules.change(trial.mesh, trial.cache, edge);
        let flip = self.rules.allow(trial.mesh, trial.tree.as_deref(), edge);
        let (Some(change), Ok(flip)) = (change, flip) else { return };
        let Some(quad) = trial.turn(flip) else { return };
        self.row.push((edge, change));
        self.judge();
        if self.row.len() < self.look_ahead {
            self.go_on(trial, &quad);
        }
        self.row.pop();
        trial.turn_back(edge);
    }

    /// Whether the time is over, and then for good.
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

    fn judge(&mut self) {
        let change = total(&self.row);
        // A later row has to be better by more than rounding.
        let better = self.best.as_ref().is_none_or(|row| {
            let best = total(row).gain();
            change.gain() > best + 1e-10 * best.abs()
        });
        if better && self.rules.is_gain(change) {
            self.best = Some(self.row.clone());
        }
    }

    fn go_on(&mut self, trial: &mut Trial<'_, C>, quad: &Quad) {
        let known = self.open.len();
        for side in quad.sides {
            if !self.open.contains(&side.edge()) {
                self.open.push(side.edge());
            }
        }
        for i in 0..self.open.len() {
            let edge = self.open[i];
            if self.row.last().is_none_or(|&(last, _)| last != edge) {
                self.extend(trial, edge);
            }
        }
        self.open.truncate(known);
    }
}
