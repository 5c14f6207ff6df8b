//! The patch of a round: the vertices to remove, the edges that may flip, and the parking faces.

use std::collections::VecDeque;

use mesh_core::SplitMix64;
use mesh_core::{
    EdgeId, EdgeMap, FaceId, FaceMap, HalfEdgeId, Handle, TriMesh, VertexId, VertexMap,
};

use crate::cost::FlipCost;
use crate::run::Run;

/// Smallest number of vertices in a patch.
pub(super) const MIN_PATCH: usize = 3;

/// Number of faces that compete to be the outermost one when all vertices are removed.
const FACES_TRIED: usize = 64;

/// The patch of a round.
pub(super) struct Patch {
    /// The vertices to remove, in the order of removal.
    pub(super) vertices: Vec<VertexId>,
    /// The corners of the parking face. Vertices enter and leave over its first side, the gate.
    parking: [VertexId; 3],
    contains: VertexMap<bool>,
    is_parked: VertexMap<bool>,
    /// The parked vertices, as a stack.
    parked: Vec<VertexId>,
    /// Faces for parked vertices, by corners. The n-th vertex goes to the n-th face and splits it into
    /// three, so that no corner gets a high valence.
    slots: Vec<[VertexId; 3]>,
    is_edge: EdgeMap<bool>,
    /// The edges that may flip.
    pub(super) edges: Vec<EdgeId>,
    /// The faces at these edges. Flips of these edges do not change this set.
    pub(super) faces: Vec<FaceId>,
    pub(super) visited: FaceMarks,
    /// The enclosed volume, if the mesh is closed.
    pub(super) volume: Option<f64>,
}

/// Marks on faces that are cleared in constant time.
pub(super) struct FaceMarks {
    stamp_of: FaceMap<u32>,
    stamp: u32,
}

impl FaceMarks {
    /// Clears all marks.
    pub(super) fn clear(&mut self) {
        if self.stamp == u32::MAX {
            self.stamp_of.as_mut_slice().fill(0);
            self.stamp = 0;
        }
        self.stamp += 1;
    }

    /// Marks a face. Returns whether it was unmarked.
    pub(super) fn mark(&mut self, face: FaceId) -> bool {
        let is_new = self.stamp_of[face] != self.stamp;
        self.stamp_of[face] = self.stamp;
        is_new
    }
}

/// The part of the mesh in which a vertex of valence three walks.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Zone {
    /// The faces of the patch.
    Surface,
    /// The parking faces.
    Parking,
}

