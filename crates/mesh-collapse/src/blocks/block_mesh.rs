//! A block of a mesh under collapse, small enough for the cache of a core.

use core::ops::Range;

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;
use mesh_core::as_u32;
use mesh_core::parallel;

use crate::blocks::block_vertex::{BlockVertex, rows};
use crate::blocks::bucket_queue::{BUCKETS, BucketQueue, bucket};
use crate::blocks::candidates::{FARTHEST, TIE, candidates};
use crate::blocks::corner_table::{CornerTable, NONE, STRIDE, previous};
use crate::blocks::edge_rows::Patch;
use crate::blocks::lanes::LANES;
use crate::blocks::rules::Rules;
use crate::engine::valence::{MOST_EDGES, is_later};
use crate::geometry::quadric::Quadric;
use crate::rejection::{Rejection, Rejections};

/// A part of a mesh, from which a block mesh is built.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Part {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) positions: Vec<DVec3>,
    /// Quadrics of the own vertices, which come first; empty before the first pass.
    pub(super) quadrics: Vec<Quadric>,
    /// The number of own vertices. The others are included only as corners of faces that they share with these.
    pub(super) own: usize,
    /// The half-edges of the original, if collapses are recorded or `half_edge_capacity` is known.
    pub(super) half_edges: Vec<[u32; 3]>,
    /// An even number above all half-edges, for a part that is a whole mesh with known half-edges; otherwise 0.
    pub(super) half_edge_capacity: usize,
}

/// A collapse, with ids of the block mesh.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Step {
    pub(super) removed: u32,
    pub(super) kept: u32,
    /// The half-edge of the original.
    pub(super) half_edge: u32,
    /// The number of removed faces.
    pub(super) faces: u32,
    pub(super) position: DVec3,
    pub(super) cost: f64,
}

/// The end of the collapses of a block mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    /// Edges of this bucket and higher ones do not collapse.
    pub(super) end: usize,
    /// The run ends with this many faces, or one fewer.
    pub(super) faces: usize,
}

/// A part of a mesh under collapse.
///
/// An edge collapses only if all faces around both ends belong only to own vertices. So the block meshes of a mesh do
/// not affect each other.
#[derive(Debug)]
pub(super) struct BlockMesh {
    rules: Rules,
    corners: CornerTable,
    vertices: Vec<BlockVertex>,
    /// For each edge, whether it was rejected and waits for a change around it.
    is_refused: Vec<bool>,
    /// Vertices whose rejected edges are tried again later.
    later: Vec<u32>,
    queue: BucketQueue,
    /// The half-edge of each side; empty unless collapses are recorded.
    half_edges: Vec<u32>,
    patch: Patch,
    pub(super) rejections: Rejections,
    pub(super) steps: Vec<Step>,
    pub(super) merged: Vec<[u32; 2]>,
    pub(super) max_cost: f64,
}

/// Edges of one bucket that are evaluated together.
#[derive(Clone, Copy, Debug, Default)]
struct Batch {
    edges: [u32; LANES],
    ends: [[u32; 2]; LANES],
    count: usize,
    /// The bucket.
    at: usize,
}

/// A candidate for a collapse.
#[derive(Clone, Copy, Debug)]
struct Offer {
    side: u32,
    half: DVec3,
    /// The quadric of both ends, about the midpoint.
    quadric: Quadric,
    /// The position of the remaining vertex, relative to the midpoint.
    x: DVec3,
    cost: f64,
}

/// The outcome of the turn of an edge.
enum Turn {
    Collapsed {
        faces: u32,
    },
    /// Its cost is higher than the bucket, so it moves to this bucket.
    Later(usize),
}

/// Marks an edge that does not wait.
const HELD: u16 = u16::MAX;
const _: () = assert!(BUCKETS <= HELD as usize);

/// The number of turns between two calls that ask whether to go on.
const ASKED_EVERY: usize = 4096;

