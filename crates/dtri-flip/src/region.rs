//! The edges whose flips look at the triangles that a flip has changed.

use mesh_core::{EdgeId, FaceId, Topology, VertexId};

use crate::cost::Reach;
use crate::crowded::{CROWDED, has_more_faces};
use crate::quad::Quad;

/// Collects edges; keeps its arrays between calls.
#[derive(Debug)]
pub(crate) struct Region {
    faces: Vec<FaceId>,
    edges: Vec<EdgeId>,
    crowded: Vec<VertexId>,
    face_stamp: Vec<u32>,
    edge_stamp: Vec<u32>,
    stamp: u32,
}

impl Region {
    pub(crate) fn new(topology: &Topology) -> Self {
        Self {
            faces: Vec::new(),
            edges: Vec::new(),
            crowded: Vec::new(),
            face_stamp: vec![0; topology.face_capacity()],
            edge_stamp: vec![0; topology.edge_capacity()],
            stamp: 0,
        }
    }

    /// The edges whose change may differ now that `quad` has been flipped, when a change looks as
    /// far as `reach` and `steps` more flips, each at a side of the one before, are looked ahead.
    ///
    /// A change sees a triangle when the triangle is within `reach` of its own two. Seen from the
    /// flip, these are the edges of the triangles within `reach` of the flipped quadrilateral. Of the
    /// star of a [crowded](Region::crowded) corner, only the triangles next to the flip are among
    /// them.
    pub(crate) fn affected(
        &mut self,
        topology: &Topology,
        quad: &Quad,
        reach: Reach,
        steps: usize,
    ) -> &[EdgeId] {
        self.start_over();
        if (reach, steps) == (Reach::AdjacentTriangles, 0) {
            self.collect_two_neighbourhood(topology, quad);
            return &self.edges;
        }
        for face in topology.edge_faces(quad.edge).into_iter().flatten() {
            self.add_face(face);
        }
        let adjacent_steps = match reach {
            Reach::Triangles => steps,
            Reach::AdjacentTriangles => steps + 1,
            Reach::CornerStars => {
                for corner in quad.corners {
                    if has_more_faces(topology, corner, CROWDED) {
                        self.crowded.push(corner);
                    } else {
                        self.add_star(topology, corner);
                    }
                }
                if !self.crowded.is_empty() {
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

    /// The corners of the quadrilateral of the last [`Region::affected`] that have so many triangles
    /// that these were left out.
    pub(crate) fn crowded(&self) -> &[VertexId] {
        &self.crowded
    }

    /// The edges of the triangles round a vertex.
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

    /// The edge, its four sides and the edges of the triangles beyond these: what the general way
    /// finds, without its look into tables. On small meshes an edge may come twice.
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
        self.crowded.clear();
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

    /// Adds the triangles that share an edge with those found so far.
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
