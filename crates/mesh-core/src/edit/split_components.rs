//! Splits a mesh into its connected components.

use crate::index::as_u32;
use crate::mesh::{MeshError, TriMesh};
use crate::topology::handle::{FaceId, VertexId};

/// A connected component as a mesh of its own; made by [`TriMesh::split_components`].
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Component {
    /// The mesh. Vertices and faces keep their order, and faces their first corner.
    pub mesh: TriMesh,
    /// Per vertex of the component, the vertex of the whole mesh.
    pub vertex_source: Vec<VertexId>,
    /// Per face of the component, the face of the whole mesh.
    pub face_source: Vec<FaceId>,
}

impl TriMesh {
    /// The connected components as meshes, in the order of
    /// [`Topology::components`](crate::Topology::components): by their smallest vertex. Isolated vertices are
    /// left out. Linear time.
    ///
    /// ```
    /// use mesh_core::TriMesh;
    /// use mesh_shapes::polyhedra;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 5.], [1., 0., 5.], [0., 1., 5.]];
    /// let mesh = TriMesh::from_triangles(&corners, &[[3, 4, 5], [0, 1, 2]])?;
    /// let pieces = mesh.split_components()?;
    /// assert_eq!(pieces.len(), 2);
    /// assert_eq!(pieces[0].face_source[0].get(), 1);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// A position is not finite.
    pub fn split_components(&self) -> Result<Vec<Component>, MeshError> {
        let topology = self.topology();
        let components = topology.components();
        let mut new_index = topology.vertex_map(0_u32);
        let mut parts: Vec<Part> = Vec::new();
        parts.resize_with(components.count, Part::default);
        for (vertex, component) in components.of_vertex.iter() {
            if let Some(component) = component {
                let sources = &mut parts[*component as usize].vertex_source;
                new_index[vertex] = as_u32(sources.len());
                sources.push(vertex);
            }
        }
        for face in topology.faces() {
            let vertices = topology.face_vertices(face);
            if let Some(component) = components.of_vertex[vertices[0]] {
                let part = &mut parts[component as usize];
                part.triangles.push(vertices.map(|v| new_index[v]));
                part.face_source.push(face);
            }
        }
        let piece = |part: Part| {
            let positions: Vec<_> = part.vertex_source.iter().map(|&v| self.position(v)).collect();
            let mesh = Self::from_triangles(&positions, &part.triangles)?;
            let Part { vertex_source, face_source, .. } = part;
            Ok(Component { mesh, vertex_source, face_source })
        };
        parts.into_iter().map(piece).collect()
    }
}

#[derive(Default)]
struct Part {
    vertex_source: Vec<VertexId>,
    face_source: Vec<FaceId>,
    triangles: Vec<[u32; 3]>,
}
