//! The rules of a run.

use crate::constraint::Constraints;
use crate::cost::CostModifier;

/// The rules of a run; see [`collapse_edges`](crate::collapse_edges).
pub struct Policies<C, P> {
    /// What a collapse costs.
    pub cost: C,
    /// What comes on top of the cost, one after the other.
    pub modifiers: Vec<Box<dyn CostModifier>>,
    /// Where the remaining vertex goes.
    pub placement: P,
    /// Which collapses are refused.
    pub constraints: Constraints,
    /// When costs are brought up to date.
    pub schedule: Schedule,
}

impl<C, P> Policies<C, P> {
    /// A cost and a placement, without surcharges and guards, lazily updated.
    #[must_use]
    pub fn new(cost: C, placement: P) -> Self {
        let (modifiers, constraints) = (Vec::new(), Constraints::default());
        Self { cost, modifiers, placement, constraints, schedule: Schedule::Lazy }
    }
}

/// In which order edges are collapsed, and when costs that a collapse has changed are brought up to
/// date.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Schedule {
    /// In rounds of the cheapest few percent of the edges. Within a round, neighbours follow each
    /// other, whatever they cost, and each edge is evaluated when its turn comes: if it has become
    /// more expensive than the round, it waits. A cost that has fallen is noticed late.
    #[default]
    Lazy,
    /// As `Lazy`, but large meshes are collapsed in regions of 4096 vertices, each by itself on one of
    /// all cores, up to a common cost, then in regions that lie across these, and from five
    /// quarters of the wanted faces on in one piece. Takes a fraction of the time and of the memory, with the
    /// same bits for any number of threads.
    ///
    /// Regions know accumulated quadrics ([`GarlandHeckbert`](crate::GarlandHeckbert)), optimal
    /// placement, [`NormalConstraint`](crate::NormalConstraint) and [`ShapeConstraint`](crate::ShapeConstraint). With the
    /// [`Hybrid`](crate::Hybrid) metric, with or without a curvature factor, these quadrics do the first part, as
    /// [`CollapseOptions::takeover`](crate::CollapseOptions::takeover) says; the rest is `Lazy`, in each of
    /// such regions by itself for as long as there are enough faces. Where
    /// anything else is asked for, all of it is: other metrics and placements, attributes, locked vertices and
    /// boundaries, features, other guards, policies of one's own, a largest error, and limits other than
    /// faces and time.
    Parallel,
    /// Strictly the cheapest first. All edges within [`Cost::reach`](crate::Cost::reach) of a
    /// collapse are evaluated at once. Takes several times as long.
    Exact,
}
