//! Hole filling with transfer of attributes.

use std::collections::{HashSet, VecDeque};

use mesh_core::fill::{FillOptions, FillReport};
use mesh_core::{FaceId, HalfEdgeId, RemapOf as _, TriMesh, VertexId};

use crate::loaded::Loaded;

impl Loaded {
    /// Fills holes. A new corner takes the attributes of another corner at its vertex. A new face takes the attributes of
    /// the face beside the hole with which it shares its longest edge, and the other new faces those of a new face beside
    /// them: where a hole lies between two labels, each goes on into it. A new vertex takes the attributes of a vertex on
    /// the rim. Copies of a vertex where holes met are joined.
    pub fn fill_holes(&mut self, options: &FillOptions) -> FillReport {
        let (mesh, sources) = (&mut self.mesh, &mut self.provenance);
        let mut any_corner = vec![0; mesh.topology().vertex_capacity()];
        for (face, corners) in mesh.topology().faces().zip(&sources.corner_source) {
            for (v, &corner) in mesh.topology().face_vertices(face).into_iter().zip(corners) {
                any_corner[v.index()] = corner;
            }
        }
        let mut report = mesh.fill_holes(options);
        let topology = mesh.topology();
        any_corner.resize(topology.vertex_capacity(), 0);
        sources.vertex_source.resize(topology.vertex_capacity(), 0);
        sources.face_source.resize(topology.face_capacity(), 0);
        sources.corner_source.resize(topology.face_capacity(), [0; 3]);
        for hole in &report.filled {
            let on_outline = topology.origin(hole.half_edge).index();
            if let Some(vertex) = hole.new_vertex {
                sources.vertex_source[vertex.index()] = sources.vertex_source[on_outline];
                any_corner[vertex.index()] = any_corner[on_outline];
            }
            for (face, beside) in beside(mesh, &hole.faces) {
                sources.face_source[face.index()] = sources.face_source[beside.index()];
            }
            for &face in &hole.faces {
                sources.corner_source[face.index()] =
                    topology.face_vertices(face).map(|v| any_corner[v.index()]);
            }
        }
        if !topology.is_compact() {
            let remap = mesh.compact();
            let mut old = 0..;
            sources.vertex_source.retain(|_| {
                old.next().is_some_and(|v| remap.new_handle(VertexId::new(v)).is_some())
            });
            for vertex in report.filled.iter_mut().flat_map(|hole| &mut hole.new_vertex) {
                *vertex = remap.new_handle(*vertex).unwrap_or(*vertex);
            }
        }
        report
    }
}

/// The new faces of a hole, from its rim inwards, each with the face whose attributes it takes: one outside, or a new face
/// that is earlier in the list.
fn beside(mesh: &TriMesh, faces: &[FaceId]) -> Vec<(FaceId, FaceId)> {
    let topology = mesh.topology();
    let mut inside: HashSet<FaceId> = faces.iter().copied().collect();
    let neighbour = |edge: HalfEdgeId| topology.face(edge.twin());
    let length = |edge: HalfEdgeId| {
        let [a, b] = topology.edge_vertices(edge.edge()).map(|v| mesh.position(v));
        a.distance_squared(b)
    };
    let outside = |&face: &FaceId| {
        let edges = topology.face_half_edges(face).into_iter();
        let rim = edges.filter(|&edge| neighbour(edge).is_some_and(|f| !inside.contains(&f)));
        let longest = rim.max_by(|&a, &b| length(a).total_cmp(&length(b)))?;
        Some((face, neighbour(longest)?))
    };
    let mut found: Vec<(FaceId, FaceId)> = faces.iter().filter_map(outside).collect();
    let mut next: VecDeque<FaceId> = found.iter().map(|&(face, _)| face).collect();
    for face in &next {
        inside.remove(face);
    }
    while let Some(face) = next.pop_front() {
        for other in topology.face_half_edges(face).into_iter().filter_map(neighbour) {
            if inside.remove(&other) {
                found.push((other, face));
                next.push_back(other);
            }
        }
    }
    found
}
