//! The half-edge structure: connectivity without positions.
//!
//! # Layout
//!
//! Every edge is a pair of half-edges `2e` and `2e + 1` that run in opposite directions, so the twin of a half-edge is
//! one `xor` away and is not stored. A half-edge stores the `next` one around its face, its `target` vertex and its
//! `face`; half-edges without a face are *exterior* and form the boundary loops. Vertices and faces store one half-edge
//! each. A closed mesh takes about 84 bytes per vertex.
//!
//! # Invariants
//!
//! [`Topology::validate`] checks all of them:
//!
//! 1. `next` never leaves its face or boundary loop and starts where the half-edge ends;
//! 2. faces are triangles: three times `next` leads back;
//! 3. at least one side of every edge has a face;
//! 4. the half-edge of a face belongs to that face, and every half-edge with a face is one of its
//!    three;
//! 5. the half-edge of a vertex starts there, and it is the exterior one when the vertex lies on
//!    the boundary;
//! 6. turning around a vertex reaches every half-edge that starts there: the faces at a vertex form one fan;
//! 7. no edge joins a vertex to itself, and no two edges join the same two vertices.
//!
//! # Removed elements
//!
//! Edits leave tombstones inside the arrays, so handles of surviving elements stay valid. Counts and iterators skip
//! them; [`Topology::compact`] closes the gaps and returns the new handles.

use crate::topology::handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};
use crate::topology::revision::Revision;

/// The connectivity of a triangle mesh; see the [module documentation](self).
#[derive(Clone, Debug)]
pub struct Topology {
    pub(crate) half_edges: Vec<HalfEdge>,
    /// An outgoing half-edge, exterior if there is one; `None`: isolated; `REMOVED`: removed.
    pub(crate) vertex_half_edge: Vec<Option<HalfEdgeId>>,
    /// `REMOVED` for removed faces.
    pub(crate) face_half_edge: Vec<HalfEdgeId>,
    pub(crate) live_vertices: usize,
    pub(crate) live_edges: usize,
    pub(crate) live_faces: usize,
    /// Counts edits, so that a token of a check cannot outlive the state that was checked.
    pub(crate) revision: Revision,
}

/// The data of a half-edge. Kept together and next to its twin, since circulating needs all of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfEdge {
    /// The next half-edge around the face or boundary loop; `REMOVED` for removed edges.
    pub(crate) next: HalfEdgeId,
    pub(crate) target: VertexId,
    /// `None`: exterior.
    pub(crate) face: Option<FaceId>,
}

impl HalfEdge {
    /// Not linked to anything yet.
    pub(crate) const UNSET: Self =
        Self { next: HalfEdgeId::REMOVED, target: VertexId::new(0), face: None };
}

