//! 1-to-4 subdivision: every edge gets a vertex at its middle, every face becomes four.
//!
//! Topology only; a subdivision scheme such as [`butterfly`](crate::edit::butterfly) determines the positions of the
//! new vertices.
//!
//! ```text
//!            c                         c
//!           / \                       / \
//!          /   \                     / 2 \
//!     h2  /     \  h1              m2 --- m1
//!        /   f   \                 / \ 3 / \
//!       /         \               / 0 \ / 1 \
//!      a --------- b             a --- m0 -- b
//!            h0
//! ```
//!
//! All new indices follow from the old ones by arithmetic, see [`SubdivisionMap`].

use crate::topology::half_edges::{HalfEdge, Topology};
use crate::topology::handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};
use crate::topology::pairing::TopologyError;
use crate::topology::revision::Revision;

/// Maps elements between a mesh and its 1-to-4 subdivision; made by [`Topology::subdivide_1_to_4`].
///
/// With V, E and F the capacities of the arrays before the split: vertices keep their index and
/// edge `e` gets the vertex V + e; its halves are the edges 2e (at the origin of half-edge `2e`)
/// and 2e + 1; face `f` becomes the faces 4f to 4f + 3, the last one in the middle, and gets the
/// inner edges 2E + 3f to 2E + 3f + 2. Removed elements leave removed children.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SubdivisionMap {
    vertices: usize,
    edges: usize,
    faces: usize,
}

/// The origin of a vertex of the subdivided mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum VertexOrigin {
    /// The same vertex.
    Vertex(VertexId),
    /// The middle of this edge.
    Edge(EdgeId),
}

/// The origin of an edge of the subdivided mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum EdgeOrigin {
    /// Half of this edge.
    Edge(EdgeId),
    /// New: it lies inside this face.
    Face(FaceId),
}

/// Maps handles of the coarse mesh to the fine mesh and back. Handles out of range give handles out of range.
impl SubdivisionMap {
    /// The origin of a vertex of the fine mesh.
    #[must_use]
    pub fn vertex_origin(&self, fine: VertexId) -> VertexOrigin {
        match fine.index().checked_sub(self.vertices) {
            None => VertexOrigin::Vertex(fine),
            Some(edge) => VertexOrigin::Edge(EdgeId::from_index(edge)),
        }
    }

    /// The origin of an edge of the fine mesh.
    #[must_use]
    pub fn edge_origin(&self, fine: EdgeId) -> EdgeOrigin {
        match fine.index().checked_sub(2 * self.edges) {
            None => EdgeOrigin::Edge(EdgeId::from_index(fine.index() / 2)),
            Some(inner) => EdgeOrigin::Face(FaceId::from_index(inner / 3)),
        }
    }

    /// The face of the coarse mesh that the face of the fine mesh is a quarter of.
    #[must_use]
    pub fn parent_face(&self, fine: FaceId) -> FaceId {
        FaceId::from_index(fine.index() / 4)
    }

    /// The vertex in the middle of an edge of the coarse mesh.
    #[must_use]
    pub fn midpoint(&self, coarse: EdgeId) -> VertexId {
        VertexId::from_index(self.vertices + coarse.index())
    }

    /// The two halves of an edge of the coarse mesh; the half at the origin of half-edge `2e` first.
    #[must_use]
    pub fn halves(&self, coarse: EdgeId) -> [EdgeId; 2] {
        [0, 1].map(|i| EdgeId::from_index(2 * coarse.index() + i))
    }

    /// The quarters of a face of the coarse mesh: at its first, second and third vertex, and in the middle.
    #[must_use]
    pub fn quarters(&self, coarse: FaceId) -> [FaceId; 4] {
        [0, 1, 2, 3].map(|i| FaceId::from_index(4 * coarse.index() + i))
    }

    /// The side of the middle quarter opposite to a corner of the face. The half-edge belongs to the middle quarter,
    /// its twin to the quarter at the corner.
    fn inner(&self, face: FaceId, corner: usize) -> HalfEdgeId {
        EdgeId::from_index(2 * self.edges + 3 * face.index() + corner).half_edge()
    }

    /// Refuses splits that 32-bit indices cannot address.
    fn check_size(&self) -> Result<(), TopologyError> {
        let half_edges = 4 * self.edges as u64 + 6 * self.faces as u64;
        let vertices = self.vertices as u64 + self.edges as u64;
        let fits = half_edges.max(vertices) < HalfEdgeId::LIMIT as u64;
        if fits { Ok(()) } else { Err(TopologyError::TooLarge) }
    }
}

