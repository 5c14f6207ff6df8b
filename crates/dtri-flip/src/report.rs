//! What a run did.

/// The result of a run.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FlipReport {
    /// The cost of the mesh as it was given.
    pub cost_before: f64,
    /// The cost of the mesh as it is now, computed afresh. Where all flips were undone again it may
    /// differ from `cost_before` in the last bits: the sums run in another order.
    pub cost_after: f64,
    /// The number of flips that lead from one to the other.
    pub flips: u64,
    /// How many rounds of rebuilding have lowered the cost. 0: none was asked for, or none has.
    pub rebuilt: u64,
    /// How many flips come from the last annealing round that was kept, and the greedy run after
    /// it. 0: annealing found nothing better than the greedy run.
    pub annealed_flips: u64,
    /// The number of feature and locked edges, which were never considered.
    pub locked_edges: usize,
    /// How often the flip that would have come next was refused, by reason.
    pub refused: Refused,
    /// Why the run ended.
    pub stop: Stop,
}

/// Counts of flips that would have lowered the cost but were refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Refused {
    /// An end of the edge has three edges only.
    pub valence_three: u64,
    /// The other diagonal is an edge already.
    pub diagonal_exists: u64,
    /// A new face would have had no area.
    pub flat: u64,
    /// A face would have turned too far; see [`FlipOptions::max_fold`](crate::FlipOptions).
    pub fold: u64,
    /// A new triangle would have crossed another one.
    pub intersection: u64,
    /// The edge had flipped too often;
    /// see [`FlipOptions::max_flips_per_edge`](crate::FlipOptions).
    pub cycle: u64,
    /// The flip back would have been a gain, too: both were rounding.
    pub rounding: u64,
    /// The gain was not what the queue said and the flip did not lower the cost any more. Only
    /// with [`Update::TwoNeighbourhood`](crate::Update).
    pub stale: u64,
}

impl Refused {
    /// All counts with the name of their reason, in the order of the fields.
    pub fn by_reason(&self) -> [(&'static str, u64); 8] {
        // Taken apart, so that no field can be forgotten.
        let Self {
            valence_three,
            diagonal_exists,
            flat,
            fold,
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
            ("intersection", intersection),
            ("cycle", cycle),
            ("rounding", rounding),
            ("stale", stale),
        ]
    }
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Stop {
    /// No allowed flip, or row of flips looked ahead, lowers the cost.
    LocalMinimum,
    /// As `LocalMinimum`, but some edges rest only because they had flipped too often.
    CycleGuard,
    /// The largest number of flips was reached.
    FlipLimit,
    /// The time was over.
    TimeLimit,
    /// The caller said so.
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
