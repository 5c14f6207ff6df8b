//! How much of a patch is there when its edge is looked at: no more than costs and placements need.

use mesh_core::{EdgeId, TriMesh};

use crate::collapse::cost::Cost;
use crate::collapse::fixed::Fixed;
use crate::collapse::patch::{EdgePatch, LazyPatch, PatchFace};
use crate::collapse::placement::Placement;
use crate::collapse::policies::Policies;
use crate::collapse::policy::Needs;
use crate::collapse::stars::Stars;

/// What patches are made with.
pub(super) enum Detail {
    Ends,
    Sums(Stars),
    Faces,
}

impl Detail {
    pub(super) fn new<C: Cost, P: Placement>(mesh: &TriMesh, policies: &Policies<C, P>) -> Self {
        match policies.cost.needs().max(policies.placement.needs()) {
            Needs::Ends => Self::Ends,
            Needs::Sums => Self::Sums(Stars::new(mesh)),
            Needs::Faces => Self::Faces,
        }
    }

    /// The sums over faces that follow the mesh, where there are any.
    pub(super) fn stars(&mut self) -> Option<&mut Stars> {
        match self {
            Self::Sums(stars) => Some(stars),
            Self::Ends | Self::Faces => None,
        }
    }

    /// The patch of an edge; its faces go into `scratch`.
    #[inline]
    pub(super) fn patch<'p>(
        &self,
        mesh: &'p TriMesh,
        fixed: &Fixed,
        edge: EdgeId,
        scratch: &'p mut Vec<PatchFace>,
    ) -> LazyPatch<'p> {
        let patch = EdgePatch::without_faces(mesh, edge.half_edge());
        let patch = patch.with_border(fixed.border(&patch));
        match self {
            Self::Ends => LazyPatch::new(patch, scratch),
            Self::Sums(stars) => LazyPatch::new(patch.with_sum(stars.of_edge(&patch)), scratch),
            Self::Faces => {
                let mut patch = LazyPatch::new(patch, scratch);
                patch.with_faces();
                patch
            }
        }
    }
}