/// The part of a split half-edge that starts at its origin.
fn first_half(h: HalfEdgeId) -> HalfEdgeId {
    HalfEdgeId::new(2 * h.get() + h.get() % 2)
}

/// The part of a split half-edge that ends at its target: next to the twin's first half.
fn second_half(h: HalfEdgeId) -> HalfEdgeId {
    first_half(h.twin()).twin()
}

impl Topology {
    /// Splits every edge at a new vertex and every face into four, and returns the map between both meshes.
    /// Linear time.
    ///
    /// # Errors
    /// [`TopologyError::TooLarge`] when the split mesh would exceed 32-bit indices.
    pub fn subdivide_1_to_4(&self) -> Result<(Self, SubdivisionMap), TopologyError> {
        let origin = SubdivisionMap {
            vertices: self.vertex_capacity(),
            edges: self.edge_capacity(),
            faces: self.face_capacity(),
        };
        origin.check_size()?;
        let half_edges = 4 * origin.edges + 6 * origin.faces;
        let mut fine = Self {
            half_edges: vec![HalfEdge::UNSET; half_edges],
            vertex_half_edge: Vec::with_capacity(origin.vertices + origin.edges),
            face_half_edge: vec![HalfEdgeId::REMOVED; 4 * origin.faces],
            live_vertices: self.live_vertices + self.live_edges,
            live_edges: 2 * self.live_edges + 3 * self.live_faces,
            live_faces: 4 * self.live_faces,
            revision: Revision::new(),
        };
        let start = |h: HalfEdgeId| if h == HalfEdgeId::REMOVED { h } else { first_half(h) };
        fine.vertex_half_edge.extend(self.vertex_half_edge.iter().map(|h| h.map(start)));
        fine.vertex_half_edge.resize(origin.vertices + origin.edges, Some(HalfEdgeId::REMOVED));
        for edge in self.edges() {
            fine.fill_halves(self, &origin, edge);
        }
        for face in self.faces() {
            fine.fill_quarters(self, &origin, face);
        }
        Ok((fine, origin))
    }

    /// Ends of an edge's halves, the vertex between them, and their places in the boundary loop.
    fn fill_halves(&mut self, coarse: &Self, origin: &SubdivisionMap, edge: EdgeId) {
        let middle = origin.midpoint(edge);
        let [h, twin] = edge.half_edges();
        for side in [h, twin] {
            self.half_edges[first_half(side).index()].target = middle;
            self.half_edges[second_half(side).index()].target = coarse.target(side);
            if coarse.is_exterior(side) {
                self.half_edges[first_half(side).index()].next = second_half(side);
                self.half_edges[second_half(side).index()].next = first_half(coarse.next(side));
            }
        }
        let outgoing = if coarse.is_exterior(twin) { twin } else { h };
        self.vertex_half_edge[middle.index()] = Some(second_half(outgoing));
    }

    /// The four quarters of a face.
    fn fill_quarters(&mut self, coarse: &Self, origin: &SubdivisionMap, face: FaceId) {
        let sides = coarse.face_half_edges(face);
        let quarters = origin.quarters(face);
        let inner = [0, 1, 2].map(|corner| origin.inner(face, corner));
        for corner in 0..3 {
            let (side, before) = (sides[corner], sides[(corner + 2) % 3]);
            self.half_edges[inner[corner].index()].target = origin.midpoint(side.edge());
            self.half_edges[inner[corner].twin().index()].target = origin.midpoint(before.edge());
            let circuit = [first_half(side), inner[corner].twin(), second_half(before)];
            self.fill_face(quarters[corner], circuit);
        }
        // Beginning with the side that leaves the middle of the face's first side.
        self.fill_face(quarters[3], [inner[1], inner[2], inner[0]]);
    }

    fn fill_face(&mut self, face: FaceId, circuit: [HalfEdgeId; 3]) {
        self.face_half_edge[face.index()] = circuit[0];
        for (i, h) in circuit.into_iter().enumerate() {
            let half_edge = &mut self.half_edges[h.index()];
            half_edge.next = circuit[(i + 1) % 3];
            half_edge.face = Some(face);
        }
    }
}
