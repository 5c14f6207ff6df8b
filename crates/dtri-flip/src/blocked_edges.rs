//! Edges whose flip was rejected because of another element, until that element changes.
//!
//! Example: an edge cannot flip because the other diagonal exists. When that diagonal flips, the
//! edge returns to the queue. The cost need not depend on that diagonal, so the update of gains would
//! not find the edge.

use mesh_core::edit::FlipRefusal;
use mesh_core::{EdgeId, FaceId, Topology, VertexId, as_u32};

use crate::shape::ShapeViolation;

/// Why a flip that would lower the cost is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rejection {
    /// This vertex has valence three.
    ValenceThree(VertexId),
    /// The other diagonal exists: this edge.
    DiagonalExists(EdgeId),
    /// A new face would be degenerate.
    Flat,
    /// A face would turn by more than the limit.
    Fold,
    /// A new face would be a sliver.
    Sliver,
    /// The quadrilateral is not convex.
    NotConvex,
    /// A new face would cross this face.
    Intersection(FaceId),
    /// The edge has reached the limit of flips per edge.
    Cycle,
    /// The edge is locked, or cannot flip at all.
    Never,
}

impl From<FlipRefusal> for Rejection {
    fn from(refusal: FlipRefusal) -> Self {
        match refusal {
            FlipRefusal::ValenceThree(vertex) => Self::ValenceThree(vertex),
            FlipRefusal::DiagonalExists(edge) => Self::DiagonalExists(edge),
            _ => Self::Never,
        }
    }
}

impl From<ShapeViolation> for Rejection {
    fn from(violation: ShapeViolation) -> Self {
        match violation {
            ShapeViolation::NotConvex => Self::NotConvex,
            ShapeViolation::Fold => Self::Fold,
            ShapeViolation::Sliver => Self::Sliver,
        }
    }
}

/// Linked lists of blocked edges, one list per vertex, edge and face that may block.
#[derive(Debug)]
pub(crate) struct BlockedEdges {
    /// First node of each list: vertices first, then edges, then faces.
    first: Vec<u32>,
    nodes: Vec<Node>,
    free: Vec<u32>,
    /// The list that each edge is in now. Nodes of the edge in other lists are void.
    blocker_of: Vec<u32>,
    edges_from: usize,
    faces_from: usize,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    edge: EdgeId,
    next: u32,
}

const NONE: u32 = u32::MAX;

impl BlockedEdges {
    pub(crate) fn new(topology: &Topology) -> Self {
        let edges_from = topology.vertex_capacity();
        let faces_from = edges_from + topology.edge_capacity();
        Self {
            first: vec![NONE; faces_from + topology.face_capacity()],
            nodes: Vec::new(),
            free: Vec::new(),
            blocker_of: vec![NONE; topology.edge_capacity()],
            edges_from,
            faces_from,
        }
    }

    /// Blocks an edge until the cause of its rejection has changed.
    pub(crate) fn add(&mut self, edge: EdgeId, rejection: Rejection) {
        let blocker = match rejection {
            Rejection::ValenceThree(vertex) => vertex.index(),
            Rejection::DiagonalExists(diagonal) => self.edges_from + diagonal.index(),
            Rejection::Intersection(face) => self.faces_from + face.index(),
            // Every cost depends on the shape of the quadrilateral, so its changes requeue the edge.
            Rejection::Flat
            | Rejection::Fold
            | Rejection::Sliver
            | Rejection::NotConvex
            | Rejection::Cycle
            | Rejection::Never => return,
        };
        if core::mem::replace(&mut self.blocker_of[edge.index()], as_u32(blocker))
            == as_u32(blocker)
        {
            return;
        }
        let node = Node { edge, next: self.first[blocker] };
        let place = match self.free.pop() {
            Some(place) => {
                self.nodes[place as usize] = node;
                place
            }
            None => {
                self.nodes.push(node);
                as_u32(self.nodes.len()) - 1
            }
        };
        self.first[blocker] = place;
    }

    /// Appends to `released` the edges that were blocked by the edge just flipped, by its faces or by
    /// its two new end vertices.
    pub(crate) fn release_around(
        &mut self,
        topology: &Topology,
        edge: EdgeId,
        released: &mut Vec<EdgeId>,
    ) {
        if self.nodes.len() == self.free.len() {
            return;
        }
        self.release(self.edges_from + edge.index(), released);
        for vertex in topology.edge_vertices(edge) {
            self.release(vertex.index(), released);
        }
        for face in topology.edge_faces(edge).into_iter().flatten() {
            self.release(self.faces_from + face.index(), released);
        }
    }

    fn release(&mut self, blocker: usize, released: &mut Vec<EdgeId>) {
        let mut place = core::mem::replace(&mut self.first[blocker], NONE);
        while place != NONE {
            let Node { edge, next } = self.nodes[place as usize];
            if self.blocker_of[edge.index()] == as_u32(blocker) {
                self.blocker_of[edge.index()] = NONE;
                released.push(edge);
            }
            self.free.push(place);
            place = next;
        }
    }
}
