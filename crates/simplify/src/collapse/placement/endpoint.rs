//! The better end of the edge.

use glam::DVec3;

use super::Placement;
use crate::collapse::patch::{EdgePatch, Place};
use crate::collapse::policy::{Needs, Policy};
use crate::collapse::quadric::Quadric;

/// Leaves the vertex at that end of the edge where it costs less, so that the vertices of the
/// result are among those of the original.
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
