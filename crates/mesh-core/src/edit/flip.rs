//! Edge flip: the common edge of two triangles becomes the other diagonal of their quadrilateral.

use crate::topology::Topology;
use crate::topology::handle::{EdgeId, HalfEdgeId, VertexId};
use crate::topology::revision::State;

/// Why an edge cannot be flipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum FlipRefusal {
    /// The edge is not in the mesh.
    #[error("{0:?} is not in the mesh")]
    NotInMesh(EdgeId),
    /// The edge has a face on one side only.
    #[error("{0:?} is a boundary edge and has no second triangle")]
    Boundary(EdgeId),
    /// An interior end of the edge has only three edges and would be left with two.
    #[error("the flip would leave {0:?} with two edges")]
    ValenceThree(VertexId),
    /// The other diagonal is an edge already.
    #[error("the other diagonal is {0:?} already")]
    DiagonalExists(EdgeId),
}

/// A flip that has been checked; see [`Topology::check_flip`].
#[derive(Debug)]
#[must_use = "a checked flip does nothing until it is applied"]
pub struct LegalFlip {
    half_edge: HalfEdgeId,
    corners: [VertexId; 4],
    state: State,
}

impl LegalFlip {
    /// The edge to be flipped.
    #[must_use]
    pub fn edge(&self) -> EdgeId {
        self.half_edge.edge()
    }

    /// The quadrilateral `[a, b, c, d]`: the edge's half-edge `2e` runs from `a` to `b`, `c` is the
    /// apex to its left and `d` the one to its right. The flipped edge joins `c` and `d`.
    #[must_use]
    pub fn quad(&self) -> [VertexId; 4] {
        self.corners
    }
}

impl Topology {
    /// Checks whether an edge may be flipped.
    ///
    /// Time: the number of edges at the apex with fewer edges.
    ///
    /// # Errors
    /// The reason why the flip would not leave a mesh.
    pub fn check_flip(&self, edge: EdgeId) -> Result<LegalFlip, FlipRefusal> {
        if !self.contains_edge(edge) {
            return Err(FlipRefusal::NotInMesh(edge));
        }
        let [h, twin] = edge.half_edges();
        let (Some(c), Some(d)) = (self.apex(h), self.apex(twin)) else {
            return Err(FlipRefusal::Boundary(edge));
        };
        let [a, b] = self.edge_vertices(edge);
        // A triangle with three interior neighbours surrounds a vertex of valence three. Its link is the triangle
        // (other end, c, d), so the diagonal exists as well; the more specific reason is reported.
        for (vertex, outgoing) in [(a, h), (b, twin)] {
            if self.has_valence_three(outgoing) && !self.is_boundary_vertex(vertex) {
                return Err(FlipRefusal::ValenceThree(vertex));
            }
        }
        if let Some(diagonal) = self.find_half_edge(c, d) {
            return Err(FlipRefusal::DiagonalExists(diagonal.edge()));
        }
        Ok(LegalFlip { half_edge: h, corners: [a, b, c, d], state: self.revision.state() })
    }

    /// Flips an edge. All handles stay valid: the edge keeps its handle and so do the two faces.
    ///
    /// Flipping twice restores the mesh exactly, including the corner at which each of the two faces starts. To that
    /// end the edge turns in the direction that keeps its half-edge `2e` running towards the larger (or the smaller)
    /// vertex, as before.
    ///
    /// # Panics
    /// When the mesh was edited after the flip was checked.
    pub fn flip(&mut self, flip: LegalFlip) {
        self.advance(flip.state);
        let [a, b, c, d] = flip.corners;
        let h = flip.half_edge;
        if (a < b) == (d < c) {
            self.turn_counter_clockwise(h);
        } else {
            self.turn_clockwise(h);
        }
        debug_assert_eq!(self.origin(h) < self.target(h), a < b);
        debug_assert!([c, d].contains(&self.target(h)));
    }

    /// Whether the origin of a half-edge has three edges.
    pub(super) fn has_valence_three(&self, outgoing: HalfEdgeId) -> bool {
        let turn = |h: HalfEdgeId| self.next(h.twin());
        let third = turn(turn(outgoing));
        third != outgoing && turn(third) == outgoing
    }

    /// With `h` from a to b, c to the left and d to the right: turns `h` so that it runs from d to c.
    fn turn_counter_clockwise(&mut self, h: HalfEdgeId) {
        let t = h.twin();
        let (bc, ad) = (self.next(h), self.next(t));
        let (ca, db) = (self.next(bc), self.next(ad));
        let starts = [self.face_start(h), self.face_start(t)];
        self.circuit([h, ca, ad]);
        self.circuit([t, db, bc]);
        self.finish_turn(h, [bc, ad, ca, db], starts);
    }

    /// With `h` from a to b, c to the left and d to the right: turns `h` so that it runs from c to d.
    fn turn_clockwise(&mut self, h: HalfEdgeId) {
        let t = h.twin();
        let (bc, ad) = (self.next(h), self.next(t));
        let (ca, db) = (self.next(bc), self.next(ad));
        let starts = [self.face_start(h), self.face_start(t)];
        self.circuit([h, db, bc]);
        self.circuit([t, ca, ad]);
        self.finish_turn(h, [bc, ad, ca, db], starts);
    }

    /// How many steps after `h` its face starts.
    fn face_start(&self, h: HalfEdgeId) -> usize {
        let Some(face) = self.face(h) else { return 0 };
        let start = self.half_edge_of_face(face);
        if start == h {
            0
        } else if start == self.next(h) {
            1
        } else {
            2
        }
    }

    /// Targets of the turned edge, start corners of its faces, and half-edges of its former ends.
    fn finish_turn(
        &mut self,
        h: HalfEdgeId,
        [bc, ad, ca, db]: [HalfEdgeId; 4],
        starts: [usize; 2],
    ) {
        let t = h.twin();
        for (side, start) in [h, t].into_iter().zip(starts) {
            let circuit = [side, self.next(side), self.next(self.next(side))];
            // The last half-edge of the circuit ends where the turned one begins.
            self.half_edges[side.twin().index()].target = self.target(circuit[2]);
            if let Some(face) = self.face(side) {
                self.face_half_edge[face.index()] = circuit[start];
            }
        }
        let (a, b) = (self.target(ca), self.target(db));
        for (vertex, lost, kept) in [(a, h, ad), (b, t, bc)] {
            let slot = &mut self.vertex_half_edge[vertex.index()];
            if *slot == Some(lost) {
                *slot = Some(kept);
            }
        }
    }
}