impl Patch {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        Self {
            vertices: Vec::new(),
            parking: [VertexId::from_index(0); 3],
            contains: topology.vertex_map(false),
            is_parked: topology.vertex_map(false),
            parked: Vec::new(),
            slots: Vec::new(),
            is_edge: topology.edge_map(false),
            edges: Vec::new(),
            faces: Vec::new(),
            visited: FaceMarks { stamp_of: topology.face_map(0), stamp: 0 },
            volume: topology.is_closed().then(|| mesh.volume()),
        }
    }

    /// Chooses a parking face and up to `size` removable vertices around it. Returns whether there are
    /// enough vertices.
    pub(super) fn choose<C: FlipCost>(
        &mut self,
        run: &Run<'_, C>,
        size: usize,
        random: &mut SplitMix64,
    ) -> bool {
        self.clear();
        let topology = run.mesh.topology();
        let faces = topology.face_capacity();
        let mut random_face = || {
            let index = ((random.uniform() * faces as f64) as usize).min(faces.saturating_sub(1));
            Some(FaceId::from_index(index)).filter(|&f| topology.contains_face(f))
        };
        let is_all = size >= topology.vertex_count();
        let tries = if is_all { FACES_TRIED } else { 1 };
        let candidates: Vec<FaceId> = (0..tries).filter_map(|_| random_face()).collect();
        // When all vertices are removed, the parking face decides which side is outside.
        let chosen =
            if is_all { outermost(run.mesh, candidates) } else { candidates.first().copied() };
        let Some(face) = chosen else { return false };
        let sides = topology.face_half_edges(face);
        let Some(gate) = sides.into_iter().find(|h| run.quad(h.edge()).is_some()) else {
            return false;
        };
        self.parking =
            [topology.origin(gate), topology.target(gate), topology.target(topology.next(gate))];
        self.slots.push(self.parking);
        self.collect_vertices(run, size, random);
        self.collect_edges_and_faces(run.mesh);
        self.vertices.len() >= MIN_PATCH
    }

    /// Collects the removable vertices around the parking face, ring by ring, and shuffles them.
    fn collect_vertices<C: FlipCost>(
        &mut self,
        run: &Run<'_, C>,
        size: usize,
        random: &mut SplitMix64,
    ) {
        let topology = run.mesh.topology();
        let mut queue: VecDeque<VertexId> = self.parking.into();
        'all: while let Some(v) = queue.pop_front() {
            for w in topology.one_ring(v) {
                if self.contains[w] || self.parking.contains(&w) || !is_removable(run, w) {
                    continue;
                }
                if self.vertices.len() >= size {
                    break 'all;
                }
                self.contains[w] = true;
                self.vertices.push(w);
                queue.push_back(w);
            }
        }
        for last in (1..self.vertices.len()).rev() {
            let other = (random.uniform() * (last + 1) as f64) as usize;
            self.vertices.swap(last, other.min(last));
        }
        // A closed surface needs a fourth vertex.
        if self.vertices.len() + 3 >= topology.vertex_count()
            && let Some(v) = self.vertices.pop()
        {
            self.contains[v] = false;
        }
    }

    fn collect_edges_and_faces(&mut self, mesh: &TriMesh) {
        let topology = mesh.topology();
        let [a, b, c] = self.parking;
        let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| topology.find_half_edge(from, to));
        let incident = self.vertices.iter().flat_map(|&v| topology.edges_of_vertex(v));
        for edge in incident.chain(sides.into_iter().flatten().map(HalfEdgeId::edge)) {
            if !self.is_edge[edge] {
                self.is_edge[edge] = true;
                self.edges.push(edge);
            }
        }
        self.visited.clear();
        for &edge in &self.edges {
            for face in topology.edge_faces(edge).into_iter().flatten() {
                if self.visited.mark(face) {
                    self.faces.push(face);
                }
            }
        }
    }

    fn clear(&mut self) {
        self.vertices.drain(..).for_each(|v| self.contains[v] = false);
        self.edges.drain(..).for_each(|e| self.is_edge[e] = false);
        self.parked.drain(..).for_each(|v| self.is_parked[v] = false);
        self.slots.clear();
        self.faces.clear();
    }

    /// Whether an edge may flip now. Edges of parked vertices and of the parking face may not.
    pub(super) fn allows_flip(&self, mesh: &TriMesh, edge: EdgeId) -> bool {
        if !self.is_edge[edge] {
            return false;
        }
        let ends = mesh.topology().edge_vertices(edge);
        self.parked.is_empty()
            || !(ends.iter().any(|&v| self.is_parked[v])
                || ends.iter().all(|v| self.parking.contains(v)))
    }

    /// Whether a vertex may cross an edge while it walks in this zone.
    pub(super) fn allows_crossing(&self, mesh: &TriMesh, edge: EdgeId, zone: Zone) -> bool {
        if zone == Zone::Surface {
            return self.allows_flip(mesh, edge);
        }
        let ends = mesh.topology().edge_vertices(edge);
        ends.iter().any(|&v| self.is_parked[v])
            && ends.iter().all(|v| self.is_parked[*v] || self.parking.contains(v))
    }

    /// The gate as a half-edge of the parking face.
    pub(super) fn gate(&self, mesh: &TriMesh) -> Option<HalfEdgeId> {
        mesh.topology().find_half_edge(self.parking[0], self.parking[1])
    }

    /// The face for the next vertex to park.
    pub(super) fn next_slot(&self) -> Option<[VertexId; 3]> {
        self.slots.get(self.parked.len()).copied()
    }

    /// Records that a vertex was parked in the face with these corners.
    pub(super) fn park(&mut self, v: VertexId, [a, b, c]: [VertexId; 3]) {
        self.slots.extend([[a, b, v], [b, c, v], [c, a, v]]);
        self.parked.push(v);
        self.is_parked[v] = true;
    }

    /// Whether a vertex of the patch is on the surface now.
    pub(super) fn may_relocate(&self, v: VertexId) -> bool {
        self.contains[v] && !self.is_parked[v]
    }

    /// Takes the vertex that was parked last.
    pub(super) fn unpark(&mut self) -> Option<VertexId> {
        let v = self.parked.pop()?;
        self.is_parked[v] = false;
        self.slots.truncate(3 * self.parked.len() + 1);
        Some(v)
    }
}

/// The candidate with the fewest vertices in front of it; among equal ones, the one with the smallest perimeter.
fn outermost(mesh: &TriMesh, candidates: Vec<FaceId>) -> Option<FaceId> {
    let rank = |&f: &FaceId| (vertices_in_front(mesh, f), perimeter(mesh, f));
    candidates.into_iter().min_by(|p, q| {
        let ((n, p), (m, q)) = (rank(p), rank(q));
        n.cmp(&m).then(p.total_cmp(&q))
    })
}

/// Whether a vertex may be removed: none of its edges is a boundary edge or locked.
fn is_removable<C: FlipCost>(run: &Run<'_, C>, v: VertexId) -> bool {
    run.mesh.topology().edges_of_vertex(v).all(|e| run.quad(e).is_some())
}

fn vertices_in_front(mesh: &TriMesh, face: FaceId) -> usize {
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
