//! Feature edges and locked edges.

use dcurv::edge_dihedral_angle;
use mesh_core::{EdgeId, EdgeMap, Handle, TriMesh, parallel};

use crate::options::FlipOptions;

/// Marks the edges whose dihedral angle exceeds `angle`, in radians. Boundary edges are not marked,
/// since they never flip.
#[must_use]
pub fn feature_edges(mesh: &TriMesh, angle: f64) -> EdgeMap<bool> {
    let topology = mesh.topology();
    EdgeMap::from_vec(parallel::collect(topology.edge_capacity(), |index| {
        let edge = EdgeId::from_index(index);
        topology.contains_edge(edge)
            && edge_dihedral_angle(mesh, edge).is_some_and(|beta| beta.abs() > angle)
    }))
}

/// Union of the feature edges and the locked edges of the options.
pub(crate) fn locked_edges(mesh: &TriMesh, options: &FlipOptions) -> EdgeMap<bool> {
    let mut locked = match options.feature_angle {
        Some(angle) => feature_edges(mesh, angle),
        None => mesh.topology().edge_map(false),
    };
    if let Some(given) = &options.locked {
        for (mark, also) in locked.as_mut_slice().iter_mut().zip(given.as_slice()) {
            *mark |= also;
        }
    }
    locked
}
