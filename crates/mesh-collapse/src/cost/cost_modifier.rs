//! Additions to costs.

use glam::DVec3;

use super::Reach;
use crate::geometry::edge_patch::EdgePatch;
use crate::policy::{Policy, Scratch};
use crate::rejection::Rejection;

/// Makes collapses cost more than the [`Cost`](super::Cost) of the run alone.
///
/// A cost modifier never lowers a cost. So the cost is a lower bound, and cost modifiers are evaluated only for edges
/// at the head of the queue.
///
/// ```
/// use glam::DVec3;
/// use mesh_collapse::{EdgePatch, Policy, Scratch, CostModifier};
///
/// /// Edges along the z axis stay longer than others.
/// struct Upright;
///
/// impl Policy for Upright {}
///
/// impl CostModifier for Upright {
///     fn raise(&self, cost: f64, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) -> f64 {
///         let [a, b] = patch.ends();
///         cost * (1.0 + (b - a).normalize_or_zero().z.abs())
///     }
/// }
/// ```
pub trait CostModifier: Policy {
    /// The raised cost if the vertex moves to `x`, relative to the midpoint of the edge.
    fn raise(&self, cost: f64, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) -> f64;

    /// Whether the edge may be collapsed with its vertex at `x`. Called after the constraints.
    ///
    /// # Errors
    /// The reason for the rejection.
    fn check(&self, patch: &EdgePatch<'_>, x: DVec3) -> Result<(), Rejection> {
        let _ = (patch, x);
        Ok(())
    }

    /// The edges whose costs a collapse changes.
    fn reach(&self) -> Reach {
        Reach::OneRingSum
    }

    /// Called before each collapse, when it is certain.
    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        let _ = (patch, x, scratch);
    }
}
