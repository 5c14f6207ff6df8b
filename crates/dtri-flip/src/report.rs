//! Report of a run.

/// The result of a run.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FlipReport {
    /// Cost of the input mesh.
    pub cost_before: f64,
    /// Cost of the output mesh, computed from scratch. If all flips were undone it may differ from
    /// `cost_before` in the last bits, because sums run in another order.
    pub cost_after: f64,
    /// Number of flips from input to output.
    pub flips: u64,
    /// Number of rebuilding rounds that lowered the cost.
    pub rebuilt: u64,
    /// Number of flips of the last annealing round that was kept and the greedy descent after it. 0 if
    /// annealing found no lower cost.
    pub annealed_flips: u64,
    /// Number of feature edges and locked edges.
    pub locked_edges: usize,
    /// Number of rejected flips, by reason.
    pub rejected: Rejections,
    /// Reason why the run ended.
    pub stop: Stop,
}

/// Numbers of flips that would lower the cost but were rejected, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rejections {
    /// An end of the edge has valence three.
    pub valence_three: u64,
    /// The other diagonal is already an edge.
    pub diagonal_exists: u64,
    /// A new face would be degenerate.
    pub flat: u64,
    /// A face would turn by more than the limit; see [`FlipOptions::max_fold`](crate::FlipOptions).
    pub fold: u64,
    /// A new face would be a sliver; see [`ShapeConstraint`](crate::ShapeConstraint).
    pub sliver: u64,
    /// The quadrilateral is not convex; see [`ShapeConstraint`](crate::ShapeConstraint).
    pub not_convex: u64,
    /// A new triangle would cross another triangle.
    pub intersection: u64,
    /// The edge has reached the limit of flips per edge; see
    /// [`FlipOptions::max_flips_per_edge`](crate::FlipOptions).
    pub cycle: u64,
    /// Flipping back would be a gain as well: both gains are rounding.
    pub rounding: u64,
    /// The gain in the queue was stale and the flip no longer lowers the cost. Only with
    /// [`Update::TwoNeighbourhood`](crate::Update).
    pub stale: u64,
}

impl Rejections {
    /// All counts with the names of their reasons.
    pub fn by_reason(&self) -> [(&'static str, u64); 10] {
        // Destructured, so that the compiler finds a forgotten field.
        let Self {
            valence_three,
            diagonal_exists,
            flat,
            fold,
            sliver,
            not_convex,
            intersection,
            cycle,
            rounding,
            stale,
        } = *self;
        [
            ("valence_three", valence_three),
            ("diagonal_exists", diagonal_exists),
            ("flat", flat),
            ("fold", fold),
            ("sliver", sliver),
            ("not_convex", not_convex),
            ("intersection", intersection),
            ("cycle", cycle),
            ("rounding", rounding),
            ("stale", stale),
        ]
    }
}

/// Reason why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Stop {
    /// No allowed flip or sequence of flips lowers the cost.
    LocalMinimum,
    /// As `LocalMinimum`, but some edges stay only because they reached the limit of flips per edge.
    CycleGuard,
    /// The limit of flips was reached.
    FlipLimit,
    /// The time limit was reached.
    TimeLimit,
    /// The caller cancelled the run.
    Cancelled,
}

impl core::fmt::Display for Stop {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::LocalMinimum => "local-minimum",
            Self::CycleGuard => "cycle-guard",
            Self::FlipLimit => "flip-limit",
            Self::TimeLimit => "time-limit",
            Self::Cancelled => "cancelled",
        })
    }
}
