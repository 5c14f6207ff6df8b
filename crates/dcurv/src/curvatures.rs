//! The curvature of every vertex of a mesh.

use core::ops::Index;

use mesh_core::{Handle, TriMesh, VertexId, VertexMap, parallel};

use crate::area::VertexArea;
use crate::vertex::{VertexCurvature, vertex_curvature};

/// How curvature is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CurvatureOptions {
    /// The area that belongs to a vertex: the divisor of pointwise values.
    pub area: VertexArea,
}

/// The curvature of every vertex of a mesh.
///
/// Each value has the same bits as that of [`vertex_curvature`], which evaluates one vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Curvatures {
    vertices: VertexMap<VertexCurvature>,
}

impl Curvatures {
    /// Evaluates all vertices of a mesh. Removed vertices get what isolated ones have: 0.
    #[must_use]
    pub fn of(mesh: &TriMesh, options: &CurvatureOptions) -> Self {
        // The neighbours of a vertex are read where they are: a table of what the faces and edges
        // contribute would take longer to write and read than it takes to compute them anew.
        let vertices = parallel::collect(mesh.topology().vertex_capacity(), |index| {
            vertex_curvature(mesh, VertexId::from_index(index), options.area)
        });
        Self { vertices: VertexMap::from_vec(vertices) }
    }

    /// The curvature of each vertex, removed ones included.
    #[must_use]
    pub fn vertices(&self) -> &VertexMap<VertexCurvature> {
        &self.vertices
    }

    /// One value per vertex, for example [`VertexCurvature::gaussian`].
    pub fn map<T: Send>(&self, value: impl Fn(&VertexCurvature) -> T + Sync) -> VertexMap<T> {
        let all = self.vertices.as_slice();
        VertexMap::from_vec(parallel::collect(all.len(), |index| value(&all[index])))
    }
}

impl Index<VertexId> for Curvatures {
    type Output = VertexCurvature;

    #[inline]
    fn index(&self, vertex: VertexId) -> &VertexCurvature {
        &self.vertices[vertex]
    }
}
