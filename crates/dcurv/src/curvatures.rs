//! The curvature of every vertex of a mesh.

use core::iter::zip;
use core::ops::Index;

use fearless_simd::Level;
use mesh_core::{Handle, TriMesh, VertexId, VertexMap, parallel};

use crate::area::VertexArea;
use crate::star_block::StarBlock;
use crate::vertex::VertexCurvature;

/// Vertices per block: enough for long loops, few enough that a block stays in the first cache.
const BLOCK: usize = 64;

/// How curvature is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct CurvatureOptions {
    /// The area that belongs to a vertex: the divisor of pointwise values.
    pub area: VertexArea,
}

/// The curvature of every vertex of a mesh.
///
/// Each value has the same bits as that of [`vertex_curvature`](crate::vertex_curvature), which
/// evaluates one vertex.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Curvatures {
    vertices: VertexMap<VertexCurvature>,
}

impl Curvatures {
    /// Evaluates all vertices of a mesh. Removed vertices get what isolated ones have: 0.
    #[must_use]
    pub fn of(mesh: &TriMesh, options: &CurvatureOptions) -> Self {
        let topology = mesh.topology();
        let level = Level::new();
        let count = topology.vertex_capacity();
        let scratch = || StarBlock::new(level);
        let vertices = parallel::collect_blocks(count, scratch, |stars, indices| {
            let vertices = indices.map(VertexId::from_index);
            let integrals = stars.integrals(mesh, vertices.clone(), options.area);
            let mut values = [VertexCurvature::default(); BLOCK];
            for ((value, integrals), vertex) in zip(zip(&mut values, integrals), vertices) {
                let boundary = topology.is_boundary_vertex(vertex);
                *value = VertexCurvature::from_integrals(integrals, boundary);
            }
            values
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
