//! Splits: a new vertex on an edge or inside a face.

use crate::handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};
use crate::topology::{HalfEdge, Topology};

/// Why an edge or a face cannot be split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum SplitRefusal {
    /// The edge is not in the mesh.
    #[error("{0:?} is not in the mesh")]
    EdgeNotInMesh(EdgeId),
    /// The face is not in the mesh.
    #[error("{0:?} is not in the mesh")]
    FaceNotInMesh(FaceId),
    /// The arrays are as long as 32-bit indices allow; compacting may make room.
    #[error("the mesh has as many elements as 32-bit indices can address; compact it first")]
    NoRoom,
}

/// An edge split that has been checked; see [`Topology::check_split_edge`].
#[derive(Debug)]
#[must_use = "a checked split does nothing until it is applied"]
pub struct LegalEdgeSplit {
    edge: EdgeId,
    revision: u64,
}

/// A face split that has been checked; see [`Topology::check_split_face`].
#[derive(Debug)]
#[must_use = "a checked split does nothing until it is applied"]
pub struct LegalFaceSplit {
    face: FaceId,
    revision: u64,
}

/// What an edge split made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeSplit {
    /// The new vertex.
    pub vertex: VertexId,
    /// The half-edge from the new vertex to the former target of half-edge `2e`. The split edge
    /// itself keeps the other half.
    pub half_edge: HalfEdgeId,
    /// The new faces, to the left and to the right of `half_edge`; `None` beyond the boundary.
    pub faces: [Option<FaceId>; 2],
    /// The new edges from the new vertex to the two apexes, left and right of the split edge.
    pub spokes: [Option<EdgeId>; 2],
}

/// What a face split made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaceSplit {
    /// The new vertex.
    pub vertex: VertexId,
    /// The two new faces. The split face keeps its handle and its first side.
    pub faces: [FaceId; 2],
    /// The new edges from the new vertex to the first, second and third vertex of the split face.
    pub spokes: [EdgeId; 3],
}

impl Topology {
    /// Checks whether an edge may be split.
    ///
    /// # Errors
    /// When the edge is not in the mesh or indices run out.
    pub fn check_split_edge(&self, edge: EdgeId) -> Result<LegalEdgeSplit, SplitRefusal> {
        if !self.contains_edge(edge) {
            return Err(SplitRefusal::EdgeNotInMesh(edge));
        }
        self.check_room()?;
        Ok(LegalEdgeSplit { edge, revision: self.revision })
    }

    /// Checks whether a face may be split.
    ///
    /// # Errors
    /// When the face is not in the mesh or indices run out.
    pub fn check_split_face(&self, face: FaceId) -> Result<LegalFaceSplit, SplitRefusal> {
        if !self.contains_face(face) {
            return Err(SplitRefusal::FaceNotInMesh(face));
        }
        self.check_room()?;
        Ok(LegalFaceSplit { face, revision: self.revision })
    }

    /// Puts a new vertex on an edge and joins it to the apexes of the edge's faces.
    ///
    /// Existing handles stay valid: the edge keeps the half at the origin of its half-edge `2e`,
    /// and so do its faces.
    ///
    /// # Panics
    /// When the mesh was edited after the split was checked.
    pub fn split_edge(&mut self, split: LegalEdgeSplit) -> EdgeSplit {
        self.advance_revision(split.revision);
        let h = split.edge.half_edge();
        let end = self.target(h);
        let before_twin = self.previous(h.twin());
        let vertex = self.push_vertex();
        // The new half of the edge, from the new vertex to the old end.
        let far = self.push_edge(vertex, end);
        self.half_edges[h.index()].target = vertex;

        let after = self.next(h);
        self.link(h, far);
        self.link(far, after);
        self.link(before_twin, far.twin());
        self.link(far.twin(), h.twin());
        self.half_edges[far.index()].face = self.face(h);
        self.half_edges[far.twin().index()].face = self.face(h.twin());
        self.vertex_half_edge[vertex.index()] = Some(far);

        // Both faces are quadrilaterals now, until a spoke cuts each in two.
        let left = self.cut_quadrilateral(far, h, far).unzip();
        let right = self.cut_quadrilateral(h.twin(), far.twin(), far.twin()).unzip();
        self.anchor_vertex(end, far.twin());
        self.anchor_vertex(vertex, far);
        EdgeSplit { vertex, half_edge: far, faces: [left.1, right.1], spokes: [left.0, right.0] }
    }

