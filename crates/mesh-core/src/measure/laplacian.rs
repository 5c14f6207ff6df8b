//! The cotangent Laplacian, as the entries of a sparse matrix.
//!
//! For values `f` at the vertices, linear on every face,
//!
//! `(L f)_i = 1/2 sum over the edges (i, j) of (cot alpha + cot beta) (f_j - f_i)`
//!
//! with the angles alpha and beta opposite to the edge in its two faces, or in its one face at the
//! boundary (which stands for a derivative of 0 across the boundary): Pinkall and Polthier 1993,
//! Computing discrete minimal surfaces and their conjugates, eq. 5. `L` is symmetric, its rows add
//! up to 0, and it is negative semidefinite. It is *integrated* over the vertex: for a pointwise
//! Laplacian, divide row `i` by the area that belongs to vertex `i`. Applied to the positions it
//! gives `-2 H n` times that area, for a surface with mean curvature `H` (positive where convex) and
//! outward unit normal `n`. The entries have no unit.

use glam::DVec3;

use crate::attribute::EdgeMap;
use crate::mesh::TriMesh;
use crate::parallel;
use crate::topology::handle::{EdgeId, Handle, VertexId};

/// An entry of a sparse matrix with a row and a column per vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Triplet {
    /// The vertex that the row belongs to.
    pub row: VertexId,
    /// The vertex that the column belongs to.
    pub column: VertexId,
    /// The entry.
    pub value: f64,
}

impl TriMesh {
    /// The cotangent weight of an edge, `(cot alpha + cot beta) / 2`. Negative where the angles
    /// opposite to the edge add up to more than pi. A face without area adds nothing.
    ///
    /// # Panics
    /// When the edge is out of range for this mesh.
    #[must_use]
    pub fn cotangent_weight(&self, edge: EdgeId) -> f64 {
        let [from, to] = self.segment(edge);
        let apexes = edge.half_edges().map(|h| self.topology().apex(h));
        let cotangents = apexes.into_iter().flatten().map(|apex| {
            let apex = self.position(apex);
            cotangent(from - apex, to - apex)
        });
        0.5 * cotangents.sum::<f64>()
    }

    /// [`cotangent_weight`](Self::cotangent_weight) of all edges; 0 for removed ones.
    #[must_use]
    pub fn cotangent_weights(&self) -> EdgeMap<f64> {
        EdgeMap::from_vec(parallel::collect(self.topology().edge_capacity(), |index| {
            let edge = EdgeId::from_index(index);
            if self.topology().contains_edge(edge) { self.cotangent_weight(edge) } else { 0.0 }
        }))
    }

    /// The [cotangent Laplacian](crate::laplacian): one entry for every vertex with edges and two for every edge, row
    /// after row, each row in order of its columns. Rows and columns are indexed like arrays per vertex: after vertices
    /// were removed, compact first.
    ///
    /// ```
    /// use mesh_core::TriMesh;
    /// use mesh_shapes::polyhedra;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let mesh = TriMesh::from_soup(&polyhedra::octahedron())?;
    /// let laplacian = mesh.cotangent_laplacian();
    /// assert_eq!(laplacian.len(), 6 + 2 * 12);
    /// let row_sum: f64 = laplacian[..5].iter().map(|entry| entry.value).sum();
    /// assert!(row_sum.abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn cotangent_laplacian(&self) -> Vec<Triplet> {
        let topology = self.topology();
        let weights = self.cotangent_weights();
        let mut entries = Vec::with_capacity(topology.vertex_count() + 2 * topology.edge_count());
        let mut row: Vec<(VertexId, f64)> = Vec::new();
        for vertex in topology.vertices().filter(|&v| !topology.is_isolated_vertex(v)) {
            row.clear();
            row.push((vertex, 0.0));
            row.extend(topology.outgoing(vertex).map(|h| (topology.target(h), weights[h.edge()])));
            row[0].1 = -row[1..].iter().map(|entry| entry.1).sum::<f64>();
            row.sort_unstable_by_key(|entry| entry.0);
            entries.extend(row.iter().map(|&(column, value)| Triplet {
                row: vertex,
                column,
                value,
            }));
        }
        entries
    }
}

/// The cotangent of the angle between two vectors; 0 where they are parallel.
fn cotangent(u: DVec3, v: DVec3) -> f64 {
    let sine = u.cross(v).length();
    if sine > 0.0 { u.dot(v) / sine } else { 0.0 }
}
