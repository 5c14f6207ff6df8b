//! One edge's turn: its cost, the constraints, the collapse, and who is told of it.

use glam::DVec3;
use mesh_core::{EdgeId, TriMesh, VertexId, parallel};

use crate::cost::{Cost, Reach};
use crate::engine::detail::Detail;
use crate::engine::evaluate::{Assessment, assess, cost_at, early_bound};
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

/// A mesh under collapse and everything that follows it.
pub(super) struct Stepper<'a, C, P> {
    mesh: &'a mut TriMesh,
    policies: Policies<C, P>,
    fixed: VertexFreedom,
    /// By vertex: whether edges at it may collapse; all may when there is none.
    is_free: Option<Vec<bool>>,
    first: Option<Vec<EdgeId>>,
    /// The edges that were rejected, and wait for nothing but a change around them.
    is_refused: Vec<bool>,
    /// The number of rejected edges at each vertex, or more.
    refused_at: Vec<u32>,
    valences: ValenceTable,
    used_vertices: usize,
    detail: Detail,
    memory: Memory,
    /// What looks at edges whose turn comes soon have left.
    ahead: Vec<Memory>,
    /// The vertex that remains of the last collapse, and its neighbours.
    touched: Vec<VertexId>,
    result: Run,
}

/// What a look at an edge writes to.
#[derive(Default)]
struct Memory {
    /// The faces of the patch that is looked at.
    faces: Vec<PatchFace>,
    scratch: Scratch,
}

/// What keys and choices of edges follow from; any number of them can be looked at side by side.
struct Evaluator<'m, 's, C, P> {
    mesh: &'m TriMesh,
    policies: &'s Policies<C, P>,
    fixed: &'s VertexFreedom,
    valences: &'s ValenceTable,
    detail: &'s Detail,
}

/// How an edge is collapsed, if it is.
#[expect(clippy::large_enum_variant, reason = "there is one at a time")]
enum Choice<'p> {
    /// It costs more than the threshold, and no less than this.
    Above(f64),
    Collapse {
        /// Its first vertex goes.
        patch: EdgePatch<'p>,
        place: Place,
        offset: DVec3,
        cost: f64,
    },
}

impl<'m, C: Cost, P: Placement> Evaluator<'m, '_, C, P> {
    /// The cost of an edge, or the quickest bound of it.
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

    /// Where an edge goes that costs no more than `ceiling`, if policies and constraints allow it.
    fn choose<'p>(
        &self,
        edge: EdgeId,
        ceiling: f64,
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
        let (place, cost) = match assess(policies, fixed, &mut patch, ceiling, scratch)? {
            Assessment::Above(cost) => return Ok(Choice::Above(cost)),
            Assessment::Exact(_, cost) if cost > ceiling => return Ok(Choice::Above(cost)),
            Assessment::Exact(place, cost) => (place, cost),
        };
        let patch = patch.with_faces();
        let is_forced = fixed.place(&patch)?.is_some();
        let (mut next, mut refused) = (place, 0);
        let (patch, place, offset) = loop {
            // The vertex that stays is the one whose position does, if any.
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
        // It may cost more at another place than at the best one.
        let cost = match refused {
            0 => cost,
            _ => cost_at(policies, &patch, offset, scratch),
        };
        Ok(Choice::Collapse { patch, place, offset, cost })
    }
}

/// What has become of an edge whose turn it was.
pub(super) enum Turn {
    Collapsed,
    /// It costs more than the threshold, and no less than this.
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

    /// What the run did, now that it has stopped.
    pub(super) fn finish(self, stop: StopReason) -> Run {
        let (mut run, protected) = (self.result, self.fixed.into_marks());
        (run.stop, run.locked, run.features) = (stop, protected.locked, protected.features);
        run.followers = protected.constraints;
        run
    }

    pub(super) fn reached(&self, watch: &mut TargetCheck<'_>) -> Option<StopReason> {
        watch.reached(self.mesh.topology().face_count(), self.used_vertices, self.result.log.len())
    }

    /// Makes room for what so many collapses leave.
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

    /// Whether an edge may collapse as far as the rest of a larger mesh is concerned.
    fn is_free(&self, edge: EdgeId) -> bool {
        self.is_free.as_ref().is_none_or(|is_free| {
            self.mesh.topology().edge_vertices(edge).iter().all(|v| is_free[v.index()])
        })
    }

