//! The rules of a run.

use crate::collapse::guard::Guard;

/// The rules of a run; see [`collapse_edges`](crate::collapse_edges).
pub struct Policies<'a, C, P> {
    /// What a collapse costs.
    pub cost: C,
    /// Where the remaining vertex goes.
    pub placement: P,
    /// Which collapses are refused.
    pub guards: Vec<Box<dyn Guard + 'a>>,
    /// When costs are brought up to date.
    pub update: Update,
}

/// In which order edges are collapsed, and when costs that a collapse has changed are brought up to
/// date.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Update {
    /// In rounds of the cheapest few percent of the edges. Within a round, neighbours follow each
    /// other, whatever they cost, and each edge is evaluated when its turn comes: if it has become
    /// more expensive than the round, it waits. A cost that has fallen is noticed late.
    #[default]
    Lazy,
    /// Strictly the cheapest first. All edges within [`Cost::reach`](crate::Cost::reach) of a
    /// collapse are evaluated at once. Takes several times as long.
    Eager,
}
