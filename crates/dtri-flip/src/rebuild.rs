//! Ruin and recreate (Schrimpf, Schneider, Stamm-Wilbrandt and Dueck 2000): a way out of deep local
//! minima.
//!
//! Single flips cannot take a vertex from one side of a fold to the other, and what is tangled stays
//! so. But a vertex with three edges walks through a triangulation by two flips a step: the first one
//! turns the side that it crosses into a fourth edge, the second one gives its first edge back. So a
//! round takes the vertices of a patch out, one after the other, puts them aside in one face, and
//! lets them come back one by one: each tries the few places where it costs least, with flips as long as
//! they help, and then it and its neighbours walk on as long as that helps.
//!
//! While it is aside a vertex lies flat in that face, so that its edges are without dihedral angle and
//! the costs around do not feel it.

use std::collections::VecDeque;

use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::{
    EdgeId, EdgeMap, FaceId, FaceMap, HalfEdgeId, Handle, TriMesh, VertexId, VertexMap,
};

use crate::cost::{Change, FlipCost};
use crate::fold::largest_turn;
use crate::greedy;
use crate::intersection::face_crosses;
use crate::options::Rebuild;
use crate::quad::Quad;
use crate::report::Stop;
use crate::run::Run;
use crate::watch::{Phase, Progress, Watch};

/// Rebuilds patches of the local minimum that the run is in. Says why it stopped and how many rounds
/// were kept.
pub(crate) fn run<C: FlipCost>(
    run: &mut Run<'_, C>,
    settings: &Rebuild,
    at_minimum: Stop,
    watch: &mut Watch<'_>,
) -> (Stop, u64) {
    let vertices = run.mesh.topology().vertex_count();
    let mut random = SplitMix64::new(settings.seed);
    let mut site = Site::new(run.mesh);
    let all = settings.effort.saturating_mul(vertices);
    let patience = if all > 0 { all.max(LEAST_TRIED) } else { 0 };
    let mut left = patience;
    let mut kept = 0;
    let mut stopped = None;
    let mut round = 0_u64;
    while left > 0 && stopped.is_none() {
        let size = patch_size(settings, vertices, round, &mut random);
        round += 1;
        let is_found = site.choose(run, size, &mut random);
        left = left.saturating_sub(site.patch.len().max(MIN_PATCH));
        if !is_found {
            stopped = look(run, watch, left);
            continue;
        }
        let is_near = random.uniform() < NEAR;
        match attempt(run, &mut site, is_near, watch, left) {
            Ok(true) => (kept, left) = (kept + 1, patience),
            Ok(false) => {}
            Err(stop) => stopped = Some(stop),
        }
    }
    run.forget_flips_of_edges();
    let stop = match stopped {
        Some(stop) => stop,
        None if kept == 0 => at_minimum,
        None => greedy::run(run, run.rules.options.look_ahead, watch),
    };
    (stop, kept)
}

/// How many vertices are taken out in vain at least.
const LEAST_TRIED: usize = 600;
/// The fewest vertices that are worth a round.
const MIN_PATCH: usize = 3;
/// Every so often, as many vertices as may be are taken out.
const LARGEST_EVERY: u64 = 8;

/// How many of the rounds bring vertices back to where they are closest, and not to the best place of the
/// whole patch, which takes as many flips as there are faces.
const NEAR: f64 = 0.75;

/// Sizes of all orders are equally frequent.
fn patch_size(settings: &Rebuild, vertices: usize, round: u64, random: &mut SplitMix64) -> usize {
    let largest = settings.largest.min(vertices).max(MIN_PATCH);
    let share = random.uniform();
    if round.is_multiple_of(LARGEST_EVERY) && largest == vertices {
        return largest;
    }
    let ratio = largest as f64 / MIN_PATCH as f64;
    ((MIN_PATCH as f64 * ratio.powf(share)) as usize).min(largest)
}