/// Sizes, elements and navigation. All methods that take a handle panic, like slice indexing, when
/// the handle is out of range for this mesh.
impl Topology {
    /// The number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.live_vertices
    }

    /// The number of edges.
    #[must_use]
    pub fn edge_count(&self) -> usize {
        self.live_edges
    }

    /// The number of faces.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.live_faces
    }

    /// One more than the largest vertex index in use: the length of an array indexed by vertex.
    #[must_use]
    pub fn vertex_capacity(&self) -> usize {
        self.vertex_half_edge.len()
    }

    /// One more than the largest edge index in use: the length of an array indexed by edge.
    #[must_use]
    pub fn edge_capacity(&self) -> usize {
        self.half_edges.len() / 2
    }

    /// One more than the largest half-edge index in use: the length of an array indexed by
    /// half-edge.
    #[must_use]
    pub fn half_edge_capacity(&self) -> usize {
        self.half_edges.len()
    }

    /// One more than the largest face index in use: the length of an array indexed by face.
    #[must_use]
    pub fn face_capacity(&self) -> usize {
        self.face_half_edge.len()
    }

    /// Whether no removed elements take up space, so that counts equal capacities.
    #[must_use]
    pub fn is_compact(&self) -> bool {
        self.live_vertices == self.vertex_capacity()
            && self.live_edges == self.edge_capacity()
            && self.live_faces == self.face_capacity()
    }

    /// Bytes held by the arrays, capacity slack included.
    #[must_use]
    pub fn heap_bytes(&self) -> usize {
        size_of::<HalfEdge>() * self.half_edges.capacity()
            + size_of::<u32>() * (self.vertex_half_edge.capacity() + self.face_half_edge.capacity())
    }

    /// All vertices, isolated ones included.
    pub fn vertices(&self) -> impl DoubleEndedIterator<Item = VertexId> + Clone + '_ {
        handles(self.vertex_capacity()).filter(|&v| self.contains_vertex(v))
    }

    /// All edges.
    pub fn edges(&self) -> impl DoubleEndedIterator<Item = EdgeId> + Clone + '_ {
        handles(self.edge_capacity()).filter(|&e| self.contains_edge(e))
    }

    /// All half-edges, exterior ones included.
    pub fn half_edges(&self) -> impl DoubleEndedIterator<Item = HalfEdgeId> + Clone + '_ {
        handles(self.half_edge_capacity()).filter(|&h| self.contains_half_edge(h))
    }

    /// All faces.
    pub fn faces(&self) -> impl DoubleEndedIterator<Item = FaceId> + Clone + '_ {
        handles(self.face_capacity()).filter(|&f| self.contains_face(f))
    }

    /// Whether the vertex is in the mesh: in range and not removed.
    #[inline]
    #[must_use]
    pub fn contains_vertex(&self, vertex: VertexId) -> bool {
        self.vertex_half_edge.get(vertex.index()).is_some_and(|&h| h != Some(HalfEdgeId::REMOVED))
    }

    /// Whether the edge is in the mesh: in range and not removed.
    #[inline]
    #[must_use]
    pub fn contains_edge(&self, edge: EdgeId) -> bool {
        self.half_edges.get(2 * edge.index()).is_some_and(|h| h.next != HalfEdgeId::REMOVED)
    }

    /// Whether the half-edge is in the mesh: in range and not removed.
    #[inline]
    #[must_use]
    pub fn contains_half_edge(&self, half_edge: HalfEdgeId) -> bool {
        self.half_edges.get(half_edge.index()).is_some_and(|h| h.next != HalfEdgeId::REMOVED)
    }

    /// Whether the face is in the mesh: in range and not removed.
    #[inline]
    #[must_use]
    pub fn contains_face(&self, face: FaceId) -> bool {
        self.face_half_edge.get(face.index()).is_some_and(|&h| h != HalfEdgeId::REMOVED)
    }

    /// The next half-edge around the same face or boundary loop.
    #[inline]
    #[must_use]
    pub fn next(&self, half_edge: HalfEdgeId) -> HalfEdgeId {
        self.half_edges[half_edge.index()].next
    }

    /// The previous half-edge around the same face or boundary loop.
    ///
    /// Two steps inside a face. On the boundary it circulates around the origin: as many steps as that vertex has
    /// edges.
    #[must_use]
    pub fn previous(&self, half_edge: HalfEdgeId) -> HalfEdgeId {
        if self.is_exterior(half_edge) {
            let mut outgoing = half_edge;
            while self.next(outgoing.twin()) != half_edge {
                outgoing = self.next(outgoing.twin());
            }
            outgoing.twin()
        } else {
            self.next(self.next(half_edge))
        }
    }

    /// The vertex that the half-edge points to.
    #[inline]
    #[must_use]
    pub fn target(&self, half_edge: HalfEdgeId) -> VertexId {
        self.half_edges[half_edge.index()].target
    }

    /// The vertex that the half-edge starts from.
    #[inline]
    #[must_use]
    pub fn origin(&self, half_edge: HalfEdgeId) -> VertexId {
        self.target(half_edge.twin())
    }

    /// The face to the left of the half-edge, `None` for an exterior half-edge.
    #[inline]
    #[must_use]
    pub fn face(&self, half_edge: HalfEdgeId) -> Option<FaceId> {
        self.half_edges[half_edge.index()].face
    }

    /// Whether the half-edge has no face and so runs along a boundary loop.
    #[inline]
    #[must_use]
    pub fn is_exterior(&self, half_edge: HalfEdgeId) -> bool {
        self.face(half_edge).is_none()
    }

    /// The vertex of the half-edge's face that is opposite to it: the apex of the triangle over
    /// it. `None` for an exterior half-edge.
    #[inline]
    #[must_use]
    pub fn apex(&self, half_edge: HalfEdgeId) -> Option<VertexId> {
        self.face(half_edge).map(|_| self.target(self.next(half_edge)))
    }

    /// A half-edge that starts at the vertex, the exterior one when the vertex lies on the
    /// boundary; `None` for an isolated vertex.
    #[inline]
    #[must_use]
    pub fn half_edge_of_vertex(&self, vertex: VertexId) -> Option<HalfEdgeId> {
        self.vertex_half_edge[vertex.index()].filter(|&h| h != HalfEdgeId::REMOVED)
    }

    /// The first half-edge of the face; its vertices are counted from there.
    #[inline]
    #[must_use]
    pub fn half_edge_of_face(&self, face: FaceId) -> HalfEdgeId {
        self.face_half_edge[face.index()]
    }

    /// The three half-edges of a face, counter-clockwise seen from outside.
    #[inline]
    #[must_use]
    pub fn face_half_edges(&self, face: FaceId) -> [HalfEdgeId; 3] {
        let first = self.half_edge_of_face(face);
        let second = self.next(first);
        [first, second, self.next(second)]
    }

    /// The three vertices of a face, counter-clockwise seen from outside.
    #[inline]
    #[must_use]
    pub fn face_vertices(&self, face: FaceId) -> [VertexId; 3] {
        let [first, second, third] = self.face_half_edges(face);
        [self.target(third), self.target(first), self.target(second)]
    }

    /// The two vertices of an edge, in the direction of its half-edge `2e`.
    #[inline]
    #[must_use]
    pub fn edge_vertices(&self, edge: EdgeId) -> [VertexId; 2] {
        let [h, twin] = edge.half_edges();
        [self.target(twin), self.target(h)]
    }

    /// The faces on the two sides of an edge; the face of half-edge `2e` first.
    #[inline]
    #[must_use]
    pub fn edge_faces(&self, edge: EdgeId) -> [Option<FaceId>; 2] {
        let [h, twin] = edge.half_edges();
        [self.face(h), self.face(twin)]
    }

    /// The three edges of a face, in order: first the edge from its first vertex to its second.
    #[inline]
    #[must_use]
    pub fn face_edges(&self, face: FaceId) -> [EdgeId; 3] {
        let [ab, bc, ca] = self.face_half_edges(face);
        [ab.edge(), bc.edge(), ca.edge()]
    }

    /// The faces beyond the three [edges](Self::face_edges) of a face, `None` beyond the boundary.
    #[inline]
    #[must_use]
    pub fn face_neighbours(&self, face: FaceId) -> [Option<FaceId>; 3] {
        let [ab, bc, ca] = self.face_half_edges(face);
        [self.face(ab.twin()), self.face(bc.twin()), self.face(ca.twin())]
    }

    /// Whether the edge has a face on one side only.
    #[inline]
    #[must_use]
    pub fn is_boundary_edge(&self, edge: EdgeId) -> bool {
        edge.half_edges().into_iter().any(|h| self.is_exterior(h))
    }

    /// Whether the vertex lies on the boundary. An isolated vertex does not.
    #[inline]
    #[must_use]
    pub fn is_boundary_vertex(&self, vertex: VertexId) -> bool {
        self.half_edge_of_vertex(vertex).is_some_and(|h| self.is_exterior(h))
    }

    /// Whether the vertex has no edges.
    #[must_use]
    pub fn is_isolated_vertex(&self, vertex: VertexId) -> bool {
        self.half_edge_of_vertex(vertex).is_none()
    }

    /// Whether the mesh has no boundary.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.vertices().all(|v| !self.is_boundary_vertex(v))
    }

    /// The number of edges at the vertex.
    #[must_use]
    pub fn valence(&self, vertex: VertexId) -> usize {
        self.outgoing(vertex).count()
    }

    /// The half-edge from one vertex to another, if an edge joins them. Time: proportional to the valence of
    /// the end with fewer edges.
    #[must_use]
    pub fn find_half_edge(&self, from: VertexId, to: VertexId) -> Option<HalfEdgeId> {
        /// More than the valence of most vertices.
        const FEW: usize = 16;
        let mut leaving = self.outgoing(from);
        let near = leaving.by_ref().take(FEW).find(|&h| self.target(h) == to);
        if near.is_some() {
            return near;
        }
        // The rest alternates with the half-edges of the other end.
        let mut entering = self.outgoing(to);
        loop {
            let h = leaving.next()?;
            if self.target(h) == to {
                return Some(h);
            }
            let back = entering.next()?;
            if self.target(back) == from {
                return Some(back.twin());
            }
        }
    }

    /// The triangles as vertex indices, face after face, for files and renderers.
    ///
    /// Indices count as in [`Topology::vertices`]: after vertices were removed, compact first.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.faces().map(|f| {
            let [a, b, c] = self.face_vertices(f);
            [a.get(), b.get(), c.get()]
        })
    }

    /// The triangles in canonical order: each starts at its smallest vertex, and they are sorted.
    ///
    /// Two meshes over the same vertices are the same oriented surface if and only if these lists are equal.
    #[must_use]
    pub fn canonical_triangles(&self) -> Vec<[u32; 3]> {
        let smallest_first = |[a, b, c]: [u32; 3]| {
            [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or([a, b, c])
        };
        let mut triangles: Vec<[u32; 3]> = self.triangles().map(smallest_first).collect();
        triangles.sort_unstable();
        triangles
    }
}

fn handles<H: Handle>(count: usize) -> impl DoubleEndedIterator<Item = H> + Clone {
    (0..count).map(H::from_index)
}
