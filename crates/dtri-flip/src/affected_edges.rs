//! The edges whose gains a flip may change.

use mesh_core::{EdgeId, FaceId, Topology, VertexId};

use crate::cost::Stencil;
use crate::high_valence::{HIGH_VALENCE, has_higher_valence};
use crate::quad::Quad;

/// Collects affected edges. Keeps its arrays between calls.
#[derive(Debug)]
pub(crate) struct AffectedEdges {
    faces: Vec<FaceId>,
    edges: Vec<EdgeId>,
    high_valence: Vec<VertexId>,
    face_stamp: Vec<u32>,
    edge_stamp: Vec<u32>,
    stamp: u32,
}

impl AffectedEdges {
    pub(crate) fn new(topology: &Topology) -> Self {
        Self {
            faces: Vec::new(),
            edges: Vec::new(),
            high_valence: Vec::new(),
            face_stamp: vec![0; topology.face_capacity()],
            edge_stamp: vec![0; topology.edge_capacity()],
            stamp: 0,
        }
    }

    /// The edges whose gain may differ after the flip of `quad`, for a cost with this stencil and a
    /// look-ahead of `steps` further flips.
    ///
    /// These are the edges of the triangles within the stencil around the flipped quadrilateral. At
    /// a corner of [high valence](AffectedEdges::high_valence), only triangles next to the flip are
    /// included.
    pub(crate) fn affected(
        &mut self,
        topology: &Topology,
        quad: &Quad,
        stencil: Stencil,
        steps: usize,
    ) -> &[EdgeId] {
        self.start_over();
        if (stencil, steps) == (Stencil::AdjacentTriangles, 0) {
            self.collect_two_neighbourhood(topology, quad);
            return &self.edges;
        }
        for face in topology.edge_faces(quad.edge).into_iter().flatten() {
            self.add_face(face);
        }
        let adjacent_steps = match stencil {
            Stencil::Triangles => steps,
            Stencil::AdjacentTriangles => steps + 1,
            Stencil::CornerStars => {
                for corner in quad.corners {
                    if has_higher_valence(topology, corner, HIGH_VALENCE) {
                        self.high_valence.push(corner);
                    } else {
                        self.add_star(topology, corner);
                    }
                }
                if !self.high_valence.is_empty() {
                    let sides = quad.sides.into_iter();
                    for face in sides.filter_map(|side| topology.face(side.twin())) {
                        self.add_face(face);
                    }
                }
                steps
            }
        };
        for _ in 0..adjacent_steps {
            self.grow(topology);
        }
        self.collect_edges(topology);
        &self.edges
    }

    /// The corners whose stars the last call of [`AffectedEdges::affected`] left out.
    pub(crate) fn high_valence(&self) -> &[VertexId] {
        &self.high_valence
    }

    /// The edges of the triangles around a vertex.
    pub(crate) fn star(&mut self, topology: &Topology, vertex: VertexId) -> &[EdgeId] {
        self.start_over();
        self.add_star(topology, vertex);
        self.collect_edges(topology);
        &self.edges
    }

    fn add_star(&mut self, topology: &Topology, vertex: VertexId) {
        for face in topology.faces_of_vertex(vertex) {
            self.add_face(face);
        }
    }

    /// The edge, its four sides and the edges of the adjacent triangles: a fast path for the
    /// 2-neighbourhood. On small meshes an edge may occur twice.
    fn collect_two_neighbourhood(&mut self, topology: &Topology, quad: &Quad) {
        self.edges.push(quad.edge);
        for side in quad.sides {
            self.edges.push(side.edge());
            let outer = side.twin();
            if !topology.is_exterior(outer) {
                let next = topology.next(outer);
                self.edges.extend([next.edge(), topology.next(next).edge()]);
            }
        }
    }

    fn start_over(&mut self) {
        self.faces.clear();
        self.edges.clear();
        self.high_valence.clear();
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.face_stamp.fill(0);
            self.edge_stamp.fill(0);
            self.stamp = 1;
        }
    }

    #[inline]
    fn add_face(&mut self, face: FaceId) {
        if core::mem::replace(&mut self.face_stamp[face.index()], self.stamp) != self.stamp {
            self.faces.push(face);
        }
    }

    /// Adds the triangles that share an edge with the triangles found so far.
    fn grow(&mut self, topology: &Topology) {
        for i in 0..self.faces.len() {
            for h in topology.face_half_edges(self.faces[i]) {
                if let Some(face) = topology.face(h.twin()) {
                    self.add_face(face);
                }
            }
        }
    }

    fn collect_edges(&mut self, topology: &Topology) {
        for &face in &self.faces {
            for h in topology.face_half_edges(face) {
                let stamp = &mut self.edge_stamp[h.edge().index()];
                if core::mem::replace(stamp, self.stamp) != self.stamp {
                    self.edges.push(h.edge());
                }
            }
        }
    }
}
