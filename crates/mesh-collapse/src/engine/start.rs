//! Start data of a run, in addition to the mesh.

use mesh_core::EdgeId;

use crate::constraint::Constraints;
use crate::geometry::quadric::Quadric;

/// Start data of a run that continues another one, or that collapses a part of a larger mesh.
#[derive(Clone, Debug, Default)]
pub struct Start {
    /// Constraints that follow the mesh already.
    pub followers: Constraints,
    /// For each vertex, the accumulated quadric of border edges, about its position; empty if no vertex has one. `None`
    /// to compute them from the current mesh.
    pub borders: Option<Vec<Quadric>>,
    /// For each vertex, whether edges at it may collapse; `None` for all. If set, the mesh is a part of a larger one,
    /// and the run ends at the first edge beyond the largest cost.
    pub is_free: Option<Vec<bool>>,
    /// Edges to try first; all others follow only if these are not enough. `None` for all edges at once.
    pub first: Option<Vec<EdgeId>>,
}

impl Start {
    /// Start data with constraints that follow the mesh already.
    pub fn followed_by(followers: Constraints) -> Self {
        Self { followers, ..Self::default() }
    }
}