fn look<C: FlipCost>(run: &Run<'_, C>, watch: &mut Watch<'_>, left: usize) -> Option<Stop> {
    let (flips, cost) = (run.log.len() as u64, run.running_cost);
    watch.look(|| Progress { phase: Phase::Rebuilding, flips, cost, waiting: left as u64 })
}

/// The patch of a round, and marks for it.
struct Site {
    /// The vertices to take out.
    patch: Vec<VertexId>,
    /// The corners of the face where they wait.
    keep: [VertexId; 3],
    is_in_patch: VertexMap<bool>,
    is_aside: VertexMap<bool>,
    /// The vertices aside, the last one on top.
    aside: Vec<VertexId>,
    /// The faces where they wait, by their corners: the next one goes to that with its number, and makes
    /// three of it. So no corner gets many edges.
    waiting: Vec<[VertexId; 3]>,
    /// Edges that may flip, and a list of them.
    is_inside: EdgeMap<bool>,
    inside: Vec<EdgeId>,
    /// The faces at these edges. Flips inside keep them the same.
    faces: Vec<FaceId>,
    seen_faces: Marks,
    /// The enclosed volume, if the mesh is closed.
    volume: Option<f64>,
}

/// Marks that are all taken away at once.
struct Marks {
    of_face: FaceMap<u32>,
    now: u32,
}

impl Marks {
    fn start(&mut self) {
        if self.now == u32::MAX {
            self.of_face.as_mut_slice().fill(0);
            self.now = 0;
        }
        self.now += 1;
    }

    /// Marks a face. Says whether it was not marked yet.
    fn add(&mut self, face: FaceId) -> bool {
        let is_new = self.of_face[face] != self.now;
        self.of_face[face] = self.now;
        is_new
    }
}

