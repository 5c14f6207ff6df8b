//! The turn of an edge: its cost, the constraints, the collapse, and the updates after it.

use glam::DVec3;
use mesh_core::{EdgeId, TriMesh, VertexId, as_u32, parallel};

use crate::cost::{Cost, Reach};
use crate::engine::evaluate::{Assessment, assess, cost_at, early_bound};
use crate::engine::patch_detail::Detail;
use crate::engine::schedule::EdgeQueue;
use crate::engine::schedule::queue::Entry;
use crate::engine::schedule::rounds::Visit;
use crate::engine::start::Start;
use crate::engine::target_check::TargetCheck;
use crate::engine::valence::ValenceTable;
use crate::engine::vertex_freedom::VertexFreedom;
use crate::geometry::edge_patch::{Collapse, EdgePatch, PatchFace, Place};
use crate::placement::Placement;
use crate::policies::Policies;
use crate::policy::{Policy, Scratch};
use crate::protect::Protect;
use crate::record::log::LogEntry;
use crate::record::run::Run;
use crate::record::target::StopReason;
use crate::rejection::Rejection;

/// A mesh under collapse, and all data that follows it.
pub(super) struct Stepper<'a, C, P> {
    mesh: &'a mut TriMesh,
    policies: Policies<C, P>,
    fixed: VertexFreedom,
    /// For each vertex, whether edges at it may collapse; `None` for all.
    is_free: Option<Vec<bool>>,
    first: Option<Vec<EdgeId>>,
    /// Whether each edge was rejected and waits for a change around it.
    is_refused: Vec<bool>,
    /// An upper bound of the number of rejected edges at each vertex.
    refused_at: Vec<u32>,
    /// Vertices whose rejected edges are tried again later.
    later: Vec<VertexId>,
    valences: ValenceTable,
    used_vertices: usize,
    detail: Detail,
    memory: Memory,
    /// Results of evaluations ahead of the turns.
    ahead: Vec<Memory>,
    /// The remaining vertex of the last collapse, and its neighbours.
    touched: Vec<VertexId>,
    result: Run,
}

/// Buffers for the evaluation of an edge.
#[derive(Default)]
struct Memory {
    /// The faces of the patch.
    faces: Vec<PatchFace>,
    scratch: Scratch,
}

/// The data that keys and choices depend on. It is shared by parallel evaluations.
struct Evaluator<'m, 's, C, P> {
    mesh: &'m TriMesh,
    policies: &'s Policies<C, P>,
    fixed: &'s VertexFreedom,
    valences: &'s ValenceTable,
    detail: &'s Detail,
}

/// The decision about an edge.
#[expect(clippy::large_enum_variant, reason = "there is one at a time")]
enum Choice<'p> {
    /// The cost is above the threshold, and at least this.
    Above(f64),
    Collapse {
        /// The patch whose first vertex is removed.
        patch: EdgePatch<'p>,
        place: Place,
        offset: DVec3,
        cost: f64,
    },
}

