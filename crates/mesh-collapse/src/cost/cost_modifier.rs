//! What is added to a cost.

use glam::DVec3;

use super::Reach;
use crate::geometry::edge_patch::EdgePatch;
use crate::policy::{Policy, Scratch};
use crate::rejection::Rejection;

/// Something that makes collapses cost more than the [`Cost`](super::Cost) of the run says.
///
/// A cost modifier never lowers a cost. The cost is therefore a lower bound, and cost modifiers are asked
/// only about edges that reach the head of the queue.
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
    /// The cost with this on top, when the vertex goes to `x` relative to the midpoint of the edge.
    fn raise(&self, cost: f64, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) -> f64;

    /// Whether the edge may be collapsed at all with its vertex going to `x`. Asked after the constraints.
    ///
    /// # Errors
    /// The reason why not.
    fn check(&self, patch: &EdgePatch<'_>, x: DVec3) -> Result<(), Rejection> {
        let _ = (patch, x);
        Ok(())
    }

    /// How far a collapse is felt.
    fn reach(&self) -> Reach {
        Reach::OneRingSum
    }

    /// Called before each collapse, which is certain by then.
    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        let _ = (patch, x, scratch);
    }
}