impl Site {
    fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        Self {
            patch: Vec::new(),
            keep: [VertexId::from_index(0); 3],
            is_in_patch: topology.vertex_map(false),
            is_aside: topology.vertex_map(false),
            aside: Vec::new(),
            waiting: Vec::new(),
            is_inside: topology.edge_map(false),
            inside: Vec::new(),
            faces: Vec::new(),
            seen_faces: Marks { of_face: topology.face_map(0), now: 0 },
            volume: topology.is_closed().then(|| mesh.volume()),
        }
    }

    /// Chooses a face and up to `size` vertices around it that may be taken out. Says whether there
    /// are enough.
    fn choose<C: FlipCost>(
        &mut self,
        run: &Run<'_, C>,
        size: usize,
        random: &mut SplitMix64,
    ) -> bool {
        self.clear();
        let topology = run.mesh.topology();
        let faces = topology.face_capacity();
        let mut any_face = || {
            let index = ((random.uniform() * faces as f64) as usize).min(faces.saturating_sub(1));
            Some(FaceId::from_index(index)).filter(|&f| topology.contains_face(f))
        };
        // Where everything is rebuilt, the face decides which side is outside.
        let is_all = size >= topology.vertex_count();
        let tries = if is_all { FACES_TRIED } else { 1 };
        let candidates: Vec<FaceId> = (0..tries).filter_map(|_| any_face()).collect();
        let Some(face) = (if is_all {
            let rank = |&f: &FaceId| (in_front(run.mesh, f), perimeter(run.mesh, f));
            candidates.into_iter().min_by(|p, q| {
                let ((n, p), (m, q)) = (rank(p), rank(q));
                n.cmp(&m).then(p.total_cmp(&q))
            })
        } else {
            candidates.into_iter().next()
        }) else {
            return false;
        };
        // The vertices come in over the first side.
        let sides = topology.face_half_edges(face);
        let Some(gate) = sides.into_iter().find(|h| run.quad(h.edge()).is_some()) else {
            return false;
        };
        self.keep =
            [topology.origin(gate), topology.target(gate), topology.target(topology.next(gate))];
        self.waiting.push(self.keep);
        self.gather(run, size, random);
        self.patch.len() >= MIN_PATCH
    }

    /// The vertices around the face, ring by ring, in random order.
    fn gather<C: FlipCost>(&mut self, run: &Run<'_, C>, size: usize, random: &mut SplitMix64) {
        let topology = run.mesh.topology();
        let mut waiting: VecDeque<VertexId> = self.keep.into();
        'all: while let Some(v) = waiting.pop_front() {
            for w in topology.one_ring(v) {
                if self.is_in_patch[w] || self.keep.contains(&w) || !is_free(run, w) {
                    continue;
                }
                if self.patch.len() >= size {
                    break 'all;
                }
                self.is_in_patch[w] = true;
                self.patch.push(w);
                waiting.push_back(w);
            }
        }
        for last in (1..self.patch.len()).rev() {
            let other = (random.uniform() * (last + 1) as f64) as usize;
            self.patch.swap(last, other.min(last));
        }
        // A closed surface needs a fourth vertex.
        if self.patch.len() + 3 >= topology.vertex_count()
            && let Some(v) = self.patch.pop()
        {
            self.is_in_patch[v] = false;
        }
        let [a, b, c] = self.keep;
        let of_keep = [(a, b), (b, c), (c, a)].map(|(from, to)| topology.find_half_edge(from, to));
        let spokes = self.patch.iter().flat_map(|&v| topology.edges_of_vertex(v));
        for edge in spokes.chain(of_keep.into_iter().flatten().map(HalfEdgeId::edge)) {
            if !self.is_inside[edge] {
                self.is_inside[edge] = true;
                self.inside.push(edge);
            }
        }
        self.seen_faces.start();
        for &edge in &self.inside {
            for face in topology.edge_faces(edge).into_iter().flatten() {
                if self.seen_faces.add(face) {
                    self.faces.push(face);
                }
            }
        }
    }

    fn clear(&mut self) {
        self.patch.drain(..).for_each(|v| self.is_in_patch[v] = false);
        self.inside.drain(..).for_each(|e| self.is_inside[e] = false);
        self.aside.drain(..).for_each(|v| self.is_aside[v] = false);
        self.waiting.clear();
        self.faces.clear();
    }

    /// Whether an edge may flip now: not those of the vertices aside, nor of the face they are in.
    fn allows(&self, mesh: &TriMesh, edge: EdgeId) -> bool {
        if !self.is_inside[edge] {
            return false;
        }
        let ends = mesh.topology().edge_vertices(edge);
        self.aside.is_empty()
            || !(ends.iter().any(|&v| self.is_aside[v])
                || ends.iter().all(|v| self.keep.contains(v)))
    }

    /// Whether a vertex may go over an edge: outside over those that may flip now, else over those
    /// between the faces where others wait.
    fn lets_pass(&self, mesh: &TriMesh, edge: EdgeId, ground: Ground) -> bool {
        if ground == Ground::Outside {
            return self.allows(mesh, edge);
        }
        let ends = mesh.topology().edge_vertices(edge);
        ends.iter().any(|&v| self.is_aside[v])
            && ends.iter().all(|v| self.is_aside[*v] || self.keep.contains(v))
    }

    /// The side over which vertices come and go, seen from the face where they wait.
    fn gate(&self, mesh: &TriMesh) -> Option<HalfEdgeId> {
        mesh.topology().find_half_edge(self.keep[0], self.keep[1])
    }
}

/// How many faces are looked at for one with everything behind it.
const FACES_TRIED: usize = 64;

/// Whether a vertex may be taken out: none of its edges is on the boundary or locked.
fn is_free<C: FlipCost>(run: &Run<'_, C>, v: VertexId) -> bool {
    run.mesh.topology().edges_of_vertex(v).all(|e| run.quad(e).is_some())
}

