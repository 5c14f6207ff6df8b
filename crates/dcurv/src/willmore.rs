//! Bobenko's discrete Willmore energy (BAR06 sec. 2; Bobenko 2005, A conformal energy for
//! simplicial surfaces).
//!
//! The energy of a vertex is `W(v) = sum of beta(e) over the edges e at v, minus 2 pi`. It is invariant
//! under Möbius transformations and never negative. It is 0 exactly if the vertex and its neighbours lie
//! on a sphere and form a convex star on it.
//!
//! A boundary edge has no `beta`, so a boundary vertex has no energy: totals omit it, and its value is 0.

use core::f64::consts::TAU;

use mesh_core::{TriMesh, VertexId, VertexMap, parallel};

use crate::circumcircle_angle::intersection_angle;
use crate::star_batch::{BLOCK, StarBatch};

/// The Willmore energy of a vertex, without unit; 0 for boundary and isolated vertices.
///
/// # Panics
/// When the vertex is out of range for this mesh.
#[must_use]
pub fn willmore_energy(mesh: &TriMesh, vertex: VertexId) -> f64 {
    let topology = mesh.topology();
    let mut ring = topology.one_ring(vertex).map(|v| mesh.position(v));
    if topology.is_boundary_vertex(vertex) {
        return 0.0;
    }
    let (Some(first), Some(second)) = (ring.next(), ring.next()) else { return 0.0 };
    let center = mesh.position(vertex);
    let (mut sum, mut left, mut at) = (0.0, first, second);
    for right in ring.chain([first, second]) {
        sum += intersection_angle(center, at, left, right);
        (left, at) = (at, right);
    }
    sum - TAU
}

/// The Willmore energies of all vertices, with the same bits as [`willmore_energy`]. Together with
/// curvatures, see [`Curvatures::with_willmore_energies`](crate::Curvatures::with_willmore_energies).
#[must_use]
pub fn willmore_energies(mesh: &TriMesh) -> VertexMap<f64> {
    let count = mesh.topology().vertex_capacity();
    let of_block = |stars: &mut StarBatch, indices| {
        stars.gather(mesh, indices);
        energies_of(stars, mesh)
    };
    VertexMap::from_vec(parallel::collect_blocks(count, StarBatch::maker(), of_block))
}

/// The energies of the gathered vertices, then zeros.
#[inline(always)]
pub(crate) fn energies_of(stars: &mut StarBatch, mesh: &TriMesh) -> [f64; BLOCK] {
    let mut energies = [0.0; BLOCK];
    for (slot, (vertex, energy)) in energies.iter_mut().zip(stars.energies(mesh)) {
        *slot = energy.unwrap_or_else(|| willmore_energy(mesh, vertex));
    }
    energies
}

/// The Willmore energy of a mesh: the sum over interior vertices.
#[must_use]
pub fn total_willmore_energy(mesh: &TriMesh) -> f64 {
    let energies = willmore_energies(mesh).into_vec();
    parallel::sum(energies.len(), |index| energies[index])
}
