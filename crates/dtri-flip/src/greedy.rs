//! The greedy run of DHKL01 sec. 3: the flip with the largest gain, while there is one.

use core::iter::zip;

use mesh_core::{EdgeId, Handle, parallel};
use mesh_core::{SplitMix64, as_u32};

use crate::affected_edges::AffectedEdges;
use crate::blocked_edges::{BlockedEdges, Rejection};
use crate::cost::{Change, FlipCost, Stencil};
use crate::high_valence::HighValence;
use crate::look_ahead;
use crate::options::{Ties, Update};
use crate::progress::{Monitor, Phase, Progress};
use crate::quad::Quad;
use crate::queue::IndexedQueue;
use crate::report::Stop;
use crate::run::Run;

/// Flips edges until no flip lowers the cost or the monitor stops the run. The cost never rises.
pub(crate) fn run<C: FlipCost>(
    run: &mut Run<'_, C>,
    look_ahead: usize,
    monitor: &mut Monitor<'_>,
) -> Stop {
    let cycles_before = run.rejected.cycle;
    let mut greedy = match Greedy::new(run, look_ahead, monitor) {
        Ok(greedy) => greedy,
        Err(stop) => return stop,
    };
    loop {
        let now = || Progress {
            phase: Phase::Greedy,
            flips: run.log.len() as u64,
            cost: run.running_cost,
            remaining: greedy.queue.len() as u64,
        };
        if greedy.queue.len() > 0
            && let Some(stop) = monitor.stop(now, run.log.len())
        {
            return stop;
        }
        let Some((edge, key)) = greedy.pop() else {
            if greedy.refresh_high_valence(run) {
                continue;
            }
            break;
        };
        greedy.take(run, edge, key, monitor.flips_left(run.log.len()));
    }
    if greedy.exceeded_flip_limit {
        return Stop::FlipLimit;
    }
    if run.rejected.cycle > cycles_before { Stop::CycleGuard } else { Stop::LocalMinimum }
}

/// The queue of edges ordered by gain, and the data that keep it exact.
struct Greedy {
    queue: IndexedQueue,
    order: TieOrder,
    affected: AffectedEdges,
    blocked: BlockedEdges,
    high_valence: HighValence,
    /// Edges whose gains may have changed, their quadrilaterals and the new changes.
    outdated: Vec<EdgeId>,
    quads: Vec<Option<Quad>>,
    changes: Vec<Option<Change>>,
    stencil: Stencil,
    /// Largest number of flips in a sequence.
    look_ahead: usize,
    /// Whether a sequence was skipped because it would exceed the flip limit.
    exceeded_flip_limit: bool,
    /// Number of flips after the first that an update must account for.
    steps_ahead: usize,
}