fn in_front(mesh: &TriMesh, face: FaceId) -> usize {
    let [a, b, c] = mesh.triangle(face);
    let normal = (b - a).cross(c - a);
    let vertices = mesh.topology().vertices();
    let noise = 1e-12 * normal.length() * ((b - a).length() + (c - a).length());
    vertices.filter(|&v| (mesh.position(v) - a).dot(normal) > noise).count()
}

fn perimeter(mesh: &TriMesh, face: FaceId) -> f64 {
    let [a, b, c] = mesh.triangle(face);
    a.distance(b) + b.distance(c) + c.distance(a)
}

/// The volume between a face and the origin.
fn volume_of(mesh: &TriMesh, face: FaceId) -> f64 {
    let [a, b, c] = mesh.triangle(face);
    a.dot(b.cross(c)) / 6.0
}

/// One round. Says whether it was kept; the mesh is as before when not, or when it was stopped.
fn attempt<C: FlipCost>(
    run: &mut Run<'_, C>,
    site: &mut Site,
    is_near: bool,
    watch: &mut Watch<'_>,
    left: usize,
) -> Result<bool, Stop> {
    let before = run.rules.cost.prepared_total(run.mesh, &run.cache);
    let length = run.log.len();
    let guards = Guards::of(run, site);
    // Only what comes out in the end is held against the other faces.
    let tree = run.tree.take();
    let homes: Vec<(VertexId, DVec3)> =
        site.patch.iter().map(|&v| (v, run.mesh.position(v))).collect();
    let mut work = Work { run: &mut *run, site: &mut *site, homes: &homes, is_near };
    work.take_out();
    let stopped = work.bring_back(watch, left).err();
    let after = run.rules.cost.prepared_total(run.mesh, &run.cache);
    run.tree = tree;
    update_tree(run, site);
    let stopped =
        stopped.or_else(|| (watch.flips_left(run.log.len()) == 0).then_some(Stop::FlipLimit));
    let is_better =
        stopped.is_none() && run.rules.is_gain(Change { before, after }) && guards.allow(run, site);
    if is_better {
        run.running_cost = after;
        let change = guards.change_of_volume(run, site);
        site.volume = site.volume.map(|volume| volume + change);
    } else {
        run.undo_to(length);
        run.running_cost = before;
    }
    stopped.map_or(Ok(is_better), Err)
}

fn update_tree<C: FlipCost>(run: &mut Run<'_, C>, site: &Site) {
    let Run { mesh, tree, .. } = run;
    if let Some(tree) = tree {
        tree.update(mesh, site.faces.iter().copied());
    }
}

/// What a rebuilt patch is held against.
struct Guards {
    /// The largest angle by which a face was turned.
    turn: f64,
    flat: usize,
    volume: f64,
    /// The triangles that were there, if new ones must not cross others.
    triangles: Option<Vec<[VertexId; 3]>>,
}

impl Guards {
    fn of<C: FlipCost>(run: &Run<'_, C>, site: &Site) -> Self {
        let triangles = run.tree.is_some().then(|| {
            let mut triangles: Vec<_> = site.faces.iter().map(|&f| sorted(run.mesh, f)).collect();
            triangles.sort_unstable();
            triangles
        });
        let turn = if run.rules.options.max_fold.is_some() { turn(run, site) } else { 0.0 };
        Self { turn, flat: flat(run, site), volume: volume(run.mesh, site), triangles }
    }

    fn change_of_volume<C: FlipCost>(&self, run: &Run<'_, C>, site: &Site) -> f64 {
        volume(run.mesh, site) - self.volume
    }

    /// Whether the patch as it is now keeps to the rules of single flips, as a whole, and closed
    /// meshes are not turned inside out.
    fn allow<C: FlipCost>(&self, run: &Run<'_, C>, site: &Site) -> bool {
        let limit = run.rules.options.max_fold;
        let turns_over = site
            .volume
            .is_some_and(|volume| volume > 0.0 && volume + self.change_of_volume(run, site) <= 0.0);
        !turns_over
            && flat(run, site) <= self.flat
            && limit.is_none_or(|limit| turn(run, site) <= limit.max(self.turn))
            && !self.crosses(run, site)
    }

