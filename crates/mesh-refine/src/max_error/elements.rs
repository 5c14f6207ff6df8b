//! Distances of the original from the vertices, edges and faces of a mesh.

use glam::DVec3;
use mesh_core::{EdgeId, FaceId, Topology, TriMesh, VertexId};
use mesh_metric::Surface;

use crate::block_loop::values_in_turn;

/// The distance of the original from each vertex, from the midpoint of each edge, and from the centroid of each face of
/// a mesh, by index; 0 for elements without a face.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Elements {
    pub(super) of_vertex: Vec<f64>,
    pub(super) of_edge: Vec<f64>,
    pub(super) of_face: Vec<f64>,
}

/// An element of the mesh that has a distance.
#[derive(Clone, Copy)]
enum Element {
    Vertex(VertexId),
    Edge(EdgeId),
    Face(FaceId),
}

/// A distance that was not measured yet.
const UNKNOWN: f64 = -1.0;

/// The number of faces whose elements one thread measures together, and the number for all threads. The limit saves
/// memory.
const FACES: usize = 256;
const AT_ONCE: usize = 64 * FACES;

pub(super) fn is_unknown(distance: f64) -> bool {
    distance < 0.0
}

impl Elements {
    /// The elements of a mesh without any measurement.
    pub(super) fn unknown(topology: &Topology) -> Self {
        Self {
            of_vertex: vec![UNKNOWN; topology.vertex_capacity()],
            of_edge: vec![UNKNOWN; topology.edge_capacity()],
            of_face: vec![UNKNOWN; topology.face_capacity()],
        }
    }

    /// The distances of all elements.
    pub(super) fn distances(&self) -> impl Iterator<Item = f64> + '_ {
        self.of_vertex.iter().chain(&self.of_edge).chain(&self.of_face).copied()
    }

    /// Measures the unknown distances. `faces` are all faces, ordered so that consecutive faces are close in space.
    pub(super) fn ask(&mut self, mesh: &TriMesh, original: &Surface, faces: &[FaceId]) {
        for faces in faces.chunks(AT_ONCE) {
            let found = values_in_turn(faces.len(), FACES, |range| {
                let (elements, points) = self.unknown_of(mesh, &faces[range]);
                let closest = original.closest_to_neighbours(&points).into_iter();
                elements.into_iter().zip(closest.map(|closest| closest.distance)).collect()
            });
            for (element, distance) in found {
                *self.slot(element) = distance;
            }
        }
        // The remaining elements have no face.
        for distances in [&mut self.of_vertex, &mut self.of_edge, &mut self.of_face] {
            distances.iter_mut().filter(|d| is_unknown(**d)).for_each(|d| *d = 0.0);
        }
    }

    /// The elements of some faces whose distance is unknown, each with its point. A vertex or edge is included only
    /// with the one face that is responsible for it.
    fn unknown_of(&self, mesh: &TriMesh, faces: &[FaceId]) -> (Vec<Element>, Vec<DVec3>) {
        let topology = mesh.topology();
        let (mut elements, mut points) = (Vec::new(), Vec::new());
        let mut take = |element: Element, point: DVec3| {
            elements.push(element);
            points.push(point);
        };
        for &face in faces {
            if is_unknown(self.of_face[face.index()]) {
                let [a, b, c] = mesh.triangle(face);
                take(Element::Face(face), a + ((b - a) + (c - a)) / 3.0);
            }
            for side in topology.face_half_edges(face) {
                let (v, edge) = (topology.origin(side), side.edge());
                let first = topology.faces_of_vertex(v).next();
                if is_unknown(self.of_vertex[v.index()]) && first == Some(face) {
                    take(Element::Vertex(v), mesh.position(v));
                }
                let first = topology.edge_faces(edge).into_iter().flatten().next();
                if is_unknown(self.of_edge[edge.index()]) && first == Some(face) {
                    let [p, q] = topology.edge_vertices(edge).map(|v| mesh.position(v));
                    take(Element::Edge(edge), p + 0.5 * (q - p));
                }
            }
        }
        (elements, points)
    }

    fn slot(&mut self, element: Element) -> &mut f64 {
        match element {
            Element::Vertex(v) => &mut self.of_vertex[v.index()],
            Element::Edge(e) => &mut self.of_edge[e.index()],
            Element::Face(f) => &mut self.of_face[f.index()],
        }
    }
}
