//! Placements: rules for the position of the remaining vertex.

mod butterfly;
mod endpoint;
mod least_cost;
mod midpoint;
mod optimal;

pub use butterfly::ButterflyPoint;
pub use endpoint::BestEndpoint;
pub use least_cost::LeastCost;
pub use midpoint::Midpoint;
pub use optimal::Optimal;

use glam::DVec3;

use crate::geometry::edge_patch::{EdgePatch, Place};
use crate::geometry::quadric::Quadric;
use crate::policy::{Needs, Policy, Scratch};
use crate::rejection::Rejection;

/// Chooses the position of the remaining vertex.
pub trait Placement: Policy {
    /// The position. `quadric` is the quadric of the cost, if it has one. `cost` is the cost as a function of the
    /// position relative to the midpoint of the edge.
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        cost: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place;

    /// Whether the chosen position, relative to the midpoint, is acceptable. Called last, after the constraints, so it
    /// may be expensive.
    ///
    /// # Errors
    /// The reason for the rejection.
    fn check(
        &self,
        patch: &EdgePatch<'_>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> Result<(), Rejection> {
        let _ = (patch, x, scratch);
        Ok(())
    }

    /// An alternative position, after `refused` positions were rejected in addition to the first one, by
    /// [`Placement::check`] or a constraint. The first call has 0. `None` ends the attempts.
    fn instead(&self, refused: usize) -> Option<Place> {
        let _ = refused;
        None
    }

    /// Called before each collapse, when it is certain. The data of the placement in `scratch` is the data that
    /// [`Placement::check`] has left for this position.
    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        let _ = (patch, x, scratch);
    }

    /// Whether [`Placement::check`] is so expensive that, with several threads, it should be called ahead of the turns,
    /// for many edges in parallel. It is called again in the turn of the edge, with the same memory. It can reuse its
    /// earlier result there, and must test whether it is still valid.
    fn is_asked_ahead(&self) -> bool {
        false
    }

    /// The data of the patch that [`Placement::place`] uses, apart from the cost.
    fn needs(&self) -> Needs {
        Needs::Faces
    }
}

/// For placements chosen at run time.
impl<P: Placement + ?Sized> Placement for Box<P> {
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        cost: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        (**self).place(patch, quadric, cost)
    }

    fn check(
        &self,
        patch: &EdgePatch<'_>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> Result<(), Rejection> {
        (**self).check(patch, x, scratch)
    }

    fn instead(&self, refused: usize) -> Option<Place> {
        (**self).instead(refused)
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        (**self).collapsing(patch, x, scratch);
    }

    fn is_asked_ahead(&self) -> bool {
        (**self).is_asked_ahead()
    }

    fn needs(&self) -> Needs {
        (**self).needs()
    }
}
