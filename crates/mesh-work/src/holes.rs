//! Hole filling with transfer of attributes.

use mesh_core::fill::{FillOptions, FillReport};
use mesh_core::{FaceId, RemapOf as _, VertexId};

use crate::loaded::Loaded;

impl Loaded {
    /// Fills holes. A new corner takes the attributes of another corner at its vertex, a new face takes the attributes
    /// of a face beside the hole, and a new vertex takes the attributes of a vertex on the rim. Copies of a vertex where
    /// holes met are joined.
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
            let beside = topology.face(hole.half_edge.twin()).map_or(0, FaceId::index);
            let on_outline = topology.origin(hole.half_edge).index();
            if let Some(vertex) = hole.new_vertex {
                sources.vertex_source[vertex.index()] = sources.vertex_source[on_outline];
                any_corner[vertex.index()] = any_corner[on_outline];
            }
            for &face in &hole.faces {
                sources.face_source[face.index()] = sources.face_source[beside];
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
