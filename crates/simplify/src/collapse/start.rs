//! What a run begins with, beside the mesh.

use mesh_core::EdgeId;

use crate::collapse::guard::Guards;
use crate::collapse::quadric::Quadric;

/// What a run takes over that goes on with another one, or collapses a part of a larger mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Start {
    /// Guards that follow the mesh already.
    pub(crate) followers: Guards,
    /// By vertex: the quadrics of the border edges that it has been merged with, about its position;
    /// `None` for those of the mesh as it is, and nothing where no vertex has any.
    pub(crate) borders: Option<Vec<Quadric>>,
    /// By vertex: whether edges at it may collapse. `None` for all; otherwise the mesh is a part of a
    /// larger one, and the run ends at the first edge beyond the largest cost.
    pub(crate) is_free: Option<Vec<bool>>,
    /// Edges that are looked at first; the others only when these do not do. `None` for all at once.
    pub(crate) first: Option<Vec<EdgeId>>,
}

impl Start {
    /// With guards that follow the mesh already.
    pub(crate) fn followed_by(followers: Guards) -> Self {
        Self { followers, ..Self::default() }
    }
}
