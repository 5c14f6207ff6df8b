//! Where the vertex goes that remains of a collapsed edge.

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

/// Chooses the place of the vertex that remains.
pub trait Placement: Policy {
    /// The place. `quadric` is that of the cost, if it has one, and `cost` the cost as a function
    /// of the place relative to the midpoint of the edge.
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        cost: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place;

    /// Whether the place that was chosen, relative to the midpoint, will do. Asked last, after the
    /// constraints, so that it may take its time.
    ///
    /// # Errors
    /// The reason why not.
    fn check(
        &self,
        patch: &EdgePatch<'_>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> Result<(), Rejection> {
        let _ = (patch, x, scratch);
        Ok(())
    }

    /// Another place to be tried, after so many were rejected by [`Placement::check`] or a constraint; with
    /// the first one rejected it is asked for with 0. `None` when there is none, which then is the end
    /// of it.
    fn instead(&self, refused: usize) -> Option<Place> {
        let _ = refused;
        None
    }

    /// Called before each collapse, which is certain by then. What is of the placement in the memory is what
    /// [`Placement::check`] of this very place has left there.
    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        let _ = (patch, x, scratch);
    }

    /// Whether [`Placement::check`] takes so long that it is asked ahead of the turns of edges, for many side by
    /// side, where there are several threads. It is asked again when the turn comes, with the same memory: there
    /// it finds what it has left, and has to see whether that still holds.
    fn is_asked_ahead(&self) -> bool {
        false
    }

    /// What of the patch is looked at by [`Placement::place`], other than by the cost.
    fn needs(&self) -> Needs {
        Needs::Faces
    }
}

/// For placements that are chosen at run time.
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