impl BlockMesh {
    pub(super) fn new(part: Part, rules: Rules) -> Self {
        let Part { triangles, positions, quadrics, own, mut half_edges, half_edge_capacity } = part;
        let remembers = !quadrics.is_empty();
        let corners = || match half_edge_capacity {
            0 => CornerTable::new(positions.len(), &triangles),
            capacity => {
                CornerTable::of_half_edges(positions.len(), &triangles, &half_edges, capacity)
            }
        };
        let vertices = || {
            let quadrics = quadrics.into_iter().chain(core::iter::repeat(Quadric::default()));
            let vertex = |(&position, quadric): (_, Quadric)| BlockVertex::new(position, &quadric);
            let mut vertices: Vec<BlockVertex> =
                positions.iter().zip(quadrics).map(vertex).collect();
            let mut is_free = vec![true; vertices.len()];
            for t in &triangles {
                let is_own = t.iter().all(|&v| (v as usize) < own);
                for &v in t {
                    let vertex = &mut vertices[v as usize];
                    vertex.set_valence(vertex.valence() + 1);
                    is_free[v as usize] &= is_own;
                }
            }
            (vertices, is_free)
        };
        let (corners, (mut vertices, is_free)) = parallel::both(corners, vertices);
        drop(positions);
        if !rules.record {
            half_edges = Vec::new();
        }
        if !remembers {
            remember_faces(&mut vertices, &triangles, &corners, rules.border);
        }
        drop(triangles);
        let mut block_mesh = Self {
            rules,
            is_refused: vec![false; corners.edge_capacity()],
            later: Vec::new(),
            queue: BucketQueue::new(corners.edge_capacity()),
            half_edges: half_edges.into_iter().flat_map(|[a, b, c]| [a, b, c, NONE]).collect(),
            patch: Patch::new(),
            rejections: Rejections::default(),
            steps: Vec::new(),
            merged: Vec::new(),
            max_cost: 0.0,
            vertices,
            corners,
        };
        block_mesh.queue_all(&is_free);
        block_mesh
    }

    /// Puts all edges between free vertices into the queue. Only a block mesh that is a whole mesh has more than one or
    /// two blocks of them.
    fn queue_all(&mut self, is_free: &[bool]) {
        const BLOCK: u32 = 1 << 14;
        let count = as_u32(self.corners.edge_capacity());
        let blocks = parallel::collect_each(count.div_ceil(BLOCK) as usize, |block| {
            let start = BLOCK * as_u32(block);
            let edges = start..count.min(start + BLOCK);
            dispatch!(Level::new(), simd => self.buckets(simd, edges, is_free))
        });
        for (edge, bucket) in blocks.into_iter().flatten().enumerate() {
            if bucket != HELD {
                self.queue.push(as_u32(edge), bucket.into());
            }
        }
    }

