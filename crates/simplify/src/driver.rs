//! The greedy loop: collapse the cheapest edge, bring its neighbourhood up to date, go on.
//!
//! Every edge has at most one valid entry in the queue. Whether its cost is out of date is told by stamps at
//! the vertices, which a collapse raises at the vertex that remains and at its neighbours; an edge
//! whose stamp is old is evaluated again when it comes to the head. That is exact for costs that
//! only grow, and close for those that mostly do; [`Update::Eager`] is exact for all.

use core::ops::ControlFlow;
use std::time::Instant;

use mesh_core::{EdgeId, EdgeMap, HalfEdgeId, TriMesh, VertexId, VertexMap};

use crate::constraint::{Constraints, Fixed};
use crate::cost::{Collapse, Cost, Reach};
use crate::guard::{Guard, Refusal, Refusals};
use crate::log::{CollapseLog, LogEntry};
use crate::patch::{EdgePatch, PatchFace, Place};
use crate::placement::Placement;
use crate::queue::{Entry, Queue};
use crate::stop::{Limits, StopReason};

/// How far a run has come; given to the observer now and then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The number of faces at the start.
    pub faces_before: usize,
    /// The number of faces now.
    pub faces: usize,
    /// The number of faces at which the run ends if nothing ends it earlier.
    pub face_target: usize,
    /// The number of collapses so far.
    pub collapses: usize,
}

/// What a run of [`collapse_edges`] did.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Why it stopped.
    pub stop: StopReason,
    /// Every collapse.
    pub log: CollapseLog,
    /// How often edges were refused, by reason.
    pub refusals: Refusals,
    /// The largest cost of a collapse.
    pub max_cost: f64,
    /// The locked vertices of the mesh as it is now, if there are any.
    pub locked: Option<VertexMap<bool>>,
    /// The feature edges of the mesh as it is now, if they were given.
    pub features: Option<EdgeMap<bool>>,
}

/// The rules of a run; see [`collapse_edges`].
pub struct Policies<'a, C, P> {
    /// What a collapse costs.
    pub cost: C,
    /// Where the remaining vertex goes.
    pub placement: P,
    /// Which collapses are refused.
    pub guards: Vec<Box<dyn Guard + 'a>>,
    /// When costs are brought up to date.
    pub update: Update,
}

/// When costs that a collapse has changed are brought up to date.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Update {
    /// When the edge comes to the head of the queue. A cost that has fallen is noticed late.
    #[default]
    Lazy,
    /// At once, for all edges within [`Cost::reach`]. Takes several times as long.
    Eager,
}

/// Collapses edges of the mesh, the cheapest first, until a limit is reached.
///
/// The mesh keeps removed elements, so that the log and caller-owned maps stay valid; compact it
/// afterwards. `observe` is called every thousand collapses and may end the run.
///
/// Takes O(n log n) time as long as valences are bounded.
pub fn collapse_edges<C: Cost, P: Placement>(
    mesh: &mut TriMesh,
    policies: Policies<'_, C, P>,
    constraints: &Constraints,
    limits: &Limits,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    let mut driver = Driver::new(mesh, policies, constraints);
    driver.fill_queue();
    driver.run(limits, observe);
    (driver.result.locked, driver.result.features) = driver.fixed.into_maps();
    driver.result
}

/// How many collapses pass between two looks at the clock and the observer.
const OBSERVED_EVERY: usize = 1024;

/// What the queue knows of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// In the queue with what it cost before something changed.
    Stale,
    /// In the queue with the bound of [`Cost::early_bound`].
    Early,
    /// In the queue with the bound of [`Cost::lower_bound`].
    Bound,
    /// In the queue with its cost.
    Exact,
    /// Refused, and not in the queue until something changes round it.
    Refused,
}

impl State {
    /// What is to be found out next.
    fn next(self) -> Self {
        match self {
            Self::Stale | Self::Refused => Self::Early,
            Self::Early => Self::Bound,
            Self::Bound | Self::Exact => Self::Exact,
        }
    }
}

#[derive(Clone, Copy)]
struct EdgeRecord {
    /// The cost with which the edge is in the queue. Entries with another one are out of date;
    /// not a number when the edge was refused.
    key: f64,
    /// The sum of the stamps of the two ends when the edge was last evaluated.
    stamp: u32,
    state: State,
}

impl EdgeRecord {
    const REFUSED: Self = Self { key: f64::NAN, stamp: 0, state: State::Refused };
}

