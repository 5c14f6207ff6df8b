//! Look-ahead: rows of flips that lower the cost together where none does alone (DHKL01 sec. 3).
//!
//! A row starts at an edge; each further flip is at a side of a quadrilateral that the row has
//! flipped. DHKL01 tries rows of two. The flips of a row are done, measured and undone.

use mesh_core::EdgeId;

use crate::cost::{Change, FlipCost};
use crate::quad::Quad;
use crate::run::Run;

/// A row of flips with what each changes.
type Row = Vec<(EdgeId, Change)>;

/// What the best row that begins with this edge changes, if that lowers the cost.
#[inline]
pub(crate) fn best_change<C: FlipCost>(
    run: &mut Run<'_, C>,
    edge: EdgeId,
    look_ahead: usize,
) -> Option<Change> {
    if look_ahead < 2 {
        return None;
    }
    best_row(run, edge, look_ahead).map(|row| total(&row))
}

/// The best row of up to `look_ahead` flips that begins with this edge and lowers the cost; of
/// equally good ones the first found, and so the shortest.
pub(crate) fn best_row<C: FlipCost>(
    run: &mut Run<'_, C>,
    edge: EdgeId,
    look_ahead: usize,
) -> Option<Row> {
    if look_ahead < 2 {
        return None;
    }
    let mut search = Search { look_ahead, row: Row::new(), open: Vec::new(), best: None };
    search.extend(run, edge);
    search.best
}

fn total(row: &[(EdgeId, Change)]) -> Change {
    row.iter().fold(Change::default(), |sum, &(_, change)| sum.then(change))
}

struct Search {
    look_ahead: usize,
    row: Row,
    /// The sides of the quadrilaterals flipped so far.
    open: Vec<EdgeId>,
    best: Option<Row>,
}

impl Search {
    /// Adds an edge to the row if it may flip, judges the row, goes on from there, and takes the
    /// edge away again.
    fn extend<C: FlipCost>(&mut self, run: &mut Run<'_, C>, edge: EdgeId) {
        let (Some(change), Ok(flip)) = (run.change(edge), run.allow(edge)) else { return };
        let Some(quad) = run.turn(flip) else { return };
        self.row.push((edge, change));
        self.judge(run);
        if self.row.len() < self.look_ahead {
            self.go_on(run, &quad);
        }
        self.row.pop();
        run.turn_back(edge);
    }

    fn judge<C: FlipCost>(&mut self, run: &Run<'_, C>) {
        let change = total(&self.row);
        // A later row has to be better by more than rounding.
        let better = self.best.as_ref().is_none_or(|row| {
            let best = total(row).gain();
            change.gain() > best + 1e-10 * best.abs()
        });
        if better && run.is_gain(change) {
            self.best = Some(self.row.clone());
        }
    }

    fn go_on<C: FlipCost>(&mut self, run: &mut Run<'_, C>, quad: &Quad) {
        let known = self.open.len();
        for side in quad.sides {
            if !self.open.contains(&side.edge()) {
                self.open.push(side.edge());
            }
        }
        for i in 0..self.open.len() {
            let edge = self.open[i];
            if self.row.last().is_none_or(|&(last, _)| last != edge) {
                self.extend(run, edge);
            }
        }
        self.open.truncate(known);
    }
}