    /// The bucket of each edge in the range; [`HELD`] if an end is not free.
    #[inline(always)]
    fn buckets<S: Simd>(&self, simd: S, edges: Range<u32>, is_free: &[bool]) -> Vec<u16> {
        let (start, mut all) = (edges.start, vec![HELD; edges.len()]);
        let mut batch = Batch::default();
        for edge in edges {
            let ends = self.ends(self.corners.of_edge(edge));
            if ends.iter().all(|&v| is_free[v as usize]) {
                batch.push(edge, ends);
            }
            if batch.count == LANES {
                self.evaluate(simd, &batch, start, &mut all);
                batch.count = 0;
            }
        }
        self.evaluate(simd, &batch, start, &mut all);
        all
    }

    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "there are fewer buckets than 65,536")]
    fn evaluate<S: Simd>(&self, simd: S, batch: &Batch, start: u32, buckets: &mut [u16]) {
        let candidates = candidates(simd, &self.vertices, &batch.ends, self.rules.marginal);
        for (&edge, cost) in batch.edges[..batch.count].iter().zip(candidates.costs) {
            buckets[(edge - start) as usize] = bucket(cost * self.rules.scale) as u16;
        }
    }

    #[inline(always)]
    fn ends(&self, side: u32) -> [u32; 2] {
        [self.corners.vertex(side), self.corners.target(side)]
    }

    /// The number of remaining faces, including faces of other blocks.
    pub(super) fn faces(&self) -> usize {
        self.corners.faces()
    }

    pub(super) fn triangles(&self) -> impl Iterator<Item = (usize, [u32; 3])> + '_ {
        self.corners.triangles()
    }

    pub(super) fn half_edges(&self, face: usize) -> [u32; 3] {
        [0, 1, 2].map(|i| self.half_edges.get(STRIDE * face + i).copied().unwrap_or_default())
    }

    pub(super) fn position(&self, v: usize) -> DVec3 {
        self.vertices[v].position
    }

    pub(super) fn quadric(&self, v: usize) -> Quadric {
        self.vertices[v].quadric()
    }

    /// Collapses edges, the cheapest first, until the goal is reached, no edge is left, or `goes_on` returns false.
    /// `done` receives, for each collapse, the highest bucket so far and the number of removed faces.
    pub(super) fn run(
        &mut self,
        goal: Goal,
        goes_on: &mut dyn FnMut(usize, usize) -> bool,
        done: &mut dyn FnMut(usize, u32),
    ) -> bool {
        dispatch!(Level::new(), simd => self.run_with(simd, goal, goes_on, done))
    }

    #[inline(always)]
    fn run_with<S: Simd>(
        &mut self,
        simd: S,
        goal: Goal,
        goes_on: &mut dyn FnMut(usize, usize) -> bool,
        done: &mut dyn FnMut(usize, u32),
    ) -> bool {
        let (mut turns, mut asked, mut highest) = (0, ASKED_EVERY, 0);
        while self.faces() > goal.faces {
            if turns >= asked {
                asked = turns + ASKED_EVERY;
                if !goes_on(self.faces(), self.merged.len()) {
                    return false;
                }
            }
            let batch = self.take(goal.end, &mut turns);
            if batch.count == 0 {
                if self.readmit_later() {
                    continue;
                }
                return true;
            }
            let candidates = candidates(simd, &self.vertices, &batch.ends, self.rules.marginal);
            // The remaining vertices of earlier edges of the batch.
            let mut kept = [NONE; LANES];
            for lane in 0..batch.count {
                let (edge, ends) = (batch.edges[lane], batch.ends[lane]);
                let side = self.corners.of_edge(edge);
                if side == NONE {
                    continue;
                }
                if self.ends(side) != ends || ends.iter().any(|v| kept.contains(v)) {
                    // The evaluation of this edge is out of date.
                    self.queue.push(edge, batch.at);
                    continue;
                }
                let (x, cost) = (candidates.place(lane), candidates.costs[lane]);
                match self.take_turn(simd, side, x, cost, batch.at) {
                    Ok(Turn::Later(due)) => self.queue.push(edge, due),
                    Ok(Turn::Collapsed { faces }) => {
                        kept[lane] = ends[1];
                        highest = batch.at.max(highest);
                        done(highest, faces);
                        if self.faces() <= goal.faces {
                            break;
                        }
                    }
                    Err(rejection) => self.refuse(edge, ends, rejection),
                }
            }
        }
        true
    }

    /// The next edges; an empty batch if none is left below `end`.
    #[inline(always)]
    fn take(&mut self, end: usize, turns: &mut usize) -> Batch {
        let mut batch = Batch::default();
        while batch.count < LANES {
            let next = match batch.count {
                0 => self.queue.pop(end),
                _ => self.queue.pop_another(batch.at).map(|edge| (edge, batch.at)),
            };
            let Some((edge, at)) = next else { break };
            *turns += 1;
            let side = self.corners.of_edge(edge);
            if side == NONE {
                continue;
            }
            let ends = self.ends(side);
            if ends.iter().any(|&v| self.vertices[v as usize].valence() > MOST_EDGES) {
                self.refuse(edge, ends, Rejection::Valence);
                continue;
            }
            batch.at = at;
            batch.push(edge, ends);
        }
        batch
    }

    /// Collapses the edge of a side to the position `x`, or returns the reason for the rejection.
    #[inline(always)]
    fn take_turn<S: Simd>(
        &mut self,
        simd: S,
        side: u32,
        x: DVec3,
        cost: f64,
        at: usize,
    ) -> Result<Turn, Rejection> {
        let due = bucket(cost * self.rules.scale);
        if due > at {
            return Ok(Turn::Later(due));
        }
        let ends = self.ends(side);
        let [a, b] = [ends[0] as usize, ends[1] as usize];
        let half = 0.5 * (self.vertices[b].position - self.vertices[a].position);
        self.patch.gather(simd, &self.corners, &mut self.vertices, side, half)?;
        let (a, b) = (self.vertices[a].quadric(), self.vertices[b].quadric());
        let quadric = a.joined(&b, half);
        let mut offer = Offer { side, half, quadric, x, cost };
        if self.rules.keep_volume {
            let (normal, offset, size) = self.patch.volume(simd);
            if normal.length_squared() > 1e-6 * size {
                let made = if self.rules.marginal { a.constant + b.constant } else { 0.0 };
                offer.settle(quadric.minimizer(Some((normal, offset))), made);
            }
            let due = bucket(offer.cost * self.rules.scale);
            if due > at {
                return Ok(Turn::Later(due));
            }
        }
        if !offer.x.is_finite() || !offer.cost.is_finite() {
            return Err(Rejection::NotFinite);
        }
        self.patch.check(simd, offer.x, &self.rules)?;
        Ok(Turn::Collapsed { faces: self.collapse(&offer, ends, at) })
    }

    fn refuse(&mut self, edge: u32, ends: [u32; 2], rejection: Rejection) {
        self.rejections.count(rejection);
        self.is_refused[edge as usize] = true;
        ends.into_iter().for_each(|v| self.vertices[v as usize].set_refused(true));
    }

    /// Carries out a collapse, and returns the number of removed faces.
    #[inline]
    fn collapse(&mut self, offer: &Offer, [removed, kept]: [u32; 2], at: usize) -> u32 {
        let Offer { side, half, quadric, x, cost } = *offer;
        let half_edge = self.half_edges.get(side as usize).copied();
        let apexes = [self.corners.apex(side), self.corners.apex(self.corners.twin(side))];
        let faces = self.corners.faces();
        let half_edges = &mut self.half_edges;
        self.corners.collapse(side, self.patch.fan(), self.patch.is_at_rim(), |stays, across| {
            if !half_edges.is_empty() {
                half_edges[across as usize] = half_edges[stays as usize];
            }
        });
        let faces = as_u32(faces - self.corners.faces());
        let gone = &self.vertices[removed as usize];
        let (valence, has_refused) = (gone.valence(), gone.has_refused());
        let position = gone.position + half + x;
        self.vertices[removed as usize].set_valence(0);
        let vertex = &mut self.vertices[kept as usize];
        vertex.position = position;
        vertex.set_quadric(&quadric.moved_by(x));
        vertex.set_valence(vertex.valence() + valence - 2 * faces);
        let has_refused = vertex.has_refused() || has_refused;
        vertex.set_refused(has_refused);
        for apex in apexes.into_iter().filter(|&apex| apex != NONE) {
            let apex = &mut self.vertices[apex as usize];
            apex.set_valence(apex.valence() - 1);
        }
        self.max_cost = self.max_cost.max(cost);
        self.merged.push([removed, kept]);
        if let Some(half_edge) = half_edge {
            self.steps.push(Step { removed, kept, half_edge, faces, position, cost });
        }
        if has_refused || self.patch.any_refused() {
            self.readmit(kept, at);
        }
        faces
    }

    /// Puts the rejected edges around a collapse back into the queue.
    fn readmit(&mut self, kept: u32, at: usize) {
        let first = self.corners.first_at(kept);
        let mut corner = first;
        self.readmit_at(kept, at);
        self.readmit_at(self.corners.target(corner), at);
        loop {
            self.readmit_at(self.corners.vertex(previous(corner)), at);
            match self.corners.turn(corner, first) {
                Some(next) => corner = next,
                None => break,
            }
        }
    }

    fn readmit_at(&mut self, v: u32, at: usize) {
        // Edges at a vertex of too high valence would be rejected again.
        if !self.vertices[v as usize].has_refused()
            || self.vertices[v as usize].valence() > MOST_EDGES
        {
            return;
        }
        if is_later(self.vertices[v as usize].valence()) {
            if self.later.last() != Some(&v) {
                self.later.push(v);
            }
            return;
        }
        self.readmit_edges_of(v, at);
    }

    /// Puts the rejected edges that were left for later back into the queue, and returns whether there are any.
    fn readmit_later(&mut self) -> bool {
        let mut any = false;
        for v in core::mem::take(&mut self.later) {
            let vertex = &self.vertices[v as usize];
            // Merged vertices have no edges.
            if vertex.has_refused() && (1..=MOST_EDGES).contains(&vertex.valence()) {
                any |= self.readmit_edges_of(v, 0);
            }
        }
        any
    }

    /// Puts the rejected edges of a vertex back into the queue, and returns whether there are any.
    fn readmit_edges_of(&mut self, v: u32, at: usize) -> bool {
        self.vertices[v as usize].set_refused(false);
        let first = self.corners.first_at(v);
        let mut corner = first;
        let mut any = self.readmit_edge(self.corners.edge(corner), at);
        loop {
            any |= self.readmit_edge(self.corners.edge(previous(corner)), at);
            match self.corners.turn(corner, first) {
                Some(next) => corner = next,
                None => return any,
            }
        }
    }

    fn readmit_edge(&mut self, edge: u32, at: usize) -> bool {
        let is_new =
            core::mem::take(&mut self.is_refused[edge as usize]) && !self.queue.contains(edge);
        if is_new {
            self.queue.push(edge, at);
        }
        is_new
    }
}