impl<'m, C: Cost, P: Placement> Evaluator<'m, '_, C, P> {
    /// The cost of an edge, or its cheapest lower bound.
    fn key(&self, edge: EdgeId, memory: &mut Memory) -> Result<f64, Rejection> {
        let Self { mesh, policies, fixed, valences, detail } = *self;
        if valences.has_to_wait(mesh.topology(), edge) {
            return Err(Rejection::Valence);
        }
        if let Some(bound) = early_bound(mesh, policies, fixed, edge) {
            return Ok(bound);
        }
        let Memory { faces, scratch } = memory;
        let mut patch = detail.patch(mesh, fixed, edge, faces);
        match assess(policies, fixed, &mut patch, f64::NEG_INFINITY, scratch)? {
            Assessment::Above(cost) | Assessment::Exact(_, cost) => Ok(cost),
        }
    }

    /// The collapse of an edge that costs at most `threshold`, if policies and constraints allow it.
    fn choose<'p>(
        &self,
        edge: EdgeId,
        threshold: f64,
        faces: &'p mut Vec<PatchFace>,
        scratch: &mut Scratch,
    ) -> Result<Choice<'p>, Rejection>
    where
        'm: 'p,
    {
        let Self { mesh, policies, fixed, valences, detail } = *self;
        if valences.has_to_wait(mesh.topology(), edge) {
            return Err(Rejection::Valence);
        }
        let mut patch = detail.patch(mesh, fixed, edge, faces);
        let (place, cost) = match assess(policies, fixed, &mut patch, threshold, scratch)? {
            Assessment::Above(cost) => return Ok(Choice::Above(cost)),
            Assessment::Exact(_, cost) if cost > threshold => return Ok(Choice::Above(cost)),
            Assessment::Exact(place, cost) => (place, cost),
        };
        let patch = patch.with_faces();
        let is_forced = fixed.place(&patch)?.is_some();
        let (mut next, mut refused) = (place, 0);
        let (patch, place, offset) = loop {
            // If the position of one vertex is kept, that vertex stays.
            let (patch, place) = match next {
                Place::Removed => (patch.reversed(), Place::Kept),
                place => (patch, place),
            };
            let offset = patch.offset(place);
            match check(policies, fixed, &patch, offset, scratch) {
                Ok(()) => break (patch, place, offset),
                Err(rejection) if is_forced => return Err(rejection),
                Err(rejection) => next = policies.placement.instead(refused).ok_or(rejection)?,
            }
            refused += 1;
        };
        // Alternatives to the best position may cost more.
        let cost = match refused {
            0 => cost,
            _ => cost_at(policies, fixed, &patch, offset, scratch),
        };
        Ok(Choice::Collapse { patch, place, offset, cost })
    }
}

/// The outcome of the turn of an edge.
pub(super) enum Turn {
    Collapsed,
    /// The cost is above the threshold, and at least this.
    Above(f64),
    Refused,
}