    fn crosses<C: FlipCost>(&self, run: &Run<'_, C>, site: &Site) -> bool {
        let (Some(tree), Some(known)) = (&run.tree, &self.triangles) else { return false };
        let is_new = |f: FaceId| known.binary_search(&sorted(run.mesh, f)).is_err();
        site.faces.iter().any(|&f| is_new(f) && face_crosses(tree, run.mesh, f))
    }
}

fn sorted(mesh: &TriMesh, face: FaceId) -> [VertexId; 3] {
    let mut corners = mesh.topology().face_vertices(face);
    corners.sort_unstable();
    corners
}

fn turn<C: FlipCost>(run: &Run<'_, C>, site: &Site) -> f64 {
    let quads = site.inside.iter().filter_map(|&e| run.quad(e));
    quads.map(|quad| largest_turn(run.mesh, &quad)).fold(0.0, f64::max)
}

fn flat<C: FlipCost>(run: &Run<'_, C>, site: &Site) -> usize {
    let corners = |&f: &FaceId| run.mesh.topology().face_vertices(f);
    site.faces.iter().filter(|f| run.rules.is_flat(run.mesh, corners(f))).count()
}

fn volume(mesh: &TriMesh, site: &Site) -> f64 {
    site.faces.iter().map(|&f| volume_of(mesh, f)).sum()
}

/// A round at work.
struct Work<'w, 'a, C: FlipCost> {
    run: &'w mut Run<'a, C>,
    site: &'w mut Site,
    homes: &'w [(VertexId, DVec3)],
    /// Whether vertices come back to the face closest to them, and not to the best of all.
    is_near: bool,
}

/// Where a vertex walks.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ground {
    Outside,
    Aside,
}

/// A face that a vertex can get to: the one it comes from, and the side between them.
struct Place {
    from: usize,
    side: EdgeId,
    face: FaceId,
    steps: usize,
}

/// How far a vertex looks around for a better place, in steps and in faces.
const STEPS: usize = 3;
const PLACES: usize = 24;
/// How many vertices look around after one has come back.
const MOVES: usize = 60;
/// How many of the cheapest places a vertex that comes back tries, with all flips that help there. What
/// costs least before these flips may lead to a fold that stays.
const TRIES: usize = 5;

impl<C: FlipCost> Work<'_, '_, C> {
    fn take_out(&mut self) {
        for &(v, _) in self.homes {
            let (length, cost) = (self.run.log.len(), self.run.running_cost);
            let Some(&corners) = self.site.waiting.get(self.site.aside.len()) else { return };
            if !(self.strip(v) && self.go_aside(v, corners)) {
                self.back_to(length, cost);
                continue;
            }
            let [a, b, c] = corners;
            self.put(v, corners.map(|w| self.run.mesh.position(w)).iter().sum::<DVec3>() / 3.0);
            self.site.waiting.extend([[a, b, v], [b, c, v], [c, a, v]]);
            self.site.aside.push(v);
            self.site.is_aside[v] = true;
        }
    }

    /// Brings all vertices back, unless the caller says to stop: then to where they were, but with the
    /// wrong edges.
    fn bring_back(&mut self, watch: &mut Watch<'_>, left: usize) -> Result<(), Stop> {
        let mut homes = self.run.mesh.topology().vertex_map(DVec3::ZERO);
        self.homes.iter().for_each(|&(v, home)| homes[v] = home);
        while let Some(v) = self.site.aside.pop() {
            self.site.is_aside[v] = false;
            if let Some(stop) = look(self.run, watch, left) {
                self.site.aside.push(v);
                for v in core::mem::take(&mut self.site.aside) {
                    self.site.is_aside[v] = false;
                    self.put(v, homes[v]);
                }
                return Err(stop);
            }
            self.site.waiting.truncate(3 * self.site.aside.len() + 1);
            let is_out = self.come_out(v);
            self.put(v, homes[v]);
            if !is_out {
                continue;
            }
            if self.is_near {
                self.go_home(v);
            } else {
                self.settle(v, usize::MAX, usize::MAX, TRIES);
            }
            let around = self.around(v);
            self.descend(around);
            self.look_around(v);
        }
        let all = self.site.inside.clone();
        self.descend(all);
        Ok(())
    }

