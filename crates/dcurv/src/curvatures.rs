//! The curvature of every vertex of a mesh.

use core::iter::zip;
use core::ops::Index;

use mesh_core::{TriMesh, VertexId, VertexMap, parallel};

use crate::area::VertexArea;
use crate::star_batch::{BLOCK, StarBatch};
use crate::vertex::VertexCurvature;
use crate::willmore::energies_of;

/// Options of the evaluation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct CurvatureOptions {
    /// Area of a vertex: the divisor of pointwise values.
    pub area: VertexArea,
}

/// The curvature of every vertex of a mesh.
///
/// Each value has the same bits as [`vertex_curvature`](crate::vertex_curvature), which evaluates one
/// vertex.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Curvatures {
    vertices: VertexMap<VertexCurvature>,
}

impl Curvatures {
    /// Evaluates all vertices of a mesh. Removed vertices have the values of isolated ones.
    #[must_use]
    pub fn of(mesh: &TriMesh, options: &CurvatureOptions) -> Self {
        let (count, scratch) = (mesh.topology().vertex_capacity(), StarBatch::maker());
        let vertices = parallel::collect_blocks(count, scratch, |stars, indices| {
            stars.gather(mesh, indices);
            curvatures_of(stars, mesh, options)
        });
        Self { vertices: VertexMap::from_vec(vertices) }
    }

    /// [`Curvatures::of`] and [`willmore_energies`](crate::willmore_energies) in one pass.
    #[must_use]
    pub fn with_willmore_energies(
        mesh: &TriMesh,
        options: &CurvatureOptions,
    ) -> (Self, VertexMap<f64>) {
        let (count, scratch) = (mesh.topology().vertex_capacity(), StarBatch::maker());
        let (vertices, energies) =
            parallel::collect_block_pairs(count, scratch, |stars: &mut StarBatch, indices| {
                stars.gather(mesh, indices);
                (curvatures_of(stars, mesh, options), energies_of(stars, mesh))
            });
        (Self { vertices: VertexMap::from_vec(vertices) }, VertexMap::from_vec(energies))
    }

    /// The curvature of each vertex, including removed ones.
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

/// The curvatures of the gathered vertices.
#[inline(always)]
fn curvatures_of(
    stars: &mut StarBatch,
    mesh: &TriMesh,
    options: &CurvatureOptions,
) -> [VertexCurvature; BLOCK] {
    let mut values = [VertexCurvature::default(); BLOCK];
    let rows = zip(stars.integrals(mesh, options.area), stars.on_boundary());
    for (value, (integrals, boundary)) in zip(&mut values, rows) {
        *value = VertexCurvature::from_integrals(integrals, boundary);
    }
    values
}

impl Index<VertexId> for Curvatures {
    type Output = VertexCurvature;

    #[inline]
    fn index(&self, vertex: VertexId) -> &VertexCurvature {
        &self.vertices[vertex]
    }
}
