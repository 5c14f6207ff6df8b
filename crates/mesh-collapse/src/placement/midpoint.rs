//! The midpoint of the edge.

use glam::DVec3;

use super::Placement;
use crate::geometry::edge_patch::{EdgePatch, Place};
use crate::geometry::quadric::Quadric;
use crate::policy::{Needs, Policy};

/// Puts the vertex at the midpoint of the edge.
#[derive(Clone, Copy, Debug, Default)]
pub struct Midpoint;

impl Policy for Midpoint {}

impl Placement for Midpoint {
    fn place(
        &self,
        _: &EdgePatch<'_>,
        _: Option<&Quadric>,
        _: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        Place::At(DVec3::ZERO)
    }

    fn needs(&self) -> Needs {
        Needs::Ends
    }
}
