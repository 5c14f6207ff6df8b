//! How much of a patch is collected: only as much as costs and placements need.

use mesh_core::{EdgeId, TriMesh};

use crate::cost::Cost;
use crate::engine::one_ring_sums::OneRingSums;
use crate::engine::vertex_freedom::VertexFreedom;
use crate::geometry::edge_patch::{EdgePatch, LazyPatch, PatchFace};
use crate::placement::Placement;
use crate::policies::Policies;
use crate::policy::Needs;

/// The data collected for a patch.
pub(super) enum Detail {
    Ends,
    Sums(OneRingSums),
    Faces,
}

impl Detail {
    pub(super) fn new<C: Cost, P: Placement>(mesh: &TriMesh, policies: &Policies<C, P>) -> Self {
        match policies.cost.needs().max(policies.placement.needs()) {
            Needs::Ends => Self::Ends,
            Needs::Sums => Self::Sums(OneRingSums::new(mesh)),
            Needs::Faces => Self::Faces,
        }
    }

    /// The sums over faces, if they are used.
    pub(super) fn sums(&mut self) -> Option<&mut OneRingSums> {
        match self {
            Self::Sums(sums) => Some(sums),
            Self::Ends | Self::Faces => None,
        }
    }

    /// The patch of an edge; its faces go into `scratch`.
    #[inline]
    pub(super) fn patch<'p>(
        &self,
        mesh: &'p TriMesh,
        fixed: &VertexFreedom,
        edge: EdgeId,
        scratch: &'p mut Vec<PatchFace>,
    ) -> LazyPatch<'p> {
        let patch = EdgePatch::without_faces(mesh, edge.half_edge());
        let patch = patch.with_border(fixed.border(&patch));
        match self {
            Self::Ends => LazyPatch::new(patch, scratch),
            Self::Sums(sums) => LazyPatch::new(patch.with_sum(sums.of_edge(&patch)), scratch),
            Self::Faces => {
                let mut patch = LazyPatch::new(patch, scratch);
                patch.with_faces();
                patch
            }
        }
    }
}