    /// Moves a vertex in space, and what the cost knows of its edges with it.
    fn put(&mut self, v: VertexId, to: DVec3) {
        self.run.mesh.positions_mut()[v.index()] = to;
        let topology = self.run.mesh.topology();
        let quads: Vec<Quad> =
            topology.edges_of_vertex(v).filter_map(|e| Quad::around(topology, e)).collect();
        let Run { mesh, cache, rules, .. } = &mut *self.run;
        quads.iter().for_each(|quad| rules.cost.update(mesh, cache, quad));
    }

    /// Undoes flips, all of which were done with the vertices where they are.
    fn back_to(&mut self, length: usize, cost: f64) {
        self.run.undo_to(length);
        self.run.running_cost = cost;
    }

    /// Flips an edge whatever it costs.
    fn flip(&mut self, edge: EdgeId) -> bool {
        let Some(change) = self.run.change(edge) else { return false };
        let Ok(flip) = self.run.mesh.topology().check_flip(edge) else { return false };
        self.run.record(flip, change);
        true
    }

    /// Flips edges of a vertex away, the cheapest first, until it has three.
    fn strip(&mut self, v: VertexId) -> bool {
        while self.run.mesh.topology().valence(v) > 3 {
            let topology = self.run.mesh.topology();
            let may_flip =
                |&e: &EdgeId| self.site.allows(self.run.mesh, e) && topology.check_flip(e).is_ok();
            let gain = |e: EdgeId| self.run.change(e).map(|change| (change.gain(), e));
            let gains = topology.edges_of_vertex(v).filter(may_flip).filter_map(gain);
            let Some((_, best)) = gains.max_by(|p, q| p.0.total_cmp(&q.0)) else { return false };
            if !self.flip(best) {
                return false;
            }
        }
        true
    }

    /// Takes a vertex with three edges over a side of the face that it is in.
    fn step(&mut self, v: VertexId, side: EdgeId) -> bool {
        let topology = self.run.mesh.topology();
        let ends = topology.edge_vertices(side);
        let is_behind =
            |&e: &EdgeId| !topology.edge_vertices(e).iter().any(|end| ends.contains(end));
        let Some(behind) = topology.edges_of_vertex(v).find(is_behind) else { return false };
        let (length, cost) = (self.run.log.len(), self.run.running_cost);
        if self.flip(side) && self.flip(behind) {
            return true;
        }
        self.back_to(length, cost);
        false
    }

    /// Takes a vertex with three edges to the face with these corners, among those where others wait.
    fn go_aside(&mut self, v: VertexId, [a, b, _]: [VertexId; 3]) -> bool {
        let (length, cost) = (self.run.log.len(), self.run.running_cost);
        let is_there = self.site.gate(self.run.mesh).is_some_and(|gate| {
            self.walk_to(v, gate.twin(), Ground::Outside) && self.step(v, gate.edge())
        });
        let goal = self.run.mesh.topology().find_half_edge(a, b);
        let is_there = is_there && goal.is_some_and(|goal| self.walk_to(v, goal, Ground::Aside));
        if !is_there {
            self.back_to(length, cost);
        }
        is_there
    }

    /// Takes a vertex with three edges from where it waits to the face beyond the gate.
    fn come_out(&mut self, v: VertexId) -> bool {
        let Some(gate) = self.site.gate(self.run.mesh) else { return false };
        self.walk_to(v, gate, Ground::Aside)
            && self.site.gate(self.run.mesh).is_some_and(|gate| self.step(v, gate.edge()))
    }

