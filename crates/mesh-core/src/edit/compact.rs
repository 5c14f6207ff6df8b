//! Compaction: closes the gaps that edits leave and maps old handles to new ones.

use crate::parallel;
use crate::topology::half_edges::{HalfEdge, Topology};
use crate::topology::handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};

/// Old handles to new ones after [`Topology::compact`]. The order of elements is kept.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Remap {
    vertices: Vec<Option<VertexId>>,
    edges: Vec<Option<EdgeId>>,
    faces: Vec<Option<FaceId>>,
}

/// The map of one kind of element; implemented by [`Remap`] for every handle type.
pub trait RemapOf<H> {
    /// The new handle of an element, `None` when it was removed.
    fn new_handle(&self, old: H) -> Option<H>;
}

impl RemapOf<VertexId> for Remap {
    fn new_handle(&self, old: VertexId) -> Option<VertexId> {
        self.vertices.get(old.index()).copied().flatten()
    }
}

impl RemapOf<EdgeId> for Remap {
    fn new_handle(&self, old: EdgeId) -> Option<EdgeId> {
        self.edges.get(old.index()).copied().flatten()
    }
}

impl RemapOf<HalfEdgeId> for Remap {
    fn new_handle(&self, old: HalfEdgeId) -> Option<HalfEdgeId> {
        let edge = self.new_handle(old.edge())?;
        Some(if old == old.edge().half_edge() { edge.half_edge() } else { edge.half_edge().twin() })
    }
}

impl RemapOf<FaceId> for Remap {
    fn new_handle(&self, old: FaceId) -> Option<FaceId> {
        self.faces.get(old.index()).copied().flatten()
    }
}

impl Topology {
    /// Closes the gaps of removed elements. Elements keep their order. The result maps old handles to new ones,
    /// to carry data of the caller over (`AttributeMap::compact`).
    pub fn compact(&mut self) -> Remap {
        let of_vertices = || numbered(self.vertices(), self.vertex_capacity());
        let of_faces = || numbered(self.faces(), self.face_capacity());
        let of_edges = || numbered(self.edges(), self.edge_capacity());
        let (((vertices, vertices_to), (faces, faces_to)), (edges, edges_to)) =
            parallel::both(|| (of_vertices(), of_faces()), of_edges);
        let remap = Remap { vertices: vertices_to, edges: edges_to, faces: faces_to };
        // Live elements refer only to live elements, so the fallbacks are never taken.
        let half_edge = |h: HalfEdgeId| remap.new_handle(h).unwrap_or(h);
        let vertex = |v: VertexId| remap.new_handle(v).unwrap_or(v);
        let linked = |h: HalfEdgeId| HalfEdge {
            next: half_edge(self.next(h)),
            target: vertex(self.target(h)),
            face: self.face(h).and_then(|f| remap.new_handle(f)),
        };
        let half_edges =
            parallel::collect(2 * edges.len(), |i| linked(edges[i / 2].half_edges()[i % 2]));
        let of_vertex = parallel::collect(vertices.len(), |i| {
            self.half_edge_of_vertex(vertices[i]).map(half_edge)
        });
        let of_face =
            parallel::collect(faces.len(), |i| half_edge(self.half_edge_of_face(faces[i])));
        self.half_edges = half_edges;
        self.vertex_half_edge = of_vertex;
        self.face_half_edge = of_face;
        self.revision.advance();
        remap
    }
}

/// The live elements in order, and their new handles by old index.
fn numbered<H: Handle>(
    there: impl Iterator<Item = H>,
    capacity: usize,
) -> (Vec<H>, Vec<Option<H>>) {
    let there: Vec<H> = there.collect();
    let mut new = vec![None; capacity];
    for (index, old) in there.iter().enumerate() {
        new[old.index()] = Some(H::from_index(index));
    }
    (there, new)
}
