//! The greedy run of DHKL01 sec. 3: the flip with the largest gain, while there is one.

use core::iter::zip;

use mesh_core::SplitMix64;
use mesh_core::{EdgeId, Handle, parallel};

use crate::cost::{Change, FlipCost, Reach};
use crate::crowded::Crowded;
use crate::look_ahead;
use crate::options::{Ties, Update};
use crate::quad::Quad;
use crate::queue::IndexedQueue;
use crate::region::Region;
use crate::report::Stop;
use crate::run::Run;
use crate::waiting::{Refusal, Waiting};
use crate::watch::{Phase, Progress, Watch};

/// Flips until nothing helps or the watch says stop. On return the mesh is in a valid state whose
/// cost is no higher than at the beginning.
pub(crate) fn run<C: FlipCost>(
    run: &mut Run<'_, C>,
    look_ahead: usize,
    watch: &mut Watch<'_>,
) -> Stop {
    let cycles_before = run.refused.cycle;
    let mut greedy = match Greedy::new(run, look_ahead, watch) {
        Ok(greedy) => greedy,
        Err(stop) => return stop,
    };
    loop {
        let now = || Progress {
            phase: Phase::Greedy,
            flips: run.log.len() as u64,
            cost: run.running_cost,
            waiting: greedy.queue.len() as u64,
        };
        if greedy.queue.len() > 0
            && let Some(stop) = watch.stop(now, run.log.len())
        {
            return stop;
        }
        let Some((edge, key)) = greedy.pop() else {
            if greedy.catch_up(run) {
                continue;
            }
            break;
        };
        greedy.take(run, edge, key, watch.flips_left(run.log.len()));
    }
    if greedy.row_too_long {
        return Stop::FlipLimit;
    }
    if run.refused.cycle > cycles_before { Stop::CycleGuard } else { Stop::LocalMinimum }
}

/// The queue of edges by gain, and what keeps it exact.
struct Greedy {
    queue: IndexedQueue,
    order: TieOrder,
    region: Region,
    waiting: Waiting,
    crowded: Crowded,
    /// Edges whose gains may have changed, their quadrilaterals, and what their flips change.
    outdated: Vec<EdgeId>,
    quads: Vec<Option<Quad>>,
    changes: Vec<Option<Change>>,
    reach: Reach,
    /// How many flips in a row are tried.
    look_ahead: usize,
    /// Whether a row was left out because it would have gone beyond the limit of flips.
    row_too_long: bool,
    /// How many of them an update has to allow for beyond the first.
    steps_ahead: usize,
}

impl Greedy {
    /// Computes the gains of all edges; or says why to stop before that.
    fn new<C: FlipCost>(
        run: &Run<'_, C>,
        look_ahead: usize,
        watch: &mut Watch<'_>,
    ) -> Result<Self, Stop> {
        let topology = run.mesh.topology();
        let edges = topology.edge_capacity();
        let order = TieOrder::new(run.rules.options.ties, edges);
        let (reach, steps_ahead) = match run.rules.options.update {
            Update::Exact => (run.rules.cost.reach(), look_ahead.saturating_sub(1)),
            Update::TwoNeighbourhood => (Reach::AdjacentTriangles, 0),
        };
        let region = Region::new(topology);
        let waiting = Waiting::new(topology);
        let mut changes = parallel::collect_blocks::<_, _, 16>(
            edges,
            || (),
            |(), indices| {
                let mut quads = [None; 16];
                for (quad, edge) in zip(&mut quads, indices.map(EdgeId::from_index)) {
                    *quad = run.quad(edge);
                }
                let mut changes = [None; 16];
                run.gainful_changes(&quads, &mut changes);
                changes
            },
        );
        if look_ahead > 1 {
            let stuck: Vec<EdgeId> = (0..edges)
                .filter(|&index| changes[index].is_none())
                .map(EdgeId::from_index)
                .collect();
            let rows = look_ahead::best_changes(run, &stuck, look_ahead, watch)?;
            for (edge, row) in zip(stuck, rows) {
                changes[edge.index()] = row;
            }
        }
        let keys = (0..edges as u32).map(|item| changes[order.edge(item).index()].map(key));
        let queue = IndexedQueue::new(keys);
        Ok(Self {
            queue,
            order,
            region,
            waiting,
            crowded: Crowded::default(),
            outdated: Vec::new(),
            quads: Vec::new(),
            changes: Vec::new(),
            reach,
            look_ahead,
            row_too_long: false,
            steps_ahead,
        })
    }

