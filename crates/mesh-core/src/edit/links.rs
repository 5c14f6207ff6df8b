//! Shared steps of all edits: new elements, links, and the invariant of boundary vertices.

use crate::topology::half_edges::{HalfEdge, Topology};
use crate::topology::handle::{FaceId, HalfEdgeId, Handle, VertexId};
use crate::topology::revision::State;

/// More elements than 32-bit indices can address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[error("the mesh has as many elements as 32-bit indices can address; compact it first")]
pub struct NoRoom;

impl Topology {
    /// Panics on a token of another state, and counts the edit.
    pub(super) fn advance(&mut self, checked: State) {
        assert_eq!(
            checked,
            self.revision.state(),
            "the mesh was edited after this edit was checked, or another mesh was checked"
        );
        self.revision.advance();
    }

    /// Restores the rule that a boundary vertex stores its exterior half-edge. The candidates are
    /// half-edges that may start at the vertex, including the exterior one if there is one; inside,
    /// the vertex gets `outgoing`.
    pub(super) fn anchor_vertex(
        &mut self,
        vertex: VertexId,
        outgoing: HalfEdgeId,
        candidates: impl IntoIterator<Item = HalfEdgeId>,
    ) {
        let starts_here = |&h: &HalfEdgeId| self.contains_half_edge(h) && self.origin(h) == vertex;
        let exterior = candidates
            .into_iter()
            .chain([outgoing])
            .filter(starts_here)
            .find(|&h| self.is_exterior(h));
        debug_assert_eq!(exterior, {
            self.vertex_half_edge[vertex.index()] = Some(outgoing);
            self.outgoing(vertex).find(|&h| self.is_exterior(h))
        });
        self.vertex_half_edge[vertex.index()] = Some(exterior.unwrap_or(outgoing));
    }

    /// Makes `half_edge` follow `previous`.
    #[inline]
    pub(super) fn link(&mut self, previous: HalfEdgeId, half_edge: HalfEdgeId) {
        self.half_edges[previous.index()].next = half_edge;
    }

    /// Makes three half-edges the circuit of the first one's face.
    pub(super) fn circuit(&mut self, [first, second, third]: [HalfEdgeId; 3]) {
        self.link(first, second);
        self.link(second, third);
        self.link(third, first);
        self.half_edges[second.index()].face = self.face(first);
        self.half_edges[third.index()].face = self.face(first);
    }

    /// Whether a number of further vertices, edges and faces can be addressed.
    pub(super) fn check_room(
        &self,
        vertices: usize,
        edges: usize,
        faces: usize,
    ) -> Result<(), NoRoom> {
        let room = self.vertex_capacity() + vertices < VertexId::LIMIT
            && self.half_edge_capacity() + 2 * edges < HalfEdgeId::LIMIT
            && self.face_capacity() + faces < FaceId::LIMIT;
        if room { Ok(()) } else { Err(NoRoom) }
    }

    pub(super) fn push_vertex(&mut self) -> VertexId {
        let vertex = VertexId::from_index(self.vertex_capacity());
        self.vertex_half_edge.push(None);
        self.live_vertices += 1;
        vertex
    }

    /// A new edge; the half-edge returned runs from `from` to `to`. Not linked to anything yet.
    pub(super) fn push_edge(&mut self, from: VertexId, to: VertexId) -> HalfEdgeId {
        let h = HalfEdgeId::from_index(self.half_edge_capacity());
        self.half_edges.extend([
            HalfEdge { next: h, target: to, face: None },
            HalfEdge { next: h.twin(), target: from, face: None },
        ]);
        self.live_edges += 1;
        h
    }

    pub(super) fn push_face(&mut self, half_edge: HalfEdgeId) -> FaceId {
        let face = FaceId::from_index(self.face_capacity());
        self.face_half_edge.push(half_edge);
        self.live_faces += 1;
        face
    }

    /// A new face with three half-edges that have no face yet.
    pub(super) fn push_circuit(&mut self, circuit: [HalfEdgeId; 3]) -> FaceId {
        let face = self.push_face(circuit[0]);
        self.half_edges[circuit[0].index()].face = Some(face);
        self.circuit(circuit);
        face
    }

    pub(super) fn remove_edge(&mut self, half_edge: HalfEdgeId) {
        for h in half_edge.edge().half_edges() {
            self.half_edges[h.index()].next = HalfEdgeId::REMOVED;
        }
        self.live_edges -= 1;
    }
}
