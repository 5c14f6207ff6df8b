//! The rules of a run.

use crate::constraint::Constraints;
use crate::cost::CostModifier;

/// The policies of a run; see [`collapse_edges`](crate::collapse_edges).
pub struct Policies<C, P> {
    /// Cost of a collapse.
    pub cost: C,
    /// Modifiers of the cost, applied in order.
    pub modifiers: Vec<Box<dyn CostModifier>>,
    /// Position of the remaining vertex.
    pub placement: P,
    /// Constraints in addition to those that [`Protect`](crate::Protect) implies.
    pub constraints: Constraints,
    /// Order of the collapses.
    pub schedule: Schedule,
}

impl<C, P> Policies<C, P> {
    /// A cost and a placement, without modifiers and constraints, with the lazy schedule.
    #[must_use]
    pub fn new(cost: C, placement: P) -> Self {
        let (modifiers, constraints) = (Vec::new(), Constraints::default());
        Self { cost, modifiers, placement, constraints, schedule: Schedule::Lazy }
    }
}

/// Order in which edges collapse, and when costs that a collapse has changed are updated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Schedule {
    /// In rounds of the cheapest few percent of the edges. Within a round, neighbouring edges follow each other,
    /// independent of their costs. Each edge is evaluated when its turn comes: if it has become more expensive than the
    /// limit of the round, it waits. A decrease of a cost is noticed late.
    #[default]
    Lazy,
    /// As `Lazy`, but large meshes are cut into blocks of 4096 vertices. All cores collapse blocks in parallel, up to a
    /// common cost. Then new blocks are cut across the borders of the old ones. Below 1.25 times the wanted number of
    /// faces, the mesh is collapsed in one piece. This takes a fraction of the time and memory, and gives the same bits
    /// for any number of threads.
    ///
    /// Blocks support accumulated quadrics ([`GarlandHeckbert`](crate::GarlandHeckbert)), optimal placement,
    /// [`NormalConstraint`](crate::NormalConstraint) and [`ShapeConstraint`](crate::ShapeConstraint). In the crate
    /// `simplify`, `simplify::Plan` decides which part of a run uses blocks; a direct call of
    /// [`collapse_edges`](crate::collapse_edges) treats this as `Lazy`.
    Parallel,
    /// Strictly the cheapest first. All edges within [`Cost::reach`](crate::Cost::reach) of a collapse are evaluated
    /// immediately. Takes several times as long.
    Exact,
}
