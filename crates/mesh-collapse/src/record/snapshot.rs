//! Meshes saved during a run.

use mesh_core::{HalfEdgeId, TriMesh, VertexId};

/// A mesh saved during a run, without gaps, with the origin of its elements.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The mesh.
    pub mesh: TriMesh,
    /// The vertex of the original for each vertex.
    pub vertices: Vec<VertexId>,
    /// The half-edge of the original for each half-edge; empty unless collapses are recorded.
    pub half_edges: Vec<HalfEdgeId>,
    /// The number of collapses before the snapshot.
    pub collapses: usize,
}