/// Sets the quadrics of the vertices from the current faces and boundary.
fn remember_faces(
    vertices: &mut [BlockVertex],
    triangles: &[[u32; 3]],
    corners: &CornerTable,
    with_border: bool,
) {
    for (face, t) in triangles.iter().enumerate() {
        let at = |v: u32| vertices[v as usize].position;
        let (a, b, c) = (at(t[0]), at(t[1]), at(t[2]));
        let cross = (b - a).cross(c - a);
        let double_area = cross.length();
        if double_area <= 0.0 {
            continue;
        }
        let plane = rows(&Quadric::plane(cross, 0.0, 1.0 / (6.0 * double_area)));
        t.iter().for_each(|&v| vertices[v as usize].add(&plane));
        for i in 0..3 {
            if with_border && corners.twin(as_u32(STRIDE * face + i)) == NONE {
                let ends = [t[i], t[(i + 1) % 3]];
                let along =
                    vertices[ends[1] as usize].position - vertices[ends[0] as usize].position;
                let across = along.cross(cross / double_area);
                let border = rows(&Quadric::plane(across, 0.0, 0.5));
                ends.into_iter().for_each(|v| vertices[v as usize].add(&border));
            }
        }
    }
}

impl Batch {
    /// Adds an edge, and fills the free lanes with it as well.
    #[inline(always)]
    fn push(&mut self, edge: u32, ends: [u32; 2]) {
        self.edges[self.count] = edge;
        self.ends[self.count..].fill(ends);
        self.count += 1;
    }
}

impl Offer {
    /// Sets the position, or the best of the midpoint and the ends if it is too far away. `made` is subtracted from the
    /// cost.
    fn settle(&mut self, place: Option<DVec3>, made: f64) {
        let near = 4.0 * FARTHEST * FARTHEST * self.half.length_squared();
        self.x = match place {
            Some(x) if x.length_squared() <= near => x,
            _ => {
                let places = [DVec3::ZERO, -self.half, self.half];
                let value = |i: usize| self.quadric.value(places[i]);
                let values = [value(0), value(1), value(2)];
                let best =
                    (1..3).fold(0, |best, i| if values[i] < values[best] { i } else { best });
                places[best]
            }
        };
        let squared_length = 4.0 * self.half.length_squared();
        let tie = TIE * squared_length * squared_length;
        self.cost = (self.quadric.value(self.x) - made).max(0.0) + tie;
    }
}