    /// Puts a new vertex inside a face and joins it to the face's vertices.
    ///
    /// # Panics
    /// When the mesh was edited after the split was checked.
    pub fn split_face(&mut self, split: LegalFaceSplit) -> FaceSplit {
        self.advance_revision(split.revision);
        let sides = self.face_half_edges(split.face);
        let corners = self.face_vertices(split.face);
        let vertex = self.push_vertex();
        let spokes = corners.map(|corner| self.push_edge(vertex, corner));
        let faces = [split.face, self.push_face(sides[1]), self.push_face(sides[2])];
        for (i, (&side, &face)) in sides.iter().zip(&faces).enumerate() {
            let circuit = [side, spokes[(i + 1) % 3].twin(), spokes[i]];
            self.half_edges[side.index()].face = Some(face);
            self.circuit(circuit);
        }
        self.face_half_edge[split.face.index()] = sides[0];
        self.vertex_half_edge[vertex.index()] = Some(spokes[0]);
        FaceSplit { vertex, faces: [faces[1], faces[2]], spokes: spokes.map(HalfEdgeId::edge) }
    }

    /// Cuts a quadrilateral whose circuit begins `last`, `first`, with an edge from the vertex
    /// between them to the opposite corner. `moved` is one of the two and goes to the new face.
    /// Does nothing outside.
    fn cut_quadrilateral(
        &mut self,
        first: HalfEdgeId,
        last: HalfEdgeId,
        moved: HalfEdgeId,
    ) -> Option<(EdgeId, FaceId)> {
        let old_face = self.face(first)?;
        let second = self.next(first);
        let third = self.next(second);
        let spoke = self.push_edge(self.origin(first), self.target(second));
        let new_face = self.push_face(moved);
        self.half_edges[moved.index()].face = Some(new_face);
        self.circuit([first, second, spoke.twin()]);
        self.circuit([last, spoke, third]);
        // Where the start corner of the old face moved away, the new vertex takes its place.
        if self.face(self.half_edge_of_face(old_face)) != Some(old_face) {
            let on_old = self.face(spoke) == Some(old_face);
            self.face_half_edge[old_face.index()] = if on_old { spoke } else { spoke.twin() };
        }
        Some((spoke.edge(), new_face))
    }

    /// A split adds at most one vertex, three edges and two faces.
    fn check_room(&self) -> Result<(), SplitRefusal> {
        let room = self.vertex_capacity() + 1 < VertexId::LIMIT
            && self.half_edge_capacity() + 6 < HalfEdgeId::LIMIT
            && self.face_capacity() + 2 < FaceId::LIMIT;
        if room { Ok(()) } else { Err(SplitRefusal::NoRoom) }
    }

    fn push_vertex(&mut self) -> VertexId {
        let vertex = VertexId::from_index(self.vertex_capacity());
        self.vertex_half_edge.push(None);
        self.live_vertices += 1;
        vertex
    }

    /// A new edge; the half-edge returned runs from `from` to `to`. Not linked to anything yet.
    fn push_edge(&mut self, from: VertexId, to: VertexId) -> HalfEdgeId {
        let h = HalfEdgeId::from_index(self.half_edge_capacity());
        self.half_edges.extend([
            HalfEdge { next: h, target: to, face: None },
            HalfEdge { next: h.twin(), target: from, face: None },
        ]);
        self.live_edges += 1;
        h
    }

    fn push_face(&mut self, half_edge: HalfEdgeId) -> FaceId {
        let face = FaceId::from_index(self.face_capacity());
        self.face_half_edge.push(half_edge);
        self.live_faces += 1;
        face
    }
}