    /// Takes a vertex with three edges to the face at a half-edge, unless it is at a corner of that.
    fn walk_to(&mut self, v: VertexId, side: HalfEdgeId, ground: Ground) -> bool {
        let Some(goal) = self.run.mesh.topology().face(side) else { return false };
        if self.run.mesh.topology().face_vertices(goal).contains(&v) {
            return true;
        }
        let places = self.places(v, ground, usize::MAX, usize::MAX, Some(goal));
        let at = places.iter().position(|place| place.face == goal);
        at.is_some_and(|at| self.walk(v, &places, at))
    }

    /// The faces that a vertex with three edges can get to, each after the one it is reached from. The
    /// first one stands for the three faces at the vertex.
    fn places(
        &mut self,
        v: VertexId,
        ground: Ground,
        steps: usize,
        most: usize,
        goal: Option<FaceId>,
    ) -> Vec<Place> {
        let topology = self.run.mesh.topology();
        self.site.seen_faces.start();
        let mut places: Vec<Place> = Vec::new();
        let mut own = topology.faces_of_vertex(v);
        let Some(face) = own.next() else { return places };
        let side = topology.face_edges(face)[0];
        places.push(Place { from: 0, side, face, steps: 0 });
        topology.faces_of_vertex(v).for_each(|f| {
            self.site.seen_faces.add(f);
        });
        let mut at = 0;
        while at < places.len() && places.len() < most {
            let (face, far) = (places[at].face, places[at].steps);
            let sides: Vec<EdgeId> = if at == 0 {
                let faces = topology.faces_of_vertex(v);
                let is_side = |&e: &EdgeId| !topology.edge_vertices(e).contains(&v);
                faces.flat_map(|f| topology.face_edges(f)).filter(is_side).collect()
            } else {
                topology.face_edges(face).to_vec()
            };
            if far < steps {
                for side in sides {
                    if !self.site.lets_pass(self.run.mesh, side, ground) {
                        continue;
                    }
                    for next in topology.edge_faces(side).into_iter().flatten() {
                        if self.site.seen_faces.add(next) {
                            places.push(Place { from: at, side, face: next, steps: far + 1 });
                            if goal == Some(next) {
                                return places;
                            }
                        }
                    }
                }
            }
            at += 1;
        }
        places
    }

