//! Checking every invariant of the half-edge structure.

use crate::topology::half_edges::{HalfEdge, Topology};
use crate::topology::handle::{EdgeId, FaceId, HalfEdgeId, VertexId};

/// A broken invariant of [`Topology`] and where it is broken. The numbers refer to the list in the
/// [module documentation](crate::topology) of the half-edge structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BrokenInvariant {
    /// 1: `next` is a removed half-edge or one out of range.
    #[error("the half-edge after {0:?} is not in the mesh")]
    NextNotInMesh(HalfEdgeId),
    /// 1: `next` does not start where the half-edge ends.
    #[error("the half-edge after {0:?} does not start where it ends")]
    NextStartsElsewhere(HalfEdgeId),
    /// 1: `next` belongs to another face.
    #[error("the half-edge after {0:?} belongs to another face")]
    NextOfAnotherFace(HalfEdgeId),
    /// 1: two half-edges have the same `next`.
    #[error("{0:?} follows two half-edges")]
    TwoPredecessors(HalfEdgeId),
    /// 2: a face is not a triangle.
    #[error("{0:?} is not a triangle")]
    NotATriangle(FaceId),
    /// 3: an edge has no face on either side.
    #[error("{0:?} has no face on either side")]
    EdgeWithoutFace(EdgeId),
    /// 4: the half-edge of a face belongs elsewhere, or a half-edge names a face that does not
    /// have it.
    #[error("the half-edges of {0:?} and the face do not agree")]
    FaceHalfEdge(FaceId),
    /// 5: the half-edge of a vertex starts elsewhere or is not in the mesh.
    #[error("the half-edge of {0:?} does not start there")]
    VertexHalfEdge(VertexId),
    /// 5: a boundary vertex does not store its exterior half-edge.
    #[error("{0:?} lies on the boundary but its half-edge is not the exterior one")]
    VertexHalfEdgeNotExterior(VertexId),
    /// 6: the faces at a vertex form more than one fan.
    #[error("the faces at {0:?} form more than one fan")]
    PinchedVertex(VertexId),
    /// 7: an edge joins a vertex to itself.
    #[error("{0:?} joins a vertex to itself")]
    LoopEdge(EdgeId),
    /// 7: two edges join the same two vertices.
    #[error("{0:?} and {1:?} join the same vertices")]
    DoubleEdge(EdgeId, EdgeId),
    /// A live element refers to a removed or non-existent vertex.
    #[error("{0:?} points to a vertex that is not in the mesh")]
    TargetNotInMesh(HalfEdgeId),
    /// The counts of live elements do not match the arrays.
    #[error("the counts of live elements do not match the arrays")]
    Counts,
}

impl Topology {
    /// Checks every invariant; linear time.
    ///
    /// All public ways to make or edit a mesh keep the invariants, so a failure is a defect of
    /// this library, not of the input.
    ///
    /// # Errors
    /// The first broken invariant, with the element that breaks it.
    pub fn validate(&self) -> Result<(), BrokenInvariant> {
        self.validate_counts()?;
        self.validate_half_edges()?;
        self.validate_faces()?;
        self.validate_vertices()?;
        self.validate_simple()
    }

    fn validate_counts(&self) -> Result<(), BrokenInvariant> {
        let is_removed = |h: &HalfEdge| h.next == HalfEdgeId::REMOVED;
        let (pairs, rest) = self.half_edges.as_chunks::<2>();
        let paired = rest.is_empty() && pairs.iter().all(|[h, t]| is_removed(h) == is_removed(t));
        let counted = self.vertices().count() == self.live_vertices
            && self.edges().count() == self.live_edges
            && self.faces().count() == self.live_faces;
        if paired && counted { Ok(()) } else { Err(BrokenInvariant::Counts) }
    }

    fn validate_half_edges(&self) -> Result<(), BrokenInvariant> {
        let mut has_predecessor = vec![false; self.half_edge_capacity()];
        for h in self.half_edges() {
            if !self.contains_vertex(self.target(h)) {
                return Err(BrokenInvariant::TargetNotInMesh(h));
            }
            let next = self.next(h);
            if !self.contains_half_edge(next) {
                return Err(BrokenInvariant::NextNotInMesh(h));
            }
            if self.origin(next) != self.target(h) {
                return Err(BrokenInvariant::NextStartsElsewhere(h));
            }
            if self.face(next) != self.face(h) {
                return Err(BrokenInvariant::NextOfAnotherFace(h));
            }
            if core::mem::replace(&mut has_predecessor[next.index()], true) {
                return Err(BrokenInvariant::TwoPredecessors(next));
            }
        }
        match self.edges().find(|&e| self.edge_faces(e) == [None, None]) {
            Some(edge) => Err(BrokenInvariant::EdgeWithoutFace(edge)),
            None => Ok(()),
        }
    }

    fn validate_faces(&self) -> Result<(), BrokenInvariant> {
        for f in self.faces() {
            let first = self.half_edge_of_face(f);
            if !self.contains_half_edge(first) || self.face(first) != Some(f) {
                return Err(BrokenInvariant::FaceHalfEdge(f));
            }
            let [_, second, third] = self.face_half_edges(f);
            if second == first || third == first || self.next(third) != first {
                return Err(BrokenInvariant::NotATriangle(f));
            }
        }
        // The circuits of the faces are disjoint and have three half-edges each; any further half-edge names a face
        // that it does not belong to.
        for h in self.half_edges() {
            if let Some(f) = self.face(h)
                && !(self.contains_face(f) && self.face_half_edges(f).contains(&h))
            {
                return Err(BrokenInvariant::FaceHalfEdge(f));
            }
        }
        Ok(())
    }

    fn validate_vertices(&self) -> Result<(), BrokenInvariant> {
        let mut valence = vec![0_usize; self.vertex_capacity()];
        let mut on_boundary = vec![false; self.vertex_capacity()];
        for h in self.half_edges() {
            valence[self.origin(h).index()] += 1;
            on_boundary[self.origin(h).index()] |= self.is_exterior(h);
        }
        for v in self.vertices() {
            let Some(h) = self.half_edge_of_vertex(v) else {
                if valence[v.index()] == 0 {
                    continue;
                }
                return Err(BrokenInvariant::VertexHalfEdge(v));
            };
            if !self.contains_half_edge(h) || self.origin(h) != v {
                return Err(BrokenInvariant::VertexHalfEdge(v));
            }
            if on_boundary[v.index()] && !self.is_exterior(h) {
                return Err(BrokenInvariant::VertexHalfEdgeNotExterior(v));
            }
            // Circulating permutes the half-edges at the vertex, so it ends; it misses some if and only if
            // there is another fan.
            if self.outgoing(v).count() != valence[v.index()] {
                return Err(BrokenInvariant::PinchedVertex(v));
            }
        }
        Ok(())
    }

    fn validate_simple(&self) -> Result<(), BrokenInvariant> {
        let mut met: Vec<Option<(VertexId, EdgeId)>> = vec![None; self.vertex_capacity()];
        for v in self.vertices() {
            for h in self.outgoing(v) {
                let neighbour = self.target(h);
                if neighbour == v {
                    return Err(BrokenInvariant::LoopEdge(h.edge()));
                }
                match met[neighbour.index()].replace((v, h.edge())) {
                    Some((from, edge)) if from == v => {
                        return Err(BrokenInvariant::DoubleEdge(edge, h.edge()));
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }
}
