//! A loop over all vertices that can be stopped.

use mesh_core::{Handle, TriMesh, VertexId, VertexMap, parallel};

/// A value of every vertex, and the default for the vertices after `stops` has returned true. Each thread has memory of its
/// own.
pub(crate) fn of_vertices<T: Default + Send, M: Send>(
    mesh: &TriMesh,
    stops: &(dyn Fn() -> bool + Sync),
    memory: impl Fn() -> M + Sync,
    of_vertex: impl Fn(&mut M, VertexId) -> T + Sync,
) -> VertexMap<T> {
    let count = mesh.topology().vertex_capacity();
    VertexMap::from_vec(parallel::collect_with(count, memory, |memory, index| {
        if stops() { T::default() } else { of_vertex(memory, VertexId::from_index(index)) }
    }))
}