    fn pop(&mut self) -> Option<(EdgeId, f64)> {
        self.queue.pop().map(|(item, key)| (self.order.edge(item), key))
    }

    /// Flips an edge whose turn has come, alone or as the first of a row, or refuses it.
    fn take<C: FlipCost>(
        &mut self,
        run: &mut Run<'_, C>,
        edge: EdgeId,
        key: f64,
        flips_left: usize,
    ) {
        let is_old = self.is_outdated(run, edge);
        if is_old && self.look_ahead < 2 && !self.is_still_best(run, edge, key) {
            return;
        }
        match self.single_change(run, edge, key, is_old) {
            Some(change) => match run.allow(edge) {
                Ok(flip) => {
                    if let Some(quad) = run.flip(flip, change) {
                        self.refresh(run, &[quad]);
                        self.keep_if_real(run, &quad, change);
                    }
                }
                Err(refusal) => self.refuse(run, edge, refusal),
            },
            None => self.take_row(run, edge, flips_left, is_old),
        }
    }

    /// Whether a flip at a crowded vertex may have changed the gain of an edge unseen.
    fn is_outdated<C: FlipCost>(&self, run: &Run<'_, C>, edge: EdgeId) -> bool {
        let is_outdated = |quad: Quad| quad.corners.iter().any(|&v| self.crowded.is_outdated(v));
        run.quad(edge).is_some_and(is_outdated)
    }

    /// Computes the gain of an edge again, and puts it back when it has become less.
    fn is_still_best<C: FlipCost>(&mut self, run: &Run<'_, C>, edge: EdgeId, old: f64) -> bool {
        let new = run.gainful_change(edge).map(key);
        if new.is_none_or(|new| new < old) {
            self.queue.set(self.order.item(edge), new);
            return false;
        }
        true
    }

    /// Brings the crowded vertices up to date. Says whether there were any that were not.
    fn catch_up<C: FlipCost>(&mut self, run: &mut Run<'_, C>) -> bool {
        let outdated = self.crowded.take();
        self.outdated.clear();
        for &vertex in &outdated {
            let edges = self.region.star(run.mesh.topology(), vertex);
            self.outdated.extend_from_slice(edges);
        }
        self.reassess(run);
        !outdated.is_empty()
    }

    /// Undoes a flip, just done, whose way back is a gain, too; the edge waits for a change near it.
    fn keep_if_real<C: FlipCost>(&mut self, run: &mut Run<'_, C>, quad: &Quad, change: Change) {
        let way_back = zip(&self.outdated, &self.changes).find(|&(&edge, _)| edge == quad.edge);
        if run.rules.cost.is_potential() && way_back.is_some_and(|(_, change)| change.is_some()) {
            run.undo_rounding(change);
            self.refresh(run, &[*quad]);
            self.queue.set(self.order.item(quad.edge), None);
        }
    }

    /// What the flip of an edge from the queue changes, if that alone is a gain. When only single
    /// flips are in the queue and the update is exact, the key tells.
    #[inline]
    fn single_change<C: FlipCost>(
        &self,
        run: &Run<'_, C>,
        edge: EdgeId,
        key: f64,
        is_old: bool,
    ) -> Option<Change> {
        if self.look_ahead < 2 && run.rules.options.update == Update::Exact && !is_old {
            return Some(Change { before: key, after: 0.0 });
        }
        run.gainful_change(edge)
    }

    /// Does the best row of flips that begins with this edge.
    fn take_row<C: FlipCost>(
        &mut self,
        run: &mut Run<'_, C>,
        edge: EdgeId,
        flips_left: usize,
        is_old: bool,
    ) {
        let (rules, mut trial) = run.trial();
        let Some(row) = look_ahead::best_row(rules, &mut trial, edge, self.look_ahead) else {
            run.refused.stale += u64::from(!is_old);
            return;
        };
        if row.len() > flips_left {
            self.row_too_long = true;
            return;
        }
        let mut quads = Vec::with_capacity(row.len());
        for (edge, change) in row {
            if let Ok(flip) = run.allow(edge) {
                quads.extend(run.flip(flip, change));
            }
        }
        self.refresh(run, &quads);
    }