    /// Takes a vertex with three edges to the face where it costs least, of those within so many steps.
    fn settle(&mut self, v: VertexId, steps: usize, most: usize, tries: usize) {
        let places = self.places(v, Ground::Outside, steps, most, None);
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); places.len()];
        for (i, place) in places.iter().enumerate().skip(1) {
            children[place.from].push(i);
        }
        let mut costs = vec![(self.run.running_cost, 0)];
        // Through all places and back, with the way and the cost of each place on it.
        let mut way = vec![(0, 0, self.run.log.len(), self.run.running_cost)];
        while let Some((place, tried, length, cost)) = way.last_mut() {
            let (length, cost) = (*length, *cost);
            let child = children[*place].get(*tried).copied();
            *tried += 1;
            if self.run.log.len() != length {
                self.back_to(length, cost);
            }
            let Some(child) = child else {
                way.pop();
                continue;
            };
            if self.step(v, places[child].side) {
                costs.push((self.run.running_cost, child));
                way.push((child, 0, self.run.log.len(), self.run.running_cost));
            }
        }
        costs.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        costs.truncate(tries);
        let (length, cost) = (self.run.log.len(), self.run.running_cost);
        let mut best = (f64::INFINITY, 0);
        if costs.len() > 1 {
            for &(_, place) in &costs {
                self.walk(v, &places, place);
                self.descend(self.around(v));
                if self.run.running_cost < best.0 {
                    best = (self.run.running_cost, place);
                }
                self.back_to(length, cost);
            }
        } else if let Some(&least) = costs.first() {
            best = least;
        }
        self.walk(v, &places, best.1);
    }

    /// Takes a vertex with three edges to one of its places. Says whether it got there; if not, it is
    /// where it was.
    fn walk(&mut self, v: VertexId, places: &[Place], mut to: usize) -> bool {
        let (length, cost) = (self.run.log.len(), self.run.running_cost);
        let mut sides = Vec::new();
        while to != 0 {
            sides.push(places[to].side);
            to = places[to].from;
        }
        let is_there = sides.into_iter().rev().all(|side| self.step(v, side));
        if !is_there {
            self.back_to(length, cost);
        }
        is_there
    }

    /// Takes a vertex with three edges to the face that is closest to it, and to the best one near that
    /// face.
    fn go_home(&mut self, v: VertexId) {
        let home = self.run.mesh.position(v);
        let places = self.places(v, Ground::Outside, usize::MAX, usize::MAX, None);
        let distance = |place: &Place| {
            let [a, b, c] = self.run.mesh.triangle(place.face);
            ((a + b + c) / 3.0).distance_squared(home)
        };
        let away = places.iter().enumerate().skip(1).map(|(i, place)| (i, distance(place)));
        if let Some((closest, _)) = away.min_by(|p, q| p.1.total_cmp(&q.1)) {
            self.walk(v, &places, closest);
        }
        self.settle(v, STEPS, PLACES, TRIES);
    }

    /// The edges whose flips the edges of a vertex may matter for.
    fn around(&self, v: VertexId) -> Vec<EdgeId> {
        let topology = self.run.mesh.topology();
        topology.faces_of_vertex(v).flat_map(|f| topology.face_edges(f)).collect()
    }

    /// Flips these edges, and others near those that were flipped, as long as that lowers the cost.
    fn descend(&mut self, mut open: Vec<EdgeId>) {
        // Costs that are no potential may go in circles.
        let mut left = 64 * (self.site.inside.len() + open.len());
        while let Some(edge) = open.pop() {
            if left == 0 {
                return;
            }
            left -= 1;
            if !self.site.allows(self.run.mesh, edge) {
                continue;
            }
            let Some(change) = self.run.gainful_change(edge) else { continue };
            let Ok(flip) = self.run.allow(edge) else { continue };
            let Some(quad) = self.run.record(flip, change) else { continue };
            let topology = self.run.mesh.topology();
            for side in quad.sides {
                open.push(side.edge());
                let beyond = Quad::around(topology, side.edge());
                open.extend(beyond.into_iter().flat_map(|quad| quad.sides).map(HalfEdgeId::edge));
            }
        }
    }

    /// Lets a vertex and its neighbours look for better places, and those of the ones that move.
    fn look_around(&mut self, v: VertexId) {
        let mut open = self.star(v);
        let mut moves = MOVES;
        while let Some(w) = open.pop() {
            if moves == 0 {
                return;
            }
            moves -= 1;
            if self.site.is_in_patch[w] && !self.site.is_aside[w] && self.relocate(w) {
                open = self.star(w);
            }
        }
    }

    /// A vertex after its neighbours.
    fn star(&self, v: VertexId) -> Vec<VertexId> {
        self.run.mesh.topology().one_ring(v).chain([v]).collect()
    }

    /// Takes a vertex to a better place, if there is one near.
    fn relocate(&mut self, v: VertexId) -> bool {
        let (length, cost) = (self.run.log.len(), self.run.running_cost);
        if self.strip(v) {
            self.settle(v, STEPS, PLACES, 1);
            let around = self.around(v);
            let flipped: Vec<EdgeId> = self.run.log[length..].to_vec();
            self.descend(flipped.into_iter().chain(around).collect());
            if self.run.rules.is_gain(Change { before: cost, after: self.run.running_cost }) {
                return true;
            }
        }
        self.back_to(length, cost);
        false
    }
}
