//! The rules of a run.

use crate::constraint::Constraints;
use crate::cost::CostModifier;

/// The policies of a run; see [`collapse_edges`](crate::collapse_edges).
pub struct Policies<C, P> {
    /// Cost of a collapse.
    pub cost: C,
    /// What changes the cost, one after the other.
    pub modifiers: Vec<Box<dyn CostModifier>>,
    /// Position of the remaining vertex.
    pub placement: P,
    /// Constraints besides those of [`Protect`](crate::Protect).
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
    /// In rounds of the cheapest few percent of the edges. Within a round, neighbours follow each other, whatever they
    /// cost. Each edge is evaluated when its turn comes: if it has become more expensive than the round, it waits. A
    /// cost that has fallen is noticed late.
    #[default]
    Lazy,
    /// As `Lazy`, but large meshes are cut into blocks of 4096 vertices. All cores collapse blocks side by side up to a
    /// common cost, then blocks that lie across the borders of these; from five quarters of the wanted faces on, the
    /// mesh is collapsed in one piece. It takes a fraction of the time and memory, and gives the same bits on any number
    /// of threads.
    ///
    /// Blocks know accumulated quadrics ([`GarlandHeckbert`](crate::GarlandHeckbert)), optimal placement,
    /// [`NormalConstraint`](crate::NormalConstraint) and [`ShapeConstraint`](crate::ShapeConstraint). The crate
    /// `simplify` decides in `simplify::Plan` which part of a run they do; a single call of
    /// [`collapse_edges`](crate::collapse_edges) treats this as `Lazy`.
    Parallel,
    /// Strictly the cheapest first. All edges within [`Cost::reach`](crate::Cost::reach) of a collapse are evaluated at
    /// once. Takes several times as long.
    Exact,
}
