//! Meshes that a run leaves on the way.

use mesh_core::{HalfEdgeId, TriMesh, VertexId};

/// A mesh on the way of a run, as the run had it: without gaps, and where its elements come from.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The mesh.
    pub mesh: TriMesh,
    /// The vertices of the original that are left.
    pub vertices: Vec<VertexId>,
    /// By half-edge: that of the original; nothing unless collapses are recorded.
    pub half_edges: Vec<HalfEdgeId>,
    /// How many collapses there were before it.
    pub collapses: usize,
}
