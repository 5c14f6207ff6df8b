//! A region of a mesh by itself, small enough for the nearest cache, under collapse.

use glam::DVec3;

use crate::collapse::quadric::Quadric;
use crate::collapse::refusal::{Refusal, Refusals};
use crate::collapse::valence::MOST_EDGES;
use crate::regions::corners::{Corners, NONE, next, previous};
use crate::regions::rules::Rules;
use crate::regions::waiting::{Waiting, bucket};

/// A part of a mesh: what the tile is made of.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Part {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) positions: Vec<DVec3>,
    /// Of the vertices that belong to the part, which come first; none before the first pass.
    pub(super) quadrics: Vec<Quadric>,
    /// The number of vertices that belong to it; the others are there for the sake of the faces
    /// that they share with these.
    pub(super) own: usize,
    /// The half-edges of the original, if collapses are recorded.
    pub(super) half_edges: Vec<[u32; 3]>,
}

/// A collapse, in numbers of the tile.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Step {
    pub(super) removed: u32,
    pub(super) kept: u32,
    /// Of the original.
    pub(super) half_edge: u32,
    /// The faces that went.
    pub(super) faces: u32,
    pub(super) position: DVec3,
    pub(super) cost: f64,
}

/// How far a tile is collapsed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    /// No edge of this bucket or one above collapses.
    pub(super) end: usize,
    /// With so many faces, or one fewer, it ends.
    pub(super) faces: usize,
}

/// A vertex with what it remembers.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    position: DVec3,
    quadric: Quadric,
}

/// A part of a mesh under collapse.
///
/// Edges collapse only where all faces round both ends belong to vertices of this tile alone, so
/// that tiles of one mesh never see each other's work.
#[derive(Debug)]
pub(super) struct Tile {
    rules: Rules,
    corners: Corners,
    vertices: Vec<Vertex>,
    /// The number of faces at each vertex.
    valences: Vec<u32>,
    /// Whether an edge at the vertex was refused.
    has_refused: Vec<bool>,
    /// By edge: refused, and waits for nothing but a change round it.
    is_refused: Vec<bool>,
    waiting: Waiting,
    half_edges: Vec<u32>,
    /// The last patch that met each vertex.
    met: Vec<u32>,
    patches: u32,
    spokes: Vec<Spoke>,
    any_refused: bool,
    pub(super) refusals: Refusals,
    pub(super) steps: Vec<Step>,
    pub(super) merged: Vec<[u32; 2]>,
    pub(super) max_cost: f64,
}

/// A face of the patch of an edge that has one of its ends.
#[derive(Clone, Copy, Debug)]
struct Spoke {
    /// The corners, from the end of the edge, relative to the midpoint of the edge.
    corners: [DVec3; 3],
    cross: DVec3,
}

impl Spoke {
    fn new(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        Self { corners, cross: (b - a).cross(c - a) }
    }
}

/// The edge that has its turn.
#[derive(Clone, Copy, Debug)]
struct Offer {
    side: u32,
    half: DVec3,
    quadric: Quadric,
    /// Errors already made.
    made: f64,
    /// The place of the vertex that remains, relative to the midpoint.
    x: DVec3,
    cost: f64,
}

/// The largest accepted distance from the middle of the edge, in edge lengths.
const FARTHEST: f64 = 10.0;

/// How many edges have their turn between two questions whether to go on.
const ASKED_EVERY: usize = 4096;

impl Tile {
    pub(super) fn new(part: Part, rules: Rules) -> Self {
        let Part { triangles, positions, quadrics, own, half_edges } = part;
        let corners = Corners::new(positions.len(), &triangles);
        let count = positions.len();
        let mut tile = Self {
            rules,
            valences: vec![0; count],
            has_refused: vec![false; count],
            is_refused: vec![false; corners.edge_capacity()],
            waiting: Waiting::new(corners.edge_capacity()),
            half_edges: half_edges.into_flattened(),
            met: vec![0; count],
            patches: 0,
            spokes: Vec::new(),
            any_refused: false,
            refusals: Refusals::default(),
            steps: Vec::new(),
            merged: Vec::new(),
            max_cost: 0.0,
            vertices: Vec::new(),
            corners,
        };
        let remembers = !quadrics.is_empty();
        let quadrics = quadrics.into_iter().chain(core::iter::repeat(Quadric::default()));
        let vertex = |(position, quadric)| Vertex { position, quadric };
        tile.vertices = positions.into_iter().zip(quadrics).map(vertex).collect();
        if !remembers {
            tile.remember_faces(&triangles);
        }
        let mut is_free = vec![true; count];
        for t in &triangles {
            let is_own = t.iter().all(|&v| (v as usize) < own);
            for &v in t {
                tile.valences[v as usize] += 1;
                is_free[v as usize] &= is_own;
            }
        }
        for edge in 0..tile.corners.edge_capacity() as u32 {
            let side = tile.corners.of_edge(edge);
            let ends = [tile.corners.vertex(side), tile.corners.target(side)];
            if ends.iter().all(|&v| is_free[v as usize]) {
                tile.queue(edge, 0);
            }
        }
        tile
    }

