//! Edges whose flip was refused for a reason that lies elsewhere, until that reason goes away.

use mesh_core::edit::FlipRefusal;
use mesh_core::{EdgeId, FaceId, Topology, VertexId};

/// Why a flip that would lower the cost is not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// This vertex has three edges only.
    ValenceThree(VertexId),
    /// The other diagonal is this edge.
    DiagonalExists(EdgeId),
    /// A new face would have no area.
    Flat,
    /// A face would turn too far.
    Fold,
    /// A new triangle would cross this one.
    Intersection(FaceId),
    /// The edge has flipped too often.
    Cycle,
    /// The edge is locked, or cannot flip at all.
    Never,
}

impl From<FlipRefusal> for Refusal {
    fn from(refusal: FlipRefusal) -> Self {
        match refusal {
            FlipRefusal::ValenceThree(vertex) => Self::ValenceThree(vertex),
            FlipRefusal::DiagonalExists(edge) => Self::DiagonalExists(edge),
            _ => Self::Never,
        }
    }
}

/// Lists of waiting edges, one for every vertex, edge and face that an edge may wait for.
///
/// What a refusal depends on may be out of reach of the cost, so that no update would ever try the
/// edge again.
#[derive(Debug)]
pub(crate) struct Waiting {
    /// First node of the list of each vertex, then edge, then face.
    first: Vec<u32>,
    nodes: Vec<Node>,
    free: Vec<u32>,
    /// What each edge waits for at the moment; older nodes of it are void.
    reason_of: Vec<u32>,
    edges_from: usize,
    faces_from: usize,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    edge: EdgeId,
    next: u32,
}

const NONE: u32 = u32::MAX;

impl Waiting {
    pub(crate) fn new(topology: &Topology) -> Self {
        let edges_from = topology.vertex_capacity();
        let faces_from = edges_from + topology.edge_capacity();
        Self {
            first: vec![NONE; faces_from + topology.face_capacity()],
            nodes: Vec::new(),
            free: Vec::new(),
            reason_of: vec![NONE; topology.edge_capacity()],
            edges_from,
            faces_from,
        }
    }

    /// Makes an edge wait until the reason for its refusal has changed.
    pub(crate) fn add(&mut self, edge: EdgeId, refusal: Refusal) {
        let reason = match refusal {
            Refusal::ValenceThree(vertex) => vertex.index(),
            Refusal::DiagonalExists(diagonal) => self.edges_from + diagonal.index(),
            Refusal::Intersection(face) => self.faces_from + face.index(),
            // The shape of the quadrilateral is something that every cost looks at.
            Refusal::Flat | Refusal::Fold | Refusal::Cycle | Refusal::Never => return,
        };
        if core::mem::replace(&mut self.reason_of[edge.index()], reason as u32) == reason as u32 {
            return;
        }
        let node = Node { edge, next: self.first[reason] };
        let place = match self.free.pop() {
            Some(place) => {
                self.nodes[place as usize] = node;
                place
            }
            None => {
                self.nodes.push(node);
                self.nodes.len() as u32 - 1
            }
        };
        self.first[reason] = place;
    }

    /// Moves the edges that waited for a flip of `edge`, for its faces to change or for its two
    /// new ends to get more edges, into `woken`.
    pub(crate) fn wake(&mut self, topology: &Topology, edge: EdgeId, woken: &mut Vec<EdgeId>) {
        if self.nodes.len() == self.free.len() {
            return;
        }
        self.release(self.edges_from + edge.index(), woken);
        for vertex in topology.edge_vertices(edge) {
            self.release(vertex.index(), woken);
        }
        for face in topology.edge_faces(edge).into_iter().flatten() {
            self.release(self.faces_from + face.index(), woken);
        }
    }

    fn release(&mut self, reason: usize, woken: &mut Vec<EdgeId>) {
        let mut place = core::mem::replace(&mut self.first[reason], NONE);
        while place != NONE {
            let Node { edge, next } = self.nodes[place as usize];
            if self.reason_of[edge.index()] == reason as u32 {
                self.reason_of[edge.index()] = NONE;
                woken.push(edge);
            }
            self.free.push(place);
            place = next;
        }
    }
}
