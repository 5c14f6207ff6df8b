//! Splits: a new vertex on an edge or inside a face.

use crate::edit::links::NoRoom;
use crate::topology::Topology;
use crate::topology::handle::VertexId;
use crate::topology::handle::{EdgeId, FaceId, HalfEdgeId};
use crate::topology::revision::State;

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
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
}

/// An edge split that has been checked; see [`Topology::check_split_edge`].
#[derive(Debug)]
#[must_use = "a checked split does nothing until it is applied"]
pub struct LegalEdgeSplit {
    edge: EdgeId,
    state: State,
}

/// A face split that has been checked; see [`Topology::check_split_face`].
#[derive(Debug)]
#[must_use = "a checked split does nothing until it is applied"]
pub struct LegalFaceSplit {
    face: FaceId,
    state: State,
}

/// The elements that an edge split made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EdgeSplit {
    /// The new vertex.
    pub vertex: VertexId,
    /// The half-edge from the new vertex to the former target of half-edge `2e`. The split edge
    /// itself keeps the other half.
    pub half_edge: HalfEdgeId,
    /// The new faces, to the left and to the right of `half_edge`; `None` beyond the boundary.
    pub faces: [Option<FaceId>; 2],
    /// The new edges from the new vertex to the two apexes, left and right of the split edge.
    pub incident_edges: [Option<EdgeId>; 2],
}

/// The elements that a face split made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FaceSplit {
    /// The new vertex.
    pub vertex: VertexId,
    /// The two new faces. The split face keeps its handle and its first side.
    pub faces: [FaceId; 2],
    /// The new edges from the new vertex to the first, second and third vertex of the split face.
    pub incident_edges: [EdgeId; 3],
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
        self.check_room(1, 3, 2)?;
        Ok(LegalEdgeSplit { edge, state: self.revision.state() })
    }

    /// Checks whether a face may be split.
    ///
    /// # Errors
    /// When the face is not in the mesh or indices run out.
    pub fn check_split_face(&self, face: FaceId) -> Result<LegalFaceSplit, SplitRefusal> {
        if !self.contains_face(face) {
            return Err(SplitRefusal::FaceNotInMesh(face));
        }
        self.check_room(1, 3, 2)?;
        Ok(LegalFaceSplit { face, state: self.revision.state() })
    }

    /// Puts a new vertex on an edge and joins it to the apexes of the edge's faces.
    ///
    /// Existing handles stay valid: the edge keeps the half at the origin of its half-edge `2e`,
    /// and so do its faces.
    ///
    /// # Panics
    /// When the mesh was edited after the split was checked.
    pub fn split_edge(&mut self, split: LegalEdgeSplit) -> EdgeSplit {
        self.advance(split.state);
        let h = split.edge.half_edge();
        let end = self.target(h);
        let anchor = self.vertex_half_edge[end.index()];
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

        // Both faces are quadrilaterals now, until an incident edge cuts each in two.
        let left = self.cut_quadrilateral(far, h, far).unzip();
        let right = self.cut_quadrilateral(h.twin(), far.twin(), far.twin()).unzip();
        // The exterior half-edge of the end stays the same, unless it belongs to the split edge.
        self.anchor_vertex(end, far.twin(), anchor);
        self.anchor_vertex(vertex, far, [h.twin()]);
        EdgeSplit {
            vertex,
            half_edge: far,
            faces: [left.1, right.1],
            incident_edges: [left.0, right.0],
        }
    }

    /// Puts a new vertex inside a face and joins it to the face's vertices.
    ///
    /// # Panics
    /// When the mesh was edited after the split was checked.
    pub fn split_face(&mut self, split: LegalFaceSplit) -> FaceSplit {
        self.advance(split.state);
        let sides = self.face_half_edges(split.face);
        let corners = self.face_vertices(split.face);
        let vertex = self.push_vertex();
        let incident_edges = corners.map(|corner| self.push_edge(vertex, corner));
        let faces = [split.face, self.push_face(sides[1]), self.push_face(sides[2])];
        for (i, (&side, &face)) in sides.iter().zip(&faces).enumerate() {
            let circuit = [side, incident_edges[(i + 1) % 3].twin(), incident_edges[i]];
            self.half_edges[side.index()].face = Some(face);
            self.circuit(circuit);
        }
        self.face_half_edge[split.face.index()] = sides[0];
        self.vertex_half_edge[vertex.index()] = Some(incident_edges[0]);
        FaceSplit {
            vertex,
            faces: [faces[1], faces[2]],
            incident_edges: incident_edges.map(HalfEdgeId::edge),
        }
    }

    /// Cuts a quadrilateral whose circuit begins `last`, `first`, with an edge from the vertex between them to the
    /// opposite corner. `moved` is one of the two and goes to the new face. Does nothing at the boundary.
    fn cut_quadrilateral(
        &mut self,
        first: HalfEdgeId,
        last: HalfEdgeId,
        moved: HalfEdgeId,
    ) -> Option<(EdgeId, FaceId)> {
        let old_face = self.face(first)?;
        let second = self.next(first);
        let third = self.next(second);
        let diagonal = self.push_edge(self.origin(first), self.target(second));
        let new_face = self.push_face(moved);
        self.half_edges[moved.index()].face = Some(new_face);
        self.circuit([first, second, diagonal.twin()]);
        self.circuit([last, diagonal, third]);
        // If the start corner of the old face moved away, the new vertex takes its place.
        if self.face(self.half_edge_of_face(old_face)) != Some(old_face) {
            let on_old = self.face(diagonal) == Some(old_face);
            self.face_half_edge[old_face.index()] = if on_old { diagonal } else { diagonal.twin() };
        }
        Some((diagonal.edge(), new_face))
    }
}