    /// Leaves an edge out until the reason has gone away.
    fn refuse<C: FlipCost>(&mut self, run: &mut Run<'_, C>, edge: EdgeId, refusal: Refusal) {
        let refused = &mut run.refused;
        match refusal {
            Refusal::ValenceThree(_) => refused.valence_three += 1,
            Refusal::DiagonalExists(_) => refused.diagonal_exists += 1,
            Refusal::Flat => refused.flat += 1,
            Refusal::Fold => refused.fold += 1,
            Refusal::Intersection(_) => refused.intersection += 1,
            Refusal::Cycle => refused.cycle += 1,
            Refusal::Never => {}
        }
        self.waiting.add(edge, refusal);
        // The row that begins with another edge may still lead past the obstacle; one that begins
        // with this edge cannot.
    }

    /// Computes the gains again that may differ after these flips.
    fn refresh<C: FlipCost>(&mut self, run: &mut Run<'_, C>, flipped: &[Quad]) {
        self.outdated.clear();
        let mut overdue = Vec::new();
        for quad in flipped {
            let topology = run.mesh.topology();
            let affected = self.region.affected(topology, quad, self.reach, self.steps_ahead);
            self.outdated.extend_from_slice(affected);
            for &vertex in self.region.crowded() {
                if self.crowded.note(topology, vertex) {
                    overdue.push(vertex);
                }
            }
            self.waiting.wake(topology, quad.edge, &mut self.outdated);
        }
        for &vertex in &overdue {
            self.outdated.extend_from_slice(self.region.star(run.mesh.topology(), vertex));
        }
        if flipped.len() > 1 || !overdue.is_empty() {
            self.outdated.sort_unstable();
            self.outdated.dedup();
        }
        self.reassess(run);
    }

    /// Computes the gains of the outdated edges.
    fn reassess<C: FlipCost>(&mut self, run: &mut Run<'_, C>) {
        self.quads.clear();
        self.quads.extend(self.outdated.iter().map(|&edge| run.quad(edge)));
        self.changes.clear();
        self.changes.resize(self.quads.len(), None);
        run.gainful_changes(&self.quads, &mut self.changes);
        let (rules, mut trial) = run.trial();
        for (&edge, &single) in zip(&self.outdated, &self.changes) {
            let row = || look_ahead::best_change(rules, &mut trial, edge, self.look_ahead);
            let best = single.or_else(row);
            self.queue.set(self.order.item(edge), best.map(key));
        }
    }
}

/// The gain, rounded to 34 binary digits: gains that are equal but for rounding become ties.
#[inline]
fn key(change: Change) -> f64 {
    const DROPPED: u32 = 52 - 34;
    let half = 1_u64 << (DROPPED - 1);
    let bits = change.gain().to_bits();
    f64::from_bits((bits.saturating_add(half) >> DROPPED) << DROPPED).min(f64::MAX)
}

/// The order of edges with the same gain: the queue's items are places in it.
struct TieOrder(Option<Permutation>);

struct Permutation {
    edge_of_item: Vec<u32>,
    item_of_edge: Vec<u32>,
}

impl TieOrder {
    fn new(ties: Ties, edges: usize) -> Self {
        let Ties::Seeded(seed) = ties else { return Self(None) };
        let mut random = SplitMix64::new(seed);
        let mut edge_of_item: Vec<u32> = (0..edges as u32).collect();
        for last in (1..edges).rev() {
            let other = (random.uniform() * (last + 1) as f64) as usize;
            edge_of_item.swap(last, other.min(last));
        }
        let mut item_of_edge = vec![0; edges];
        for (item, &edge) in edge_of_item.iter().enumerate() {
            item_of_edge[edge as usize] = item as u32;
        }
        Self(Some(Permutation { edge_of_item, item_of_edge }))
    }

    #[inline]
    fn edge(&self, item: u32) -> EdgeId {
        EdgeId::new(self.0.as_ref().map_or(item, |p| p.edge_of_item[item as usize]))
    }

    #[inline]
    fn item(&self, edge: EdgeId) -> u32 {
        self.0.as_ref().map_or(edge.get(), |p| p.item_of_edge[edge.index()])
    }
}