#[derive(Clone, Copy, Default)]
struct VertexRecord {
    /// Raised whenever something changes round the vertex.
    stamp: u32,
    /// The number of refused edges at the vertex, or more.
    refused: u32,
}

struct Driver<'a, 'g, C, P> {
    mesh: &'a mut TriMesh,
    policies: Policies<'g, C, P>,
    fixed: Fixed,
    queue: Queue,
    edges: Vec<EdgeRecord>,
    vertices: Vec<VertexRecord>,
    used_vertices: usize,
    scratch: Vec<PatchFace>,
    touched: Vec<VertexId>,
    stale: Vec<EdgeId>,
    result: Run,
}

/// An edge with its place and cost, as far as they are known.
struct Evaluated {
    place: Place,
    cost: f64,
    state: State,
}

impl<'a, 'g, C: Cost, P: Placement> Driver<'a, 'g, C, P> {
    fn new(
        mesh: &'a mut TriMesh,
        mut policies: Policies<'g, C, P>,
        constraints: &Constraints,
    ) -> Self {
        let fixed = Fixed::new(mesh, constraints);
        policies.cost.prepare(mesh);
        for guard in &mut policies.guards {
            guard.prepare(mesh);
        }
        let topology = mesh.topology();
        let used_vertices = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v));
        let used_vertices = used_vertices.count();
        let edges = vec![EdgeRecord::REFUSED; topology.edge_capacity()];
        let vertices = vec![VertexRecord::default(); topology.vertex_capacity()];
        let result = Run {
            stop: StopReason::NothingLeft,
            log: CollapseLog::default(),
            refusals: Refusals::default(),
            max_cost: 0.0,
            locked: None,
            features: None,
        };
        Self {
            mesh,
            policies,
            fixed,
            queue: Queue::new(Vec::new()),
            edges,
            vertices,
            used_vertices,
            scratch: Vec::new(),
            touched: Vec::new(),
            stale: Vec::new(),
            result,
        }
    }

    fn fill_queue(&mut self) {
        let mut entries = Vec::with_capacity(self.mesh.topology().edge_count());
        for index in 0..self.mesh.topology().edge_capacity() {
            let edge = EdgeId::new(index as u32);
            if !self.mesh.topology().contains_edge(edge) {
                continue;
            }
            match self.evaluate(edge, State::Early) {
                Ok(evaluated) => {
                    let Evaluated { cost, state, .. } = evaluated;
                    self.edges[index] = EdgeRecord { key: cost, stamp: 0, state };
                    entries.push(Entry { cost, edge });
                }
                Err(refusal) => self.refuse(edge, refusal),
            }
        }
        self.queue = Queue::new(entries);
    }

    fn run(&mut self, limits: &Limits, observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>) {
        let start = Instant::now();
        let faces_before = self.mesh.topology().face_count();
        let face_target = limits.face_target(faces_before);
        let mut observed = 0;
        loop {
            let collapses = self.result.log.len();
            if self.mesh.topology().face_count() <= face_target {
                return self.stop(StopReason::Faces);
            }
            if limits.vertices.is_some_and(|limit| self.used_vertices <= limit) {
                return self.stop(StopReason::Vertices);
            }
            if limits.collapses.is_some_and(|limit| collapses >= limit) {
                return self.stop(StopReason::Collapses);
            }
            if collapses >= observed + OBSERVED_EVERY {
                observed = collapses;
                if limits.time.is_some_and(|time| start.elapsed() >= time) {
                    return self.stop(StopReason::Time);
                }
                let faces = self.mesh.topology().face_count();
                let progress = Progress { faces_before, faces, face_target, collapses };
                if observe(&progress).is_break() {
                    return self.stop(StopReason::Cancelled);
                }
            }
            let Some((edge, evaluated)) = self.cheapest() else {
                return self.stop(StopReason::NothingLeft);
            };
            if limits.cost.is_some_and(|limit| evaluated.cost > limit) {
                return self.stop(StopReason::Cost);
            }
            self.queue.pop();
            if let Err(refusal) = self.collapse(edge, &evaluated) {
                self.refuse(edge, refusal);
            }
        }
    }

    fn stop(&mut self, reason: StopReason) {
        self.result.stop = reason;
    }

    /// Brings the head of the queue up to date until it is still the cheapest then. It stays at
    /// the head.
    fn cheapest(&mut self) -> Option<(EdgeId, Evaluated)> {
        loop {
            let Entry { cost: key, edge } = self.queue.head()?;
            let record = self.edges[edge.index()];
            if record.key != key || !self.mesh.topology().contains_edge(edge) {
                self.queue.pop();
                continue;
            }
            let stamp = self.stamp(edge);
            let known = if record.stamp == stamp { record.state } else { State::Stale };
            let evaluated = match self.evaluate(edge, known.next()) {
                Ok(evaluated) => evaluated,
                Err(refusal) => {
                    self.queue.pop();
                    self.refuse(edge, refusal);
                    continue;
                }
            };
            let Evaluated { cost, state, .. } = evaluated;
            let entry = Entry { cost, edge };
            self.edges[edge.index()] = EdgeRecord { key: cost, stamp, state };
            let may_sink = known != State::Exact && self.queue.head_would_sink(entry);
            if may_sink || state != State::Exact {
                self.queue.replace_head(entry);
                continue;
            }
            return Some((edge, evaluated));
        }
    }

    fn stamp(&self, edge: EdgeId) -> u32 {
        let [a, b] = self.mesh.topology().edge_vertices(edge);
        self.vertices[a.index()].stamp.wrapping_add(self.vertices[b.index()].stamp)
    }

    /// The place and the cost of an edge, or the quickest bound of the cost that is at least as
    /// good as `wanted`.
    #[inline]
    fn evaluate(&mut self, edge: EdgeId, wanted: State) -> Result<Evaluated, Refusal> {
        let Policies { cost, placement, .. } = &self.policies;
        if wanted == State::Early {
            let patch = EdgePatch::without_faces(self.mesh, edge.half_edge());
            let patch = patch.with_border(self.fixed.border(&patch));
            if let Some(bound) = cost.early_bound(&patch).filter(|bound| !bound.is_nan()) {
                return Ok(Evaluated { place: Place::Kept, cost: bound, state: State::Early });
            }
        }
        let patch = EdgePatch::gather(self.mesh, edge.half_edge(), &mut self.scratch);
        let patch = patch.with_border(self.fixed.border(&patch));
        let forced = self.fixed.place(&patch)?;
        let quadric = cost.quadric(&patch);
        let quadric = quadric.as_ref();
        let at = |x| cost.cost(&patch, quadric, x);
        let place = forced.unwrap_or_else(|| placement.place(&patch, quadric, &at));
        let x = patch.offset(place);
        let is_exact = wanted == State::Exact;
        let bound = if is_exact { None } else { cost.lower_bound(&patch, quadric, x) };
        let state = if bound.is_some() { State::Bound } else { State::Exact };
        let cost = bound.unwrap_or_else(|| at(x));
        if cost.is_nan() || !x.is_finite() {
            return Err(Refusal::NotFinite);
        }
        Ok(Evaluated { place, cost, state })
    }

    /// Collapses an edge if everything allows it.
    fn collapse(&mut self, edge: EdgeId, evaluated: &Evaluated) -> Result<(), Refusal> {
        // The vertex that stays is the one whose position does, if any.
        let (half_edge, place) = match evaluated.place {
            Place::Removed => (edge.half_edge().twin(), Place::Kept),
            place => (edge.half_edge(), place),
        };
        let patch = EdgePatch::gather(self.mesh, half_edge, &mut self.scratch);
        let offset = patch.offset(place);
        for guard in &self.policies.guards {
            guard.check(&patch, offset)?;
        }
        let legal = self.mesh.topology().check_collapse(half_edge)?;
        let (removed, kept) = (legal.removed(), legal.kept());
        let collapse = Collapse {
            removed,
            kept,
            removed_from: self.mesh.position(removed),
            kept_from: self.mesh.position(kept),
            position: patch.position(place),
        };
        if !collapse.position.is_finite() {
            return Err(Refusal::NotFinite);
        }
        self.policies.cost.collapsing(&patch, offset);
        let faces_before = self.mesh.topology().face_count() as u32;
        let collapsed = self.mesh.collapse(legal, collapse.position);
        self.fixed.collapsed(&collapse, collapsed.merged_edges);
        self.policies.cost.collapsed(self.mesh, &collapse);
        for guard in &mut self.policies.guards {
            guard.collapsed(self.mesh, &collapse);
        }
        self.record(half_edge, &collapse, evaluated.cost, faces_before);
        self.touch(&collapse);
        Ok(())
    }

    fn record(&mut self, half_edge: HalfEdgeId, collapse: &Collapse, cost: f64, faces_before: u32) {
        let Collapse { removed, kept, position, .. } = *collapse;
        let entry = LogEntry { half_edge, removed, kept, position, cost, faces_before };
        self.result.log.push(entry);
        self.result.max_cost = self.result.max_cost.max(cost);
        self.used_vertices -= 1;
    }

    fn refuse(&mut self, edge: EdgeId, refusal: Refusal) {
        self.result.refusals.count(refusal);
        self.edges[edge.index()] = EdgeRecord::REFUSED;
        for v in self.mesh.topology().edge_vertices(edge) {
            self.vertices[v.index()].refused += 1;
        }
    }

    /// Marks what a collapse has changed as out of date.
    fn touch(&mut self, collapse: &Collapse) {
        let Collapse { removed, kept, .. } = *collapse;
        // Larger than both, so that the edges of either are seen to have changed.
        let [gone, stays] = [removed, kept].map(|v| self.vertices[v.index()]);
        let stamp = gone.stamp.max(stays.stamp);
        let refused = gone.refused + stays.refused;
        self.vertices[kept.index()] = VertexRecord { stamp, refused };
        let reach = self.policies.cost.reach();
        self.collect_touched(kept, reach);
        for index in 0..self.touched.len() {
            self.raise(self.touched[index]);
        }
        if reach == Reach::Star {
            // Other costs stay, but refused edges may be possible now.
            self.touched.extend(self.mesh.topology().one_ring(kept));
        }
        for index in 0..self.touched.len() {
            self.readmit(self.touched[index]);
        }
        if self.policies.update == Update::Eager {
            self.refresh();
        }
    }

    /// The vertices whose edges may cost something else now.
    fn collect_touched(&mut self, kept: VertexId, reach: Reach) {
        let topology = self.mesh.topology();
        self.touched.clear();
        self.touched.push(kept);
        if reach >= Reach::OneRing {
            self.touched.extend(topology.one_ring(kept));
        }
        if reach >= Reach::TwoRings {
            let ring = self.touched.len();
            for index in 1..ring {
                let v = self.touched[index];
                self.touched.extend(topology.one_ring(v));
            }
            self.touched.sort_unstable();
            self.touched.dedup();
        }
    }

    fn raise(&mut self, v: VertexId) {
        let record = &mut self.vertices[v.index()];
        record.stamp = record.stamp.wrapping_add(1);
    }

    /// Gives the refused edges of a vertex another chance.
    fn readmit(&mut self, v: VertexId) {
        let record = &mut self.vertices[v.index()];
        if record.refused == 0 {
            return;
        }
        record.refused = 0;
        self.stale.clear();
        let refused = |e: &EdgeId| self.edges[e.index()].state == State::Refused;
        self.stale.extend(self.mesh.topology().edges_of_vertex(v).filter(refused));
        for index in 0..self.stale.len() {
            let edge = self.stale[index];
            let stamp = self.stamp(edge).wrapping_sub(1);
            // Out of date, so that it is evaluated when it comes to the head.
            let cost = f64::NEG_INFINITY;
            self.edges[edge.index()] = EdgeRecord { key: cost, stamp, state: State::Stale };
            self.queue.push(Entry { cost, edge });
        }
    }

    /// Evaluates all edges within reach of a collapse again. Each is put into the queue anew when
    /// it has become cheaper; the old entry is noticed to be out of date.
    fn refresh(&mut self) {
        let topology = self.mesh.topology();
        self.stale.clear();
        for &v in &self.touched {
            self.stale.extend(topology.edges_of_vertex(v));
        }
        self.stale.sort_unstable();
        self.stale.dedup();
        for index in 0..self.stale.len() {
            let edge = self.stale[index];
            if self.edges[edge.index()].state == State::Refused {
                continue;
            }
            if let Ok(Evaluated { cost, state, .. }) = self.evaluate(edge, State::Exact) {
                let stamp = self.stamp(edge);
                let record = &mut self.edges[edge.index()];
                let changed = record.key != cost;
                *record = EdgeRecord { key: cost, stamp, state };
                if changed {
                    self.queue.push(Entry { cost, edge });
                }
            }
        }
        // Most of a long queue is out of date.
        if self.queue.len() > 4 * self.mesh.topology().edge_count() + 1000 {
            let (edges, topology) = (&self.edges, self.mesh.topology());
            self.queue.retain(|entry| {
                edges[entry.edge.index()].key == entry.cost && topology.contains_edge(entry.edge)
            });
        }
    }
}
