//! Bobenko's discrete Willmore energy (BAR06 sec. 2; Bobenko 2005, A conformal energy for
//! simplicial surfaces).
//!
//! The energy of a vertex is `W(v) = sum of beta(e) over the edges e at v, less 2 pi`. It does not
//! change under Möbius transformations, is never negative, and is 0 exactly where the vertex and
//! its neighbours lie on a sphere and form a convex star on it.
//!
//! An edge with a face on one side only has no `beta`, so a boundary vertex has no energy: it is
//! left out of totals and counts as 0 where every vertex needs a value.

use core::f64::consts::TAU;

use mesh_core::{EdgeId, Handle, TriMesh, VertexId, VertexMap, parallel};

use crate::edge::{edge_intersection_angle, intersection_angles};

/// The Willmore energy of a vertex, a number without unit; 0 for boundary and isolated vertices.
///
/// # Panics
/// When the vertex is out of range for this mesh.
#[must_use]
pub fn willmore_energy(mesh: &TriMesh, vertex: VertexId) -> f64 {
    energy(mesh, vertex, |edge| edge_intersection_angle(mesh, edge))
}

/// The Willmore energies of all vertices, with the same bits as [`willmore_energy`].
#[must_use]
pub fn willmore_energies(mesh: &TriMesh) -> VertexMap<f64> {
    let beta = intersection_angles(mesh);
    VertexMap::from_vec(parallel::collect(mesh.topology().vertex_capacity(), |index| {
        energy(mesh, VertexId::from_index(index), |edge| beta[edge])
    }))
}

/// The Willmore energy of a mesh: the sum over the vertices that do not lie on the boundary.
#[must_use]
pub fn total_willmore_energy(mesh: &TriMesh) -> f64 {
    let energies = willmore_energies(mesh).into_vec();
    parallel::sum(energies.len(), |index| energies[index])
}

/// `sum of beta - 2 pi`, unless an edge has no `beta` or there is no edge.
fn energy(mesh: &TriMesh, vertex: VertexId, beta: impl Fn(EdgeId) -> Option<f64>) -> f64 {
    let topology = mesh.topology();
    if topology.is_isolated_vertex(vertex) {
        return 0.0;
    }
    let angles: Option<f64> = topology.edges_of_vertex(vertex).map(beta).sum();
    angles.map_or(0.0, |sum| sum - TAU)
}
