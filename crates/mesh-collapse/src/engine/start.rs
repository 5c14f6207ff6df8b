//! What a run begins with, beside the mesh.

use mesh_core::EdgeId;

use crate::constraint::Constraints;
use crate::geometry::quadric::Quadric;

/// What a run takes over that goes on with another one, or collapses a part of a larger mesh.
#[derive(Clone, Debug, Default)]
pub struct Start {
    /// Constraints that follow the mesh already.
    pub followers: Constraints,
    /// By vertex: the quadrics of the border edges that it has been merged with, about its position;
    /// `None` for those of the mesh as it is, and nothing where no vertex has any.
    pub borders: Option<Vec<Quadric>>,
    /// By vertex: whether edges at it may collapse. `None` for all; otherwise the mesh is a part of a
    /// larger one, and the run ends at the first edge beyond the largest cost.
    pub is_free: Option<Vec<bool>>,
    /// Edges that are looked at first; the others only when these do not do. `None` for all at once.
    pub first: Option<Vec<EdgeId>>,
}

impl Start {
    /// With constraints that follow the mesh already.
    pub fn followed_by(followers: Constraints) -> Self {
        Self { followers, ..Self::default() }
    }
}