    /// Gives the vertices the quadrics of the faces and of the boundary as they are.
    fn remember_faces(&mut self, triangles: &[[u32; 3]]) {
        for (face, t) in triangles.iter().enumerate() {
            let [a, b, c] = t.map(|v| self.vertices[v as usize].position);
            let cross = (b - a).cross(c - a);
            let double_area = cross.length();
            if double_area <= 0.0 {
                continue;
            }
            let plane = Quadric::plane(cross, 0.0, 1.0 / (6.0 * double_area));
            for &v in t {
                self.vertices[v as usize].quadric += plane;
            }
            for i in 0..3 {
                if self.rules.border && self.corners.twin(3 * face as u32 + i) == NONE {
                    let ends = [t[i as usize], t[(i as usize + 1) % 3]];
                    let [from, to] = ends.map(|v| self.vertices[v as usize].position);
                    let across = (to - from).cross(cross / double_area);
                    let border = Quadric::plane(across, 0.0, 0.5);
                    for v in ends {
                        self.vertices[v as usize].quadric += border;
                    }
                }
            }
        }
    }

    /// The number of faces that are left, those of others included.
    pub(super) fn faces(&self) -> usize {
        self.corners.faces()
    }

    pub(super) fn triangles(&self) -> impl Iterator<Item = (usize, [u32; 3])> + '_ {
        self.corners.triangles()
    }

    pub(super) fn half_edges(&self, face: usize) -> [u32; 3] {
        [0, 1, 2].map(|i| self.half_edges.get(3 * face + i).copied().unwrap_or_default())
    }

    pub(super) fn position(&self, v: usize) -> DVec3 {
        self.vertices[v].position
    }

    pub(super) fn quadric(&self, v: usize) -> Quadric {
        self.vertices[v].quadric
    }

    /// Collapses edges, the cheapest first, until the goal is reached, nothing is left, or `goes_on`
    /// says no. `done` hears of each collapse with the bucket of it and the number of faces that went.
    pub(super) fn run(
        &mut self,
        goal: Goal,
        goes_on: &mut dyn FnMut(usize, usize) -> bool,
        done: &mut dyn FnMut(usize, u32),
    ) -> bool {
        let (mut turns, mut highest) = (0_usize, 0);
        while self.faces() > goal.faces {
            turns += 1;
            if turns.is_multiple_of(ASKED_EVERY) && !goes_on(self.faces(), self.merged.len()) {
                return false;
            }
            let Some((edge, at)) = self.waiting.pop(goal.end) else { return true };
            let side = self.corners.of_edge(edge);
            if side == NONE {
                continue;
            }
            let ends = [self.corners.vertex(side), self.corners.target(side)];
            if ends.iter().any(|&v| self.valences[v as usize] > MOST_EDGES) {
                self.refuse(edge, ends, Refusal::Valence);
                continue;
            }
            let mut offer = self.offer(side, ends);
            let due = bucket(offer.cost * self.rules.scale);
            if due > at {
                self.waiting.push(edge, due);
                continue;
            }
            let checked = self.gather(&offer, ends).and_then(|()| {
                if self.rules.keep_volume {
                    self.keep_volume(&mut offer);
                    let due = bucket(offer.cost * self.rules.scale);
                    if due > at {
                        return Ok(Some(due));
                    }
                }
                self.check(&offer).map(|()| None)
            });
            match checked {
                Ok(Some(due)) => self.waiting.push(edge, due),
                Ok(None) => {
                    let faces = self.collapse(&offer, ends, at);
                    highest = at.max(highest);
                    done(highest, faces);
                }
                Err(refusal) => self.refuse(edge, ends, refusal),
            }
        }
        true
    }

    /// An edge that does not wait begins to.
    fn queue(&mut self, edge: u32, least: usize) {
        let side = self.corners.of_edge(edge);
        let ends = [self.corners.vertex(side), self.corners.target(side)];
        let cost = self.offer(side, ends).cost;
        self.waiting.push(edge, bucket(cost * self.rules.scale).max(least));
    }

    fn refuse(&mut self, edge: u32, ends: [u32; 2], refusal: Refusal) {
        self.refusals.count(refusal);
        self.any_refused = true;
        self.is_refused[edge as usize] = true;
        ends.into_iter().for_each(|v| self.has_refused[v as usize] = true);
    }

    /// The best place for the two ends of an edge and what it costs, before anything is known of the
    /// faces.
    #[inline]
    fn offer(&self, side: u32, ends: [u32; 2]) -> Offer {
        let [a, b] = ends.map(|v| &self.vertices[v as usize]);
        let half = 0.5 * (b.position - a.position);
        let quadric = a.quadric.joined(&b.quadric, half);
        let made = if self.rules.marginal { a.quadric.constant + b.quadric.constant } else { 0.0 };
        let mut offer = Offer { side, half, quadric, made, x: DVec3::ZERO, cost: 0.0 };
        offer.settle(offer.quadric.minimizer(None));
        offer
    }

    /// Brings the faces of a patch together, and finds out whether its edge may collapse as far as the
    /// other edges matter. The one or two faces that vanish come last.
    fn gather(&mut self, offer: &Offer, ends: [u32; 2]) -> Result<(), Refusal> {
        let Offer { side, half, .. } = *offer;
        let Self { corners, vertices, met, patches, spokes, .. } = self;
        *patches = patches.wrapping_add(1);
        let stamp = *patches;
        let twin = corners.twin(side);
        let origin = vertices[ends[0] as usize].position + half;
        let at = |v: u32| vertices[v as usize].position - origin;
        // The corners of the faces that vanish at each end.
        let vanishing = match twin {
            NONE => [[side, NONE], [next(side), NONE]],
            _ => [[side, next(twin)], [next(side), twin]],
        };
        let apexes = [
            corners.vertex(previous(side)),
            if twin == NONE { NONE } else { corners.vertex(previous(twin)) },
        ];
        spokes.clear();
        let mut common = 0;
        let mut neighbours = [0; 2];
        for (end, own) in [-half, half].into_iter().enumerate() {
            let first = corners.first_at(ends[end]);
            let mut meet = |v: u32| {
                neighbours[end] += 1;
                if end == 0 {
                    met[v as usize] = stamp;
                } else if met[v as usize] == stamp && !apexes.contains(&v) {
                    common += 1;
                }
            };
            let mut corner = first;
            let mut second = at(corners.target(corner));
            if corners.twin(first) == NONE {
                meet(corners.target(corner));
            }
            loop {
                let third_vertex = corners.vertex(previous(corner));
                meet(third_vertex);
                let third = at(third_vertex);
                if !vanishing[end].contains(&corner) {
                    spokes.push(Spoke::new([own, second, third]));
                }
                second = third;
                match corners.turn(corner, first) {
                    Some(next) => corner = next,
                    None => break,
                }
            }
        }
        if common > 0 {
            return Err(Refusal::LinkCondition);
        }
        let at_rim = ends.map(|v| corners.is_at_rim(v));
        if twin != NONE && at_rim == [true; 2] {
            return Err(Refusal::JoinsBoundaries);
        }
        if twin != NONE && at_rim == [false; 2] && neighbours == [3; 2] {
            return Err(Refusal::Tetrahedron);
        }
        for side in [side, twin] {
            if side != NONE && [next(side), previous(side)].iter().all(|&s| corners.twin(s) == NONE)
            {
                return Err(Refusal::LastFace);
            }
        }
        for (apex, [from, to]) in apexes.into_iter().zip([[-half, half], [half, -half]]) {
            if apex != NONE {
                spokes.push(Spoke::new([from, to, at(apex)]));
            }
        }
        Ok(())
    }

    /// Moves the place of an offer to where it keeps the volume under the patch.
    fn keep_volume(&self, offer: &mut Offer) {
        let (mut normal, mut offset, mut size) = (DVec3::ZERO, 0.0, 0.0);
        for Spoke { corners, cross } in &self.spokes {
            normal += *cross;
            offset += cross.dot(corners[0]);
            size += cross.length_squared();
        }
        if normal.length_squared() > 1e-6 * size {
            offer.settle(offer.quadric.minimizer(Some((normal, offset))));
        }
    }

    /// Whether the faces of the patch stand the collapse.
    fn check(&self, offer: &Offer) -> Result<(), Refusal> {
        let x = offer.x;
        if !x.is_finite() || !offer.cost.is_finite() {
            return Err(Refusal::NotFinite);
        }
        let remaining =
            self.spokes.len() - if self.corners.twin(offer.side) == NONE { 1 } else { 2 };
        let mut worst = 1.0_f64;
        let min_cosine = self.rules.min_cosine.unwrap_or(-2.0);
        for Spoke { corners, cross } in &self.spokes[..remaining] {
            let new = (corners[1] - x).cross(corners[2] - x);
            let lengths = cross.length_squared() * new.length_squared();
            let along = cross.dot(new);
            // Compared by the squares, with their signs.
            if along * along.abs() < min_cosine * min_cosine.abs() * lengths {
                return Err(Refusal::NormalTurn);
            }
            worst = worst.min(squared_shape([x, corners[1], corners[2]], new));
        }
        match self.rules.min_shape {
            Some(least) if worst < least * least => {
                let before =
                    self.spokes.iter().map(|spoke| squared_shape(spoke.corners, spoke.cross));
                let is_better = worst > 0.0 && worst >= before.fold(1.0, f64::min);
                if is_better { Ok(()) } else { Err(Refusal::Sliver) }
            }
            _ => Ok(()),
        }
    }

    /// Carries out a collapse; returns how many faces went.
    fn collapse(&mut self, offer: &Offer, [removed, kept]: [u32; 2], at: usize) -> u32 {
        let Offer { side, half, quadric, x, cost, .. } = *offer;
        let half_edge = self.half_edges.get(side as usize).copied();
        let apexes = [side, self.corners.twin(side)]
            .map(|side| if side == NONE { NONE } else { self.corners.vertex(previous(side)) });
        let faces = self.corners.faces();
        let half_edges = &mut self.half_edges;
        self.corners.collapse(side, |stays, across| {
            if !half_edges.is_empty() {
                half_edges[across as usize] = half_edges[stays as usize];
            }
        });
        let faces = (faces - self.corners.faces()) as u32;
        let position = self.vertices[removed as usize].position + half + x;
        self.vertices[kept as usize] = Vertex { position, quadric: quadric.moved_by(x) };
        self.valences[kept as usize] += self.valences[removed as usize];
        self.valences[kept as usize] -= 2 * faces;
        for apex in apexes.into_iter().filter(|&apex| apex != NONE) {
            self.valences[apex as usize] -= 1;
        }
        self.max_cost = self.max_cost.max(cost);
        self.merged.push([removed, kept]);
        if let Some(half_edge) = half_edge {
            self.steps.push(Step { removed, kept, half_edge, faces, position, cost });
        }
        self.has_refused[kept as usize] |= self.has_refused[removed as usize];
        if self.any_refused {
            self.readmit(kept, at);
        }
        faces
    }

    /// Gives the refused edges round a collapse another chance.
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
        // The edges of a crowded vertex would be refused again.
        if !self.has_refused[v as usize] || self.valences[v as usize] > MOST_EDGES {
            return;
        }
        self.has_refused[v as usize] = false;
        let first = self.corners.first_at(v);
        let mut corner = first;
        self.readmit_edge(self.corners.edge(corner), at);
        loop {
            self.readmit_edge(self.corners.edge(previous(corner)), at);
            match self.corners.turn(corner, first) {
                Some(next) => corner = next,
                None => break,
            }
        }
    }

    fn readmit_edge(&mut self, edge: u32, at: usize) {
        if core::mem::take(&mut self.is_refused[edge as usize]) && !self.waiting.contains(edge) {
            self.waiting.push(edge, at);
        }
    }
}

