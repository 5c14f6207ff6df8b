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

use mesh_core::{TriMesh, VertexId, VertexMap, parallel};

use crate::intersection::intersection_angle;
use crate::star_block::{BLOCK, StarBlock};

/// The Willmore energy of a vertex, a number without unit; 0 for boundary and isolated vertices.
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

/// The Willmore energies of all vertices, with the same bits as [`willmore_energy`]. For curvatures,
/// too, see [`Curvatures::with_willmore_energies`](crate::Curvatures::with_willmore_energies).
#[must_use]
pub fn willmore_energies(mesh: &TriMesh) -> VertexMap<f64> {
    let count = mesh.topology().vertex_capacity();
    let of_block = |stars: &mut StarBlock, indices| {
        stars.line_up(mesh, indices);
        energies_of(stars, mesh)
    };
    VertexMap::from_vec(parallel::collect_blocks(count, StarBlock::maker(), of_block))
}

/// The energies of the vertices that are lined up, then zeros.
#[inline(always)]
pub(crate) fn energies_of(stars: &mut StarBlock, mesh: &TriMesh) -> [f64; BLOCK] {
    let mut energies = [0.0; BLOCK];
    for (slot, (vertex, energy)) in energies.iter_mut().zip(stars.energies(mesh)) {
        *slot = energy.unwrap_or_else(|| willmore_energy(mesh, vertex));
    }
    energies
}

/// The Willmore energy of a mesh: the sum over the vertices that do not lie on the boundary.
#[must_use]
pub fn total_willmore_energy(mesh: &TriMesh) -> f64 {
    let energies = willmore_energies(mesh).into_vec();
    parallel::sum(energies.len(), |index| energies[index])
}
