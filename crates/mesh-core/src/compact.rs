//! Closing the gaps that edits leave, and saying where everything went.

use crate::handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};
use crate::topology::{HalfEdge, Topology};

/// Old handles to new ones after [`Topology::compact`]. The order of elements is kept.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Remap {
    vertices: Vec<Option<VertexId>>,
    edges: Vec<Option<EdgeId>>,
    faces: Vec<Option<FaceId>>,
}

/// Where the elements of one kind went; implemented by [`Remap`] for every handle type.
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
    /// Closes the gaps of removed elements. Elements keep their order; the result tells their new
    /// handles, so that caller-owned data can follow
    /// (`AttributeMap::compact`).
    pub fn compact(&mut self) -> Remap {
        let remap = Remap {
            vertices: renumber(self.vertex_capacity(), |v| self.contains_vertex(v)),
            edges: renumber(self.edge_capacity(), |e| self.contains_edge(e)),
            faces: renumber(self.face_capacity(), |f| self.contains_face(f)),
        };
        // Whatever a live element refers to is live, so the fallbacks are never taken.
        let half_edge = |h: HalfEdgeId| remap.new_handle(h).unwrap_or(h);
        let vertex = |v: VertexId| remap.new_handle(v).unwrap_or(v);
        let linked = |h: HalfEdgeId| HalfEdge {
            next: half_edge(self.next(h)),
            target: vertex(self.target(h)),
            face: self.face(h).and_then(|f| remap.new_handle(f)),
        };
        // No more room than they need: with gaps, iterators do not tell how many will come.
        let mut half_edges = Vec::with_capacity(2 * self.edge_count());
        half_edges.extend(self.half_edges().map(linked));
        let mut of_vertex = Vec::with_capacity(self.vertex_count());
        of_vertex.extend(self.vertices().map(|v| self.half_edge_of_vertex(v).map(half_edge)));
        let mut of_face = Vec::with_capacity(self.face_count());
        of_face.extend(self.faces().map(|f| half_edge(self.half_edge_of_face(f))));
        self.half_edges = half_edges;
        self.vertex_half_edge = of_vertex;
        self.face_half_edge = of_face;
        self.revision.advance();
        remap
    }
}

fn renumber<H: Handle>(capacity: usize, is_live: impl Fn(H) -> bool) -> Vec<Option<H>> {
    let mut coming = 0;
    (0..capacity)
        .map(|index| {
            is_live(H::from_index(index)).then(|| {
                coming += 1;
                H::from_index(coming - 1)
            })
        })
        .collect()
}