impl Offer {
    /// Takes a place, or the best of the middle and the ends when that is too far.
    #[inline]
    fn settle(&mut self, place: Option<DVec3>) {
        let near = 4.0 * FARTHEST * FARTHEST * self.half.length_squared();
        self.x = match place {
            Some(x) if x.length_squared() <= near => x,
            _ => {
                let places = [DVec3::ZERO, -self.half, self.half];
                let values = places.map(|x| self.quadric.value(x));
                let best =
                    (1..3).fold(0, |best, i| if values[i] < values[best] { i } else { best });
                places[best]
            }
        };
        // So little beyond the quadric that it decides only between edges whose cost is rounding error.
        let squared_length = 4.0 * self.half.length_squared();
        let tie = 1e-12 * squared_length * squared_length;
        self.cost = (self.quadric.value(self.x) - self.made).max(0.0) + tie;
    }
}

/// The square of what [`ShapeGuard`](crate::ShapeGuard) calls the shape of a face.
#[inline]
fn squared_shape([a, b, c]: [DVec3; 3], cross: DVec3) -> f64 {
    let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    // Twice the area of an equilateral triangle is half a squared side times the root of 3.
    let squared_equilateral = sides * sides / 12.0;
    if squared_equilateral > 0.0 { cross.length_squared() / squared_equilateral } else { 0.0 }
}