impl Greedy {
    /// Computes the gains of all edges. Returns the reason if the monitor stops that.
    fn new<C: FlipCost>(
        run: &Run<'_, C>,
        look_ahead: usize,
        monitor: &mut Monitor<'_>,
    ) -> Result<Self, Stop> {
        let topology = run.mesh.topology();
        let edges = topology.edge_capacity();
        let order = TieOrder::new(run.rules.options.ties, edges);
        let (stencil, steps_ahead) = match run.rules.options.update {
            Update::Exact => (run.rules.cost.stencil(), look_ahead.saturating_sub(1)),
            Update::TwoNeighbourhood => (Stencil::AdjacentTriangles, 0),
        };
        let affected = AffectedEdges::new(topology);
        let blocked = BlockedEdges::new(topology);
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
            let without_gain: Vec<EdgeId> = (0..edges)
                .filter(|&index| changes[index].is_none())
                .map(EdgeId::from_index)
                .collect();
            let sequences = look_ahead::best_changes(run, &without_gain, look_ahead, monitor)?;
            for (edge, sequence) in zip(without_gain, sequences) {
                changes[edge.index()] = sequence;
            }
        }
        let keys = (0..as_u32(edges)).map(|item| changes[order.edge(item).index()].map(key));
        let queue = IndexedQueue::new(keys);
        Ok(Self {
            queue,
            order,
            affected,
            blocked,
            high_valence: HighValence::default(),
            outdated: Vec::new(),
            quads: Vec::new(),
            changes: Vec::new(),
            stencil,
            look_ahead,
            exceeded_flip_limit: false,
            steps_ahead,
        })
    }

    fn pop(&mut self) -> Option<(EdgeId, f64)> {
        self.queue.pop().map(|(item, key)| (self.order.edge(item), key))
    }

    /// Flips the first edge of the queue, alone or as the start of a sequence, or rejects it.
    fn take<C: FlipCost>(
        &mut self,
        run: &mut Run<'_, C>,
        edge: EdgeId,
        key: f64,
        flips_left: usize,
    ) {
        let is_stale = self.has_stale_gains(run, edge);
        if is_stale && self.look_ahead < 2 && !self.is_still_best(run, edge, key) {
            return;
        }
        match self.single_change(run, edge, key, is_stale) {
            Some(change) => match run.allow(edge) {
                Ok(flip) => {
                    if let Some(quad) = run.flip(flip, change) {
                        self.refresh(run, &[quad]);
                        self.keep_if_real(run, &quad, change);
                    }
                }
                Err(rejection) => self.reject(run, edge, rejection),
            },
            None => self.take_sequence(run, edge, flips_left, is_stale),
        }
    }

    /// Whether the gain of an edge may be stale because a corner has a high valence.
    fn has_stale_gains<C: FlipCost>(&self, run: &Run<'_, C>, edge: EdgeId) -> bool {
        let has_stale_gains =
            |quad: Quad| quad.corners.iter().any(|&v| self.high_valence.has_stale_gains(v));
        run.quad(edge).is_some_and(has_stale_gains)
    }

    /// Computes the gain of an edge again. Requeues the edge if the gain has fallen.
    fn is_still_best<C: FlipCost>(&mut self, run: &Run<'_, C>, edge: EdgeId, old: f64) -> bool {
        let new = run.gainful_change(edge).map(key);
        if new.is_none_or(|new| new < old) {
            self.queue.set(self.order.item(edge), new);
            return false;
        }
        true
    }

    /// Computes the stale gains around vertices of high valence. Returns whether there were any.
    fn refresh_high_valence<C: FlipCost>(&mut self, run: &mut Run<'_, C>) -> bool {
        let outdated = self.high_valence.take_stale();
        self.outdated.clear();
        for &vertex in &outdated {
            let edges = self.affected.star(run.mesh.topology(), vertex);
            self.outdated.extend_from_slice(edges);
        }
        self.reassess(run);
        !outdated.is_empty()
    }

    /// Undoes the last flip if flipping back would be a gain as well: both gains are rounding. The
    /// edge leaves the queue until its neighbourhood changes.
    fn keep_if_real<C: FlipCost>(&mut self, run: &mut Run<'_, C>, quad: &Quad, change: Change) {
        let reverse = zip(&self.outdated, &self.changes).find(|&(&edge, _)| edge == quad.edge);
        if run.rules.cost.is_potential() && reverse.is_some_and(|(_, change)| change.is_some()) {
            run.undo_rounding(change);
            self.refresh(run, &[*quad]);
            self.queue.set(self.order.item(quad.edge), None);
        }
    }

    /// The change of flipping this edge alone, if that is a gain. With single flips and exact updates
    /// the key of the queue is that gain.
    #[inline]
    fn single_change<C: FlipCost>(
        &self,
        run: &Run<'_, C>,
        edge: EdgeId,
        key: f64,
        is_stale: bool,
    ) -> Option<Change> {
        if self.look_ahead < 2 && run.rules.options.update == Update::Exact && !is_stale {
            return Some(Change { before: key, after: 0.0 });
        }
        run.gainful_change(edge)
    }

    /// Performs the best sequence of flips that starts with this edge.
    fn take_sequence<C: FlipCost>(
        &mut self,
        run: &mut Run<'_, C>,
        edge: EdgeId,
        flips_left: usize,
        is_stale: bool,
    ) {
        let (rules, mut state) = run.state();
        let Some(sequence) = look_ahead::best_sequence(rules, &mut state, edge, self.look_ahead)
        else {
            run.rejected.stale += u64::from(!is_stale);
            return;
        };
        if sequence.len() > flips_left {
            self.exceeded_flip_limit = true;
            return;
        }
        let mut quads = Vec::with_capacity(sequence.len());
        for (edge, change) in sequence {
            if let Ok(flip) = run.allow(edge) {
                quads.extend(run.flip(flip, change));
            }
        }
        self.refresh(run, &quads);
    }

    /// Counts a rejected flip and blocks the edge until the cause has changed.
    fn reject<C: FlipCost>(&mut self, run: &mut Run<'_, C>, edge: EdgeId, rejection: Rejection) {
        let counts = &mut run.rejected;
        match rejection {
            Rejection::ValenceThree(_) => counts.valence_three += 1,
            Rejection::DiagonalExists(_) => counts.diagonal_exists += 1,
            Rejection::Flat => counts.flat += 1,
            Rejection::Fold => counts.fold += 1,
            Rejection::Sliver => counts.sliver += 1,
            Rejection::NotConvex => counts.not_convex += 1,
            Rejection::Intersection(_) => counts.intersection += 1,
            Rejection::Cycle => counts.cycle += 1,
            Rejection::Never => {}
        }
        self.blocked.add(edge, rejection);
    }

    /// Updates the gains that these flips may have changed.
    fn refresh<C: FlipCost>(&mut self, run: &mut Run<'_, C>, flipped: &[Quad]) {
        self.outdated.clear();
        let mut overdue = Vec::new();
        for quad in flipped {
            let topology = run.mesh.topology();
            let affected = self.affected.affected(topology, quad, self.stencil, self.steps_ahead);
            self.outdated.extend_from_slice(affected);
            for &vertex in self.affected.high_valence() {
                if self.high_valence.record_flip(topology, vertex) {
                    overdue.push(vertex);
                }
            }
            self.blocked.release_around(topology, quad.edge, &mut self.outdated);
        }
        for &vertex in &overdue {
            self.outdated.extend_from_slice(self.affected.star(run.mesh.topology(), vertex));
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
        let (rules, mut state) = run.state();
        for (&edge, &single) in zip(&self.outdated, &self.changes) {
            let sequence = || look_ahead::best_change(rules, &mut state, edge, self.look_ahead);
            let best = single.or_else(sequence);
            self.queue.set(self.order.item(edge), best.map(key));
        }
    }
}

/// The gain rounded to 34 binary digits, so that gains that differ by rounding only are ties.
#[inline]
fn key(change: Change) -> f64 {
    const DROPPED: u32 = 52 - 34;
    let half = 1_u64 << (DROPPED - 1);
    let bits = change.gain().to_bits();
    f64::from_bits((bits.saturating_add(half) >> DROPPED) << DROPPED).min(f64::MAX)
}

/// The order of edges with equal gains. Items of the queue are positions in this order.
struct TieOrder(Option<Permutation>);

struct Permutation {
    edge_of_item: Vec<u32>,
    item_of_edge: Vec<u32>,
}

impl TieOrder {
    fn new(ties: Ties, edges: usize) -> Self {
        let Ties::Seeded(seed) = ties else { return Self(None) };
        let mut random = SplitMix64::new(seed);
        let mut edge_of_item: Vec<u32> = (0..as_u32(edges)).collect();
        for last in (1..edges).rev() {
            let other = (random.uniform() * (last + 1) as f64) as usize;
            edge_of_item.swap(last, other.min(last));
        }
        let mut item_of_edge = vec![0; edges];
        for (item, &edge) in edge_of_item.iter().enumerate() {
            item_of_edge[edge as usize] = as_u32(item);
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
