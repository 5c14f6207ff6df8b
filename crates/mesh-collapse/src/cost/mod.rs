//! What a collapse costs.
//!
//! The greedy loop collapses the cheapest edge first. A new cost implements [`Cost`], most often
//! through [`Cost::quadric`] and [`Cost::cost`] alone. What is to come on top of any cost is a
//! [`CostModifier`].

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
    /// The quadric whose minimum is the best place for the vertex that remains, about the
    /// midpoint of the edge. Costs that do not come from one have none.
    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        let _ = patch;
        None
    }

    /// The cost of the collapse when the vertex goes to `x`, relative to the midpoint of the
    /// edge; `quadric` is what [`Cost::quadric`] returned.
    fn cost(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> f64;

    /// A number that is not larger than the cost and quicker to have. When there is one, the cost
    /// itself is evaluated only once an edge reaches the head of the queue.
    fn lower_bound(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
    ) -> Option<f64> {
        let _ = (patch, quadric, x);
        None
    }

    /// As [`Cost::lower_bound`], for a cost that can be bounded for all places of the vertex by the
    /// edge and its ends alone: the patch has no faces yet.
    fn early_bound(&self, patch: &EdgePatch<'_>) -> Option<f64> {
        let _ = patch;
        None
    }

    /// What of the patch is looked at, other than by [`Cost::early_bound`] and [`Cost::collapsing`].
    fn needs(&self) -> Needs {
        Needs::Faces
    }

    /// How far a collapse is felt.
    fn reach(&self) -> Reach {
        Reach::OneRing
    }

    /// Called before each collapse, which is certain by then, with the place of the vertex relative
    /// to the midpoint of the edge.
    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        let _ = (patch, x, scratch);
    }
}

/// For costs that are chosen at run time.
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

/// Whose costs a collapse changes; see [`Cost::reach`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reach {
    /// Those of the edges at the vertex that remains.
    OneRingSum,
    /// Those of the edges at the vertex that remains and at its neighbours.
    OneRing,
    /// Those of the edges at the vertex that remains, its neighbours, and their neighbours.
    TwoRings,
}
