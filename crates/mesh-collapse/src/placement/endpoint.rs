//! The better end of the edge.

use glam::DVec3;

use super::Placement;
use crate::geometry::edge_patch::{EdgePatch, Place};
use crate::geometry::quadric::Quadric;
use crate::policy::{Needs, Policy};

/// Puts the vertex at the end of the edge with the lower cost, so that the vertices of the result are a subset of the
/// original ones.
#[derive(Clone, Copy, Debug, Default)]
pub struct BestEndpoint;

impl Policy for BestEndpoint {}

impl Placement for BestEndpoint {
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        _: Option<&Quadric>,
        cost: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        let [removed, kept] = patch.ends().map(cost);
        if removed < kept { Place::Removed } else { Place::Kept }
    }

    fn needs(&self) -> Needs {
        Needs::Ends
    }
}