impl<'a, C: Cost, P: Placement> Stepper<'a, C, P> {
    pub(super) fn new(
        mesh: &'a mut TriMesh,
        mut policies: Policies<C, P>,
        start: Start,
        protect: &Protect,
    ) -> Self {
        let Start { followers, borders, is_free, first } = start;
        let fixed = VertexFreedom::new(mesh, protect, followers, borders);
        policies.cost.prepare(mesh);
        policies.placement.prepare(mesh);
        policies.modifiers.iter_mut().for_each(|modifier| modifier.prepare(mesh));
        policies.constraints = protect.constraints().and(policies.constraints);
        policies.constraints.prepare(mesh);
        let topology = mesh.topology();
        let used_vertices = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v));
        let used_vertices = used_vertices.count();
        let is_refused = vec![false; topology.edge_capacity()];
        let refused_at = vec![0; topology.vertex_capacity()];
        let valences = ValenceTable::new(topology);
        let detail = Detail::new(mesh, &policies);
        Self {
            mesh,
            policies,
            fixed,
            is_free,
            first,
            detail,
            is_refused,
            refused_at,
            later: Vec::new(),
            valences,
            used_vertices,
            memory: Memory::default(),
            ahead: Vec::new(),
            touched: Vec::new(),
            result: Run::new(),
        }
    }

    pub(super) fn mesh(&self) -> &TriMesh {
        self.mesh
    }

    /// The report of the run, after its end.
    pub(super) fn finish(self, stop: StopReason) -> Run {
        Run { stop, protected: self.fixed.into_marks(), ..self.result }
    }

    pub(super) fn reached(&self, watch: &mut TargetCheck<'_>) -> Option<StopReason> {
        watch.reached(self.mesh.topology().face_count(), self.used_vertices, self.result.log.len())
    }

    /// Reserves memory for the records of this many collapses.
    pub(super) fn expect_collapses(&mut self, collapses: usize) {
        self.result.log.reserve(collapses);
    }

    /// The number of collapses so far.
    pub(super) fn collapses(&self) -> usize {
        self.result.log.len()
    }

    /// Whether the mesh is a part of a larger one.
    pub(super) fn is_part(&self) -> bool {
        self.is_free.is_some()
    }

    /// Whether an edge may collapse with regard to the rest of a larger mesh.
    fn is_free(&self, edge: EdgeId) -> bool {
        self.is_free.as_ref().is_none_or(|is_free| {
            self.mesh.topology().edge_vertices(edge).iter().all(|v| is_free[v.index()])
        })
    }

    /// The edges that may collapse and are not rejected, with their costs or their cheapest lower bounds. Until
    /// [`Stepper::others`] is called, these are only the edges to try first.
    pub(super) fn entries(&mut self) -> Vec<Entry> {
        let topology = self.mesh.topology();
        let waits = |&edge: &EdgeId| !self.is_refused[edge.index()] && self.is_free(edge);
        let edges: Vec<EdgeId> = match &self.first {
            Some(first) => {
                let there = first.iter().copied().filter(|&edge| topology.contains_edge(edge));
                there.filter(waits).collect()
            }
            None => topology.edges().filter(waits).collect(),
        };
        let evaluator = self.evaluator();
        let keys = parallel::collect_with(edges.len(), Memory::default, |memory, i| {
            evaluator.key(edges[i], memory)
        });
        let mut entries = Vec::with_capacity(edges.len());
        for (edge, key) in edges.into_iter().zip(keys) {
            match key {
                Ok(cost) => entries.push(Entry { cost, edge }),
                Err(rejection) => self.refuse(edge, rejection, self.result.log.len()),
            }
        }
        entries
    }

    /// All entries, if only the first ones were used until now.
    pub(super) fn others(&mut self) -> Option<Vec<Entry>> {
        self.first.take()?;
        Some(self.entries())
    }

    /// A lower bound of the cost of an edge from its ends alone; minus infinity if there is none or the edge is gone.
    pub(super) fn early_bound(&self, edge: EdgeId) -> f64 {
        let Self { mesh, policies, fixed, .. } = self;
        let is_there = mesh.topology().contains_edge(edge);
        let bound = is_there.then(|| early_bound(mesh, policies, fixed, edge));
        bound.flatten().unwrap_or(f64::NEG_INFINITY)
    }

    /// The cost of an edge, or its cheapest lower bound; `None` if the edge is rejected.
    pub(super) fn key(&mut self, edge: EdgeId) -> Option<f64> {
        let mut memory = core::mem::take(&mut self.memory);
        let key = self.evaluator().key(edge, &mut memory);
        self.memory = memory;
        match key {
            Ok(cost) => Some(cost),
            Err(rejection) => {
                self.refuse(edge, rejection, self.result.log.len());
                None
            }
        }
    }

    fn evaluator(&self) -> Evaluator<'_, '_, C, P> {
        let Self { mesh, policies, fixed, valences, detail, .. } = self;
        Evaluator { mesh, policies, fixed, valences, detail }
    }

    /// Whether to evaluate edges ahead of their turns, on all threads.
    pub(super) fn looks_ahead(&self) -> bool {
        self.policies.placement.is_asked_ahead() && parallel::threads() > 1
    }

    /// Evaluates edges ahead of their turns, in parallel. The turns have the same outcome as without this; they reuse
    /// results that no collapse has invalidated in between.
    pub(super) fn look_ahead(&mut self, visits: &[Visit], threshold: f64) {
        let mut ahead = core::mem::take(&mut self.ahead);
        ahead.resize_with(visits.len().max(ahead.len()), Memory::default);
        let evaluator = self.evaluator();
        parallel::update_each(&mut ahead[..visits.len()], |i, Memory { faces, scratch }| {
            if self.mesh.topology().contains_edge(visits[i].edge) {
                // The turn evaluates the edge again; intermediate results stay in the memory.
                let _ = evaluator.choose(visits[i].edge, threshold, faces, scratch);
            }
        });
        self.ahead = ahead;
    }

    /// Takes the memory of an evaluation ahead, for the turn of its edge.
    pub(super) fn recall(&mut self, visit: usize) {
        if let Some(memory) = self.ahead.get_mut(visit) {
            core::mem::swap(&mut self.memory, memory);
        }
    }

    /// Collapses an edge that costs at most `threshold`, if policies and constraints allow it, and puts the affected
    /// edges back into the schedule.
    pub(super) fn take_turn(
        &mut self,
        edge: EdgeId,
        threshold: f64,
        schedule: &mut dyn EdgeQueue,
    ) -> Turn {
        match self.try_collapse(edge, threshold) {
            Ok(Turn::Collapsed) => {
                self.readmit(schedule);
                Turn::Collapsed
            }
            Ok(turn) => turn,
            Err(rejection) => {
                self.refuse(edge, rejection, self.result.log.len() + 1);
                schedule.refused(edge);
                Turn::Refused
            }
        }
    }

    fn try_collapse(&mut self, edge: EdgeId, threshold: f64) -> Result<Turn, Rejection> {
        let Self { mesh, policies, fixed, memory, valences, detail, .. } = self;
        let Memory { faces, scratch } = memory;
        let evaluator = Evaluator { mesh, policies, fixed, valences, detail };
        let (patch, place, offset, cost) =
            match evaluator.choose(edge, threshold, faces, scratch)? {
                Choice::Above(cost) => return Ok(Turn::Above(cost)),
                Choice::Collapse { patch, place, offset, cost } => (patch, place, offset, cost),
            };
        let half_edge = patch.half_edge();
        let legal = mesh.topology().check_collapse(half_edge)?;
        let (removed, kept) = (legal.removed(), legal.kept());
        let collapse = Collapse::new(mesh, &legal, patch.position(place));
        if !collapse.position.is_finite() {
            return Err(Rejection::NotFinite);
        }
        if let Some(sums) = detail.sums() {
            sums.collapsing(&patch, offset);
        }
        policies.cost.collapsing(&patch, offset, scratch);
        policies.placement.collapsing(&patch, offset, scratch);
        for modifier in &mut policies.modifiers {
            modifier.collapsing(&patch, offset, scratch);
        }
        let faces_before = as_u32(mesh.topology().face_count());
        let apexes = [half_edge, half_edge.twin()].map(|side| mesh.topology().apex(side));
        valences.collapsed([removed, kept], apexes);
        let collapsed = mesh.collapse(legal, collapse.position);
        fixed.collapsed(mesh, &collapse, collapsed.merged_edges);
        if let Some(sums) = detail.sums() {
            sums.collapsed(mesh, kept);
        }
        policies.cost.collapsed(mesh, &collapse);
        policies.placement.collapsed(mesh, &collapse);
        policies.modifiers.iter_mut().for_each(|modifier| modifier.collapsed(mesh, &collapse));
        policies.constraints.collapsed(mesh, &collapse);
        let Collapse { position, .. } = collapse;
        self.result.push(LogEntry { half_edge, removed, kept, position, cost, faces_before });
        self.used_vertices -= 1;
        self.touch(&collapse);
        Ok(Turn::Collapsed)
    }

    /// Rejects an edge. `collapses` is the number of collapses that a run must be allowed to reach this rejection.
    fn refuse(&mut self, edge: EdgeId, rejection: Rejection, collapses: usize) {
        self.result.refuse(rejection, collapses);
        self.is_refused[edge.index()] = true;
        for v in self.mesh.topology().edge_vertices(edge) {
            self.refused_at[v.index()] += 1;
        }
    }

    /// Lists the vertices around a collapse.
    fn touch(&mut self, collapse: &Collapse) {
        let Collapse { removed, kept, .. } = *collapse;
        self.refused_at[kept.index()] += self.refused_at[removed.index()];
        self.touched.clear();
        self.touched.push(kept);
        self.touched.extend(self.mesh.topology().one_ring(kept));
    }

    /// Puts the rejected edges around the last collapse back into the schedule.
    fn readmit(&mut self, schedule: &mut dyn EdgeQueue) {
        let touched = core::mem::take(&mut self.touched);
        for &v in &touched {
            // The edges of a crowded vertex would be rejected again.
            if self.valences.is_crowded(v) || self.refused_at[v.index()] == 0 {
                continue;
            }
            if self.valences.is_later(v) {
                if self.later.last() != Some(&v) {
                    self.later.push(v);
                }
                continue;
            }
            self.readmit_at(v, schedule);
        }
        self.touched = touched;
    }

    /// Puts the rejected edges of a vertex back into the schedule, and returns whether there are any.
    fn readmit_at(&mut self, v: VertexId, schedule: &mut dyn EdgeQueue) -> bool {
        let topology = self.mesh.topology();
        self.refused_at[v.index()] = 0;
        let mut any = false;
        for edge in topology.edges_of_vertex(v) {
            if core::mem::take(&mut self.is_refused[edge.index()]) {
                schedule.push_unknown(topology, edge);
                any = true;
            }
        }
        any
    }

    /// Puts the rejected edges that were left for later back into the schedule, and returns whether there are any.
    pub(super) fn readmit_later(&mut self, schedule: &mut dyn EdgeQueue) -> bool {
        let mut any = false;
        for v in core::mem::take(&mut self.later) {
            let is_there = self.mesh.topology().contains_vertex(v);
            if is_there && self.refused_at[v.index()] > 0 && !self.valences.is_crowded(v) {
                any |= self.readmit_at(v, schedule);
            }
        }
        any
    }

    /// Lists the edges, by index, whose cost the last collapse may have changed, without rejected edges.
    pub(super) fn list_stale(&mut self, stale: &mut Vec<EdgeId>) {
        self.widen_touched();
        let topology = self.mesh.topology();
        stale.clear();
        // Edges at vertices of too high valence wait for more than a change of their cost.
        for &v in self.touched.iter().filter(|&&v| !self.valences.is_crowded(v)) {
            stale.extend(topology.edges_of_vertex(v));
        }
        stale.sort_unstable();
        stale.dedup();
        stale.retain(|edge| !self.is_refused[edge.index()]);
    }

    /// Extends the list of touched vertices to the reach of the cost.
    fn widen_touched(&mut self) {
        let modifiers = self.policies.modifiers.iter().map(|modifier| modifier.reach());
        match modifiers.fold(self.policies.cost.reach(), Reach::max) {
            Reach::OneRingSum => self.touched.truncate(1),
            Reach::OneRing => {}
            Reach::TwoRings => {
                for index in 1..self.touched.len() {
                    let v = self.touched[index];
                    if self.valences.is_crowded(v) {
                        continue;
                    }
                    self.touched.extend(self.mesh.topology().one_ring(v));
                }
                self.touched.sort_unstable();
                self.touched.dedup();
            }
        }
    }
}

/// Whether constraints, cost modifiers and the placement allow a collapse.
fn check<C: Cost, P: Placement>(
    policies: &Policies<C, P>,
    fixed: &VertexFreedom,
    patch: &EdgePatch<'_>,
    offset: DVec3,
    scratch: &mut Scratch,
) -> Result<(), Rejection> {
    policies.constraints.check(patch, offset, scratch)?;
    fixed.constraints().check(patch, offset, scratch)?;
    for modifier in &policies.modifiers {
        modifier.check(patch, offset)?;
    }
    policies.placement.check(patch, offset, scratch)
}
