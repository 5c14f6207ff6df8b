//! The greedy loop: collapse the cheapest edges, bring their neighbourhood up to date, go on.
//!
//! What an edge costs is found out in steps: a bound from its ends alone, a bound from the faces
//! round it, the cost. As soon as it is known to be above a ceiling, the edge goes back to where it
//! waits, with what is known as its key. How edges wait is what [`Update`] chooses:
//!
//! - [`Update::Lazy`] takes the cheapest few percent of them at a time, by keys that may be out of
//!   date, and visits them in the order in which they are stored ([`Rounds`]). Neighbours are then
//!   in the cache, and no edge is evaluated that is not about to be collapsed.
//! - [`Update::Eager`] keeps all keys up to date in a heap ([`Queue`]), and is exact.

use core::ops::ControlFlow;
use std::time::Instant;

use mesh_core::{EdgeId, EdgeMap, HalfEdgeId, Topology, TriMesh, VertexId, VertexMap};

use crate::collapse::constraint::{Constraints, Fixed};
use crate::collapse::cost::{Collapse, Cost, Reach};
use crate::collapse::guard::{Guard, Refusal, Refusals};
use crate::collapse::log::{CollapseLog, LogEntry};
use crate::collapse::patch::{EdgePatch, PatchFace, Place};
use crate::collapse::placement::Placement;
use crate::collapse::schedule::queue::{Entry, Queue};
use crate::collapse::schedule::rounds::{Round, Rounds, Visit};
use crate::collapse::stop::{Limits, StopReason};

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

/// In which order edges are collapsed, and when costs that a collapse has changed are brought up to
/// date.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Update {
    /// In rounds of the cheapest few percent of the edges. Within a round, neighbours follow each
    /// other, whatever they cost, and each edge is evaluated when its turn comes: if it has become
    /// more expensive than the round, it waits. A cost that has fallen is noticed late.
    #[default]
    Lazy,
    /// Strictly the cheapest first. All edges within [`Cost::reach`] of a collapse are evaluated at
    /// once. Takes several times as long.
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
    driver.fill();
    driver.run(limits, observe);
    (driver.result.locked, driver.result.features) = driver.fixed.into_maps();
    driver.result
}

/// How many collapses pass between two looks at the clock and the observer.
const OBSERVED_EVERY: usize = 1024;

/// How many edges are looked at before they have their turn.
const LOOK_AHEAD: usize = 32;

struct Driver<'a, 'g, C, P> {
    mesh: &'a mut TriMesh,
    policies: Policies<'g, C, P>,
    fixed: Fixed,
    waiting: Waiting,
    /// The edges that were refused, and wait for nothing but a change round them.
    is_refused: Vec<bool>,
    /// The number of refused edges at each vertex, or more.
    refused_at: Vec<u32>,
    used_vertices: usize,
    /// Whether costs depend on the faces of a patch.
    gathers: bool,
    scratch: Vec<PatchFace>,
    touched: Vec<VertexId>,
    stale: Vec<EdgeId>,
    result: Run,
}

/// Where edges wait for their collapse.
enum Waiting {
    Rounds(Rounds),
    Heap {
        queue: Queue,
        /// The key with which each edge waits. Entries with another one are out of date.
        keys: Vec<f64>,
    },
}

impl Waiting {
    /// Adds an edge of which nothing is known.
    fn push_unknown(&mut self, topology: &Topology, edge: EdgeId) {
        match self {
            Self::Rounds(rounds) => rounds.push_unknown(topology, edge),
            Self::Heap { .. } => self.push_key(edge, f64::NEG_INFINITY),
        }
    }

    /// Gives an edge of the heap this key.
    fn push_key(&mut self, edge: EdgeId, cost: f64) {
        if let Self::Heap { queue, keys } = self {
            // What is in the heap with this key already stays there.
            if keys[edge.index()] != cost {
                keys[edge.index()] = cost;
                queue.push(Entry { cost, edge });
            }
        }
    }
}

/// What is known of the cost of an edge.
enum Assessment {
    /// It is more than the ceiling, and no less than this.
    Above(f64),
    /// It is exactly this when the vertex that remains goes to this place.
    Exact(Place, f64),
}

/// What has become of an edge whose turn it was.
enum Turn {
    Collapsed,
    /// It costs more than the ceiling, and no less than this.
    Above(f64),
    Refused,
}

/// The limits of a run and what is needed to tell whether they are reached.
struct Watch<'a> {
    limits: &'a Limits,
    observe: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
    start: Instant,
    faces_before: usize,
    face_target: usize,
    observed: usize,
}