    /// The edges that may collapse and are not rejected, with their costs or the quickest bounds of these: those that
    /// are to be looked at first, until [`Stepper::others`] are, and then all.
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

    /// All entries, if they were but the first ones until now.
    pub(super) fn others(&mut self) -> Option<Vec<Entry>> {
        self.first.take()?;
        Some(self.entries())
    }

    /// A bound of the cost of an edge from its ends alone; minus infinity when there is none, or the
    /// edge is gone.
    pub(super) fn early_bound(&self, edge: EdgeId) -> f64 {
        let Self { mesh, policies, fixed, .. } = self;
        let is_there = mesh.topology().contains_edge(edge);
        let bound = is_there.then(|| early_bound(mesh, policies, fixed, edge));
        bound.flatten().unwrap_or(f64::NEG_INFINITY)
    }

    /// The cost of an edge, or the quickest bound of it; `None` when the edge is rejected.
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

    /// Whether to look at edges ahead of their turns, on all threads.
    pub(super) fn looks_ahead(&self) -> bool {
        self.policies.placement.is_asked_ahead() && parallel::threads() > 1
    }

    /// Looks at edges whose turn comes soon, all side by side. Their turns come to the same as without that, only
    /// that much of what they ask for has then been found, where no collapse has changed it since.
    pub(super) fn look_ahead(&mut self, visits: &[Visit], ceiling: f64) {
        let mut ahead = core::mem::take(&mut self.ahead);
        ahead.resize_with(visits.len().max(ahead.len()), Memory::default);
        let evaluator = self.evaluator();
        parallel::update_each(&mut ahead[..visits.len()], |i, Memory { faces, scratch }| {
            if self.mesh.topology().contains_edge(visits[i].edge) {
                // What it comes to is found again; what has been found on the way there stays in the memory.
                let _ = evaluator.choose(visits[i].edge, ceiling, faces, scratch);
            }
        });
        self.ahead = ahead;
    }

    /// Takes out what the look at one of the edges has left, for its turn.
    pub(super) fn recall(&mut self, visit: usize) {
        if let Some(memory) = self.ahead.get_mut(visit) {
            core::mem::swap(&mut self.memory, memory);
        }
    }

    /// Collapses an edge that costs no more than `ceiling`, if everything allows it, and tells the
    /// schedule of the edges that are to wait again.
    pub(super) fn take_turn(
        &mut self,
        edge: EdgeId,
        ceiling: f64,
        schedule: &mut dyn EdgeQueue,
    ) -> Turn {
        match self.try_collapse(edge, ceiling) {
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

    fn try_collapse(&mut self, edge: EdgeId, ceiling: f64) -> Result<Turn, Rejection> {
        let Self { mesh, policies, fixed, memory, valences, detail, .. } = self;
        let Memory { faces, scratch } = memory;
        let evaluator = Evaluator { mesh, policies, fixed, valences, detail };
        let (patch, place, offset, cost) = match evaluator.choose(edge, ceiling, faces, scratch)? {
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
        let faces_before = mesh.topology().face_count() as u32;
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

    /// Takes an edge out of the run; `collapses` is how many of them a run must be allowed for that.
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

    /// Gives the rejected edges around the last collapse another chance.
    fn readmit(&mut self, schedule: &mut dyn EdgeQueue) {
        let topology = self.mesh.topology();
        for &v in &self.touched {
            // Its edges would be rejected again.
            if self.valences.is_crowded(v) {
                continue;
            }
            if core::mem::take(&mut self.refused_at[v.index()]) == 0 {
                continue;
            }
            for edge in topology.edges_of_vertex(v) {
                if core::mem::take(&mut self.is_refused[edge.index()]) {
                    schedule.push_unknown(topology, edge);
                }
            }
        }
    }

    /// Lists the edges whose cost the last collapse may have changed, by index; not those that are
    /// rejected.
    pub(super) fn list_stale(&mut self, stale: &mut Vec<EdgeId>) {
        self.widen_touched();
        let topology = self.mesh.topology();
        stale.clear();
        // The edges of the others wait for more than their cost.
        for &v in self.touched.iter().filter(|&&v| !self.valences.is_crowded(v)) {
            stale.extend(topology.edges_of_vertex(v));
        }
        stale.sort_unstable();
        stale.dedup();
        stale.retain(|edge| !self.is_refused[edge.index()]);
    }

    /// Brings the list of touched vertices to the reach of the cost.
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

/// Whether constraints, cost modifiers and the placement let a collapse pass.
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
