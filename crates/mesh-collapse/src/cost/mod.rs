//! Costs of collapses.
//!
//! The greedy loop collapses the cheapest edge first. A new cost implements [`Cost`], usually with [`Cost::quadric`]
//! and [`Cost::cost`] only. A [`CostModifier`] adds to any cost.

mod cost_modifier;
#[cfg(feature = "curvature")]
mod curvature_change;
#[cfg(feature = "curvature")]
mod curvature_factor;
#[cfg(feature = "curvature")]
mod curvature_norm;
#[cfg(feature = "curvature")]
mod curvature_term;
pub(crate) mod garland_heckbert;
mod hybrid;
mod memoryless;

pub use cost_modifier::CostModifier;
#[cfg(feature = "curvature")]
pub use curvature_factor::CurvatureFactor;
#[cfg(feature = "curvature")]
pub use curvature_norm::{CurvatureNorm, Norm};
#[cfg(feature = "curvature")]
pub use curvature_term::CurvatureTerm;
pub use garland_heckbert::GarlandHeckbert;
pub use hybrid::Hybrid;
pub use memoryless::Memoryless;

use glam::DVec3;

use crate::geometry::edge_patch::EdgePatch;
use crate::geometry::quadric::Quadric;
use crate::policy::{Needs, Policy, Scratch};

/// The cost of collapsing an edge, given its neighbourhood.
///
/// ```
/// use glam::DVec3;
/// use mesh_collapse::{Cost, EdgePatch, Policy, Quadric, Scratch};
///
/// /// Short edges first.
/// struct EdgeLength;
///
/// impl Policy for EdgeLength {}
///
/// impl Cost for EdgeLength {
///     fn cost(
///         &self,
///         patch: &EdgePatch<'_>,
///         _: Option<&Quadric>,
///         _: DVec3,
///         _: &mut Scratch,
///     ) -> f64 {
///         patch.squared_length()
///     }
/// }
/// ```
pub trait Cost: Policy {
    /// The quadric whose minimum is the best position for the remaining vertex, about the midpoint of the edge. `None`
    /// for costs without a quadric.
    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        let _ = patch;
        None
    }

    /// The cost of the collapse with the vertex at `x`, relative to the midpoint of the edge; `quadric` is the result
    /// of [`Cost::quadric`].
    fn cost(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> f64;

    /// A lower bound of the cost that is cheaper to compute. If there is one, the cost itself is evaluated only when an
    /// edge reaches the head of the queue.
    fn lower_bound(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
    ) -> Option<f64> {
        let _ = (patch, quadric, x);
        None
    }

    /// As [`Cost::lower_bound`], for a bound that holds for all positions of the vertex and depends only on the edge
    /// and its ends. The patch has no faces yet.
    fn early_bound(&self, patch: &EdgePatch<'_>) -> Option<f64> {
        let _ = patch;
        None
    }

    /// The data of the patch that this cost uses, except in [`Cost::early_bound`] and [`Cost::collapsing`].
    fn needs(&self) -> Needs {
        Needs::Faces
    }

    /// The edges whose costs a collapse changes.
    fn reach(&self) -> Reach {
        Reach::OneRing
    }

    /// Called before each collapse, when it is certain, with the position of the vertex relative to the midpoint of the
    /// edge.
    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        let _ = (patch, x, scratch);
    }
}

/// For costs chosen at run time.
impl<C: Cost + ?Sized> Cost for Box<C> {
    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        (**self).quadric(patch)
    }

    fn cost(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> f64 {
        (**self).cost(patch, quadric, x, scratch)
    }

    fn lower_bound(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
    ) -> Option<f64> {
        (**self).lower_bound(patch, quadric, x)
    }

    fn early_bound(&self, patch: &EdgePatch<'_>) -> Option<f64> {
        (**self).early_bound(patch)
    }

    fn needs(&self) -> Needs {
        (**self).needs()
    }

    fn reach(&self) -> Reach {
        (**self).reach()
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        (**self).collapsing(patch, x, scratch);
    }
}

/// The edges whose costs a collapse changes; see [`Cost::reach`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reach {
    /// The edges at the remaining vertex.
    OneRingSum,
    /// The edges at the remaining vertex and at its neighbours.
    OneRing,
    /// The edges at the remaining vertex, its neighbours, and their neighbours.
    TwoRings,
}