impl Watch<'_> {
    fn reached(&mut self, faces: usize, vertices: usize, collapses: usize) -> Option<StopReason> {
        let Limits { vertices: fewest, collapses: most, time, .. } = *self.limits;
        if faces <= self.face_target {
            return Some(StopReason::Faces);
        }
        if fewest.is_some_and(|limit| vertices <= limit) {
            return Some(StopReason::Vertices);
        }
        if most.is_some_and(|limit| collapses >= limit) {
            return Some(StopReason::Collapses);
        }
        if collapses < self.observed + OBSERVED_EVERY {
            return None;
        }
        self.observed = collapses;
        if time.is_some_and(|time| self.start.elapsed() >= time) {
            return Some(StopReason::Time);
        }
        let Self { faces_before, face_target, .. } = *self;
        let progress = Progress { faces_before, faces, face_target, collapses };
        (self.observe)(&progress).is_break().then_some(StopReason::Cancelled)
    }

    /// The largest cost that is allowed.
    fn cost(&self) -> f64 {
        self.limits.cost.unwrap_or(f64::INFINITY)
    }
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
        let is_refused = vec![false; topology.edge_capacity()];
        let refused_at = vec![0; topology.vertex_capacity()];
        let result = Run {
            stop: StopReason::NothingLeft,
            log: CollapseLog::default(),
            refusals: Refusals::default(),
            max_cost: 0.0,
            locked: None,
            features: None,
        };
        let gathers = policies.cost.needs_faces() || policies.placement.needs_faces();
        Self {
            mesh,
            policies,
            fixed,
            gathers,
            waiting: Waiting::Rounds(Rounds::default()),
            is_refused,
            refused_at,
            used_vertices,
            scratch: Vec::new(),
            touched: Vec::new(),
            stale: Vec::new(),
            result,
        }
    }

    fn fill(&mut self) {
        let mut entries = Vec::with_capacity(self.mesh.topology().edge_count());
        for index in 0..self.mesh.topology().edge_capacity() {
            let edge = EdgeId::new(index as u32);
            if !self.mesh.topology().contains_edge(edge) {
                continue;
            }
            match self.key(edge) {
                Ok(cost) => entries.push(Entry { cost, edge }),
                Err(refusal) => self.refuse(edge, refusal),
            }
        }
        let topology = self.mesh.topology();
        self.waiting = match self.policies.update {
            Update::Lazy => Waiting::Rounds(Rounds::new(topology, &entries)),
            Update::Eager => {
                let mut keys = vec![f64::NAN; topology.edge_capacity()];
                entries.iter().for_each(|entry| keys[entry.edge.index()] = entry.cost);
                Waiting::Heap { queue: Queue::new(entries), keys }
            }
        };
    }

    fn run(&mut self, limits: &Limits, observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>) {
        let faces_before = self.mesh.topology().face_count();
        let mut watch = Watch {
            limits,
            observe,
            start: Instant::now(),
            faces_before,
            face_target: limits.face_target(faces_before),
            observed: 0,
        };
        self.result.stop = match self.policies.update {
            Update::Lazy => self.run_in_rounds(&mut watch),
            Update::Eager => self.run_in_order(&mut watch),
        };
    }

    fn reached(&self, watch: &mut Watch<'_>) -> Option<StopReason> {
        watch.reached(self.mesh.topology().face_count(), self.used_vertices, self.result.log.len())
    }

    fn run_in_rounds(&mut self, watch: &mut Watch<'_>) -> StopReason {
        let mut round = Round::default();
        let mut bounds = Vec::with_capacity(LOOK_AHEAD);
        loop {
            if let Some(reason) = self.reached(watch) {
                return reason;
            }
            let Waiting::Rounds(rounds) = &mut self.waiting else { return StopReason::NothingLeft };
            if !rounds.take(&mut round) {
                return StopReason::NothingLeft;
            }
            if round.least > watch.cost() {
                return StopReason::Cost;
            }
            let ceiling = round.ceiling.min(watch.cost());
            for ahead in round.visits.chunks(LOOK_AHEAD) {
                self.look_ahead(ahead, &mut bounds);
                for (&visit, &bound) in ahead.iter().zip(&bounds) {
                    if !self.mesh.topology().contains_edge(visit.edge) {
                        continue;
                    }
                    if let Some(reason) = self.reached(watch) {
                        return reason;
                    }
                    let turn = if bound > ceiling {
                        Turn::Above(bound)
                    } else {
                        self.take_turn(visit.edge, ceiling)
                    };
                    if let Turn::Above(cost) = turn
                        && let Waiting::Rounds(rounds) = &mut self.waiting
                    {
                        rounds.push_above(Visit { cost, ..visit });
                    }
                }
            }
        }
    }

    /// Finds the early bounds of edges whose turn comes soon; minus infinity where there is none.
    ///
    /// That brings their surroundings into the cache, many at a time: the edges do not wait for each
    /// other, as collapses do.
    fn look_ahead(&self, visits: &[Visit], bounds: &mut Vec<f64>) {
        let Self { mesh, policies, fixed, .. } = self;
        bounds.clear();
        bounds.extend(visits.iter().map(|visit| {
            let is_there = mesh.topology().contains_edge(visit.edge);
            let bound = is_there.then(|| early_bound(mesh, policies, fixed, visit.edge));
            bound.flatten().unwrap_or(f64::NEG_INFINITY)
        }));
    }

    fn run_in_order(&mut self, watch: &mut Watch<'_>) -> StopReason {
        loop {
            if let Some(reason) = self.reached(watch) {
                return reason;
            }
            let Waiting::Heap { queue, keys } = &mut self.waiting else {
                return StopReason::NothingLeft;
            };
            let Some(Entry { cost: key, edge }) = queue.pop() else {
                return StopReason::NothingLeft;
            };
            if keys[edge.index()] != key || !self.mesh.topology().contains_edge(edge) {
                continue;
            }
            if key > watch.cost() {
                return StopReason::Cost;
            }
            keys[edge.index()] = f64::NAN;
            let second = queue.head().map_or(f64::INFINITY, |entry| entry.cost);
            match self.take_turn(edge, second.min(watch.cost())) {
                Turn::Collapsed => self.refresh(),
                Turn::Above(cost) => self.waiting.push_key(edge, cost),
                Turn::Refused => {}
            }
        }
    }

    /// Collapses an edge that costs no more than `ceiling`, if everything allows it.
    fn take_turn(&mut self, edge: EdgeId, ceiling: f64) -> Turn {
        self.try_collapse(edge, ceiling).unwrap_or_else(|refusal| {
            self.refuse(edge, refusal);
            Turn::Refused
        })
    }

    /// The cost of an edge, or the quickest bound of it.
    fn key(&mut self, edge: EdgeId) -> Result<f64, Refusal> {
        let Self { mesh, policies, fixed, scratch, gathers, .. } = self;
        if let Some(bound) = early_bound(mesh, policies, fixed, edge) {
            return Ok(bound);
        }
        let patch = if *gathers {
            EdgePatch::gather(mesh, edge.half_edge(), scratch)
        } else {
            EdgePatch::without_faces(mesh, edge.half_edge())
        };
        let patch = patch.with_border(fixed.border(&patch));
        match assess(policies, fixed, &patch, f64::NEG_INFINITY)? {
            Assessment::Above(cost) | Assessment::Exact(_, cost) => Ok(cost),
        }
    }

    fn try_collapse(&mut self, edge: EdgeId, ceiling: f64) -> Result<Turn, Refusal> {
        let Self { mesh, policies, fixed, scratch, .. } = self;
        let patch = EdgePatch::gather(mesh, edge.half_edge(), scratch);
        let patch = patch.with_border(fixed.border(&patch));
        let (place, cost) = match assess(policies, fixed, &patch, ceiling)? {
            Assessment::Above(cost) => return Ok(Turn::Above(cost)),
            Assessment::Exact(_, cost) if cost > ceiling => return Ok(Turn::Above(cost)),
            Assessment::Exact(place, cost) => (place, cost),
        };
        // The vertex that stays is the one whose position does, if any.
        let (patch, place) = match place {
            Place::Removed => (patch.reversed(), Place::Kept),
            place => (patch, place),
        };
        let offset = patch.offset(place);
        for guard in &policies.guards {
            guard.check(&patch, offset)?;
        }
        let half_edge = patch.half_edge();
        let legal = mesh.topology().check_collapse(half_edge)?;
        let (removed, kept) = (legal.removed(), legal.kept());
        let collapse = Collapse {
            removed,
            kept,
            removed_from: mesh.position(removed),
            kept_from: mesh.position(kept),
            position: patch.position(place),
        };
        if !collapse.position.is_finite() {
            return Err(Refusal::NotFinite);
        }
        policies.cost.collapsing(&patch, offset);
        let faces_before = mesh.topology().face_count() as u32;
        let collapsed = mesh.collapse(legal, collapse.position);
        fixed.collapsed(&collapse, collapsed.merged_edges);
        policies.cost.collapsed(mesh, &collapse);
        for guard in &mut policies.guards {
            guard.collapsed(mesh, &collapse);
        }
        self.record(half_edge, &collapse, cost, faces_before);
        self.touch(&collapse);
        Ok(Turn::Collapsed)
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
        self.is_refused[edge.index()] = true;
        if let Waiting::Heap { keys, .. } = &mut self.waiting {
            keys[edge.index()] = f64::NAN;
        }
        for v in self.mesh.topology().edge_vertices(edge) {
            self.refused_at[v.index()] += 1;
        }
    }

    /// Lists the vertices round a collapse and gives their refused edges another chance.
    fn touch(&mut self, collapse: &Collapse) {
        let Collapse { removed, kept, .. } = *collapse;
        self.refused_at[kept.index()] += self.refused_at[removed.index()];
        self.touched.clear();
        self.touched.push(kept);
        self.touched.extend(self.mesh.topology().one_ring(kept));
        for index in 0..self.touched.len() {
            self.readmit(self.touched[index]);
        }
    }

    /// Gives the refused edges of a vertex another chance.
    fn readmit(&mut self, v: VertexId) {
        if core::mem::take(&mut self.refused_at[v.index()]) == 0 {
            return;
        }
        for edge in self.mesh.topology().edges_of_vertex(v) {
            if core::mem::take(&mut self.is_refused[edge.index()]) {
                self.waiting.push_unknown(self.mesh.topology(), edge);
            }
        }
    }

    /// Evaluates all edges within reach of the last collapse again. Those whose key has changed are
    /// put into the heap anew; the old entry is noticed to be out of date.
    fn refresh(&mut self) {
        self.widen_touched();
        let topology = self.mesh.topology();
        self.stale.clear();
        for &v in &self.touched {
            self.stale.extend(topology.edges_of_vertex(v));
        }
        self.stale.sort_unstable();
        self.stale.dedup();
        for index in 0..self.stale.len() {
            let edge = self.stale[index];
            if self.is_refused[edge.index()] {
                continue;
            }
            match self.key(edge) {
                Ok(cost) => self.waiting.push_key(edge, cost),
                Err(refusal) => self.refuse(edge, refusal),
            }
        }
        let Waiting::Heap { queue, keys } = &mut self.waiting else { return };
        let topology = self.mesh.topology();
        // Most of a long queue is out of date.
        if queue.len() > 4 * topology.edge_count() + 1000 {
            queue.retain(|&Entry { cost, edge }| {
                keys[edge.index()] == cost && topology.contains_edge(edge)
            });
        }
    }

    /// Brings the list of touched vertices, which are the remaining one and its neighbours, to the
    /// reach of the cost.
    fn widen_touched(&mut self) {
        match self.policies.cost.reach() {
            Reach::Star => self.touched.truncate(1),
            Reach::OneRing => {}
            Reach::TwoRings => {
                for index in 1..self.touched.len() {
                    let v = self.touched[index];
                    self.touched.extend(self.mesh.topology().one_ring(v));
                }
                self.touched.sort_unstable();
                self.touched.dedup();
            }
        }
    }
}

