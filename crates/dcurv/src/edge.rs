//! Curvature of the edges of a mesh.

use core::iter::zip;

use fearless_simd::Level;
use glam::DVec3;
use mesh_core::{EdgeId, EdgeMap, Handle, TriMesh, parallel};

use crate::circumcircle_angle::{intersection_angle, intersection_angles_of};
use crate::dihedral::dihedral_angle;
use crate::quantity::Integral;

/// The signed dihedral angle of an edge, in radians; see [`dihedral_angle`]. `None` for a boundary
/// edge.
///
/// # Panics
/// When the edge is out of range for this mesh.
#[inline]
#[must_use]
pub fn edge_dihedral_angle(mesh: &TriMesh, edge: EdgeId) -> Option<f64> {
    edge_diamond(mesh, edge).map(|[a, b, c, d]| dihedral_angle(a, b, c, d))
}

/// The integrated mean curvature of an edge, `1/2 |e| beta`, from a cylinder that blends its faces
/// (DHKL01 sec. 2), in model units. Each end gets half of it. `None` for a boundary edge.
///
/// # Panics
/// When the edge is out of range for this mesh.
#[inline]
#[must_use]
pub fn edge_mean_curvature(mesh: &TriMesh, edge: EdgeId) -> Option<Integral> {
    let [a, b] = mesh.segment(edge);
    edge_dihedral_angle(mesh, edge).map(|beta| Integral::new(0.5 * a.distance(b) * beta))
}

/// Bobenko's intersection angle of the circumcircles at an edge, in radians; see
/// [`intersection_angle`]. `None` for a boundary edge.
///
/// # Panics
/// When the edge is out of range for this mesh.
#[inline]
#[must_use]
pub fn edge_intersection_angle(mesh: &TriMesh, edge: EdgeId) -> Option<f64> {
    edge_diamond(mesh, edge).map(|[i, j, k, l]| intersection_angle(i, j, k, l))
}

/// [`edge_dihedral_angle`] of all edges; `None` for removed edges, too.
#[must_use]
pub fn dihedral_angles(mesh: &TriMesh) -> EdgeMap<Option<f64>> {
    map_edges(mesh, edge_dihedral_angle)
}

/// [`edge_mean_curvature`] of all edges; `None` for removed edges, too.
#[must_use]
pub fn edge_mean_curvatures(mesh: &TriMesh) -> EdgeMap<Option<Integral>> {
    map_edges(mesh, edge_mean_curvature)
}

/// [`edge_intersection_angle`] of all edges; `None` for removed edges, too.
#[must_use]
pub fn intersection_angles(mesh: &TriMesh) -> EdgeMap<Option<f64>> {
    const BLOCK: usize = 64;
    let topology = mesh.topology();
    let level = Level::new();
    let of_block = |(): &mut (), indices: core::ops::Range<usize>| {
        let mut points = [[DVec3::ZERO; 4]; BLOCK];
        let mut angles = [None; BLOCK];
        for ((row, angle), edge) in
            zip(zip(&mut points, &mut angles), indices.map(EdgeId::from_index))
        {
            let diamond = || edge_diamond(mesh, edge);
            if let Some(diamond) = topology.contains_edge(edge).then(diamond).flatten() {
                (*row, *angle) = (diamond, Some(0.0));
            }
        }
        for (angle, found) in zip(&mut angles, intersection_angles_of(level, &points)) {
            *angle = angle.map(|_| found);
        }
        angles
    };
    let count = topology.edge_capacity();
    EdgeMap::from_vec(parallel::collect_blocks(count, || (), of_block))
}

fn map_edges<T: Send>(
    mesh: &TriMesh,
    value: impl Fn(&TriMesh, EdgeId) -> Option<T> + Sync,
) -> EdgeMap<Option<T>> {
    let topology = mesh.topology();
    EdgeMap::from_vec(parallel::collect(topology.edge_capacity(), |index| {
        let edge = EdgeId::from_index(index);
        if topology.contains_edge(edge) { value(mesh, edge) } else { None }
    }))
}

/// The ends of an edge, its left apex and its right apex.
#[inline]
fn edge_diamond(mesh: &TriMesh, edge: EdgeId) -> Option<[DVec3; 4]> {
    let topology = mesh.topology();
    let [h, twin] = edge.half_edges();
    let (left, right) = (topology.apex(h)?, topology.apex(twin)?);
    Some([topology.origin(h), topology.target(h), left, right].map(|v| mesh.position(v)))
}