/// A bound of the cost of an edge from its ends alone, if there is one.
#[inline]
fn early_bound<C: Cost, P>(
    mesh: &TriMesh,
    policies: &Policies<'_, C, P>,
    fixed: &Fixed,
    edge: EdgeId,
) -> Option<f64> {
    let patch = EdgePatch::without_faces(mesh, edge.half_edge());
    let patch = patch.with_border(fixed.border(&patch));
    policies.cost.early_bound(&patch).filter(|bound| !bound.is_nan())
}

/// The place and the cost of an edge, or a bound of the cost when that is above the ceiling.
#[inline]
fn assess<C: Cost, P: Placement>(
    Policies { cost, placement, .. }: &Policies<'_, C, P>,
    fixed: &Fixed,
    patch: &EdgePatch<'_>,
    ceiling: f64,
) -> Result<Assessment, Refusal> {
    let forced = fixed.place(patch)?;
    let quadric = cost.quadric(patch);
    let quadric = quadric.as_ref();
    let at = |x| cost.cost(patch, quadric, x);
    let place = forced.unwrap_or_else(|| placement.place(patch, quadric, &at));
    let x = patch.offset(place);
    if !x.is_finite() {
        return Err(Refusal::NotFinite);
    }
    match cost.lower_bound(patch, quadric, x) {
        Some(bound) if bound > ceiling => return Ok(Assessment::Above(bound)),
        _ => {}
    }
    let cost = at(x);
    if cost.is_nan() { Err(Refusal::NotFinite) } else { Ok(Assessment::Exact(place, cost)) }
}
