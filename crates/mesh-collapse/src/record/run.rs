//! Reports of runs of collapses.

use mesh_core::as_u32;

use crate::protect::Protected;
use crate::record::log::{CollapseLog, LogEntry};
use crate::record::snapshot::Snapshot;
use crate::record::target::StopReason;
use crate::rejection::{Rejection, Rejections};

/// The phase of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Phase {
    /// Edges are collapsed.
    Collapse,
    /// The coarsest level within the error limit is searched.
    Search,
    /// A level is fitted.
    Fit,
    /// A level is annealed.
    Anneal,
    /// The largest errors are reduced.
    MaxError,
    /// A level within the error limit is collapsed further.
    DecimateToTolerance,
    /// The distance from the original is measured.
    Measure,
}

impl Phase {
    /// A short name in lower case, for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Collapse => "collapse",
            Self::Search => "search",
            Self::Fit => "fit",
            Self::Anneal => "anneal",
            Self::MaxError => "max_error",
            Self::DecimateToTolerance => "decimate_to_tolerance",
            Self::Measure => "measure",
        }
    }
}

/// The progress of a run, as reported to the observer.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Progress {
    /// The current phase.
    pub phase: Phase,
    /// The number of faces at the start.
    pub faces_before: usize,
    /// The number of faces now.
    pub faces: usize,
    /// The number of faces at which the run ends, unless another limit is reached first.
    pub face_target: usize,
    /// The number of collapses so far.
    pub collapses: usize,
}

/// The report of a run of [`collapse_edges`](crate::collapse_edges).
#[derive(Clone, Debug)]
pub struct Run {
    /// Why it stopped.
    pub stop: StopReason,
    /// The number of collapses.
    pub collapses: usize,
    /// Every collapse, if they are recorded.
    pub log: CollapseLog,
    /// How often edges were rejected, by reason.
    pub rejections: Rejections,
    /// The largest cost of a collapse.
    pub max_cost: f64,
    /// The protected elements of the current mesh, and the constraints that followed the mesh before the run and during
    /// it.
    pub protected: Protected,
    /// Every rejection, in order, with the number of collapses that a run must be allowed to reach it.
    pub refused: Vec<(u32, Rejection)>,
    /// Snapshots of the run, if they were requested.
    pub snapshots: Vec<Snapshot>,
}

impl Run {
    /// A run that has not started.
    pub(crate) fn new() -> Self {
        Self {
            stop: StopReason::NothingLeft,
            collapses: 0,
            log: CollapseLog::default(),
            rejections: Rejections::default(),
            max_cost: 0.0,
            protected: Protected::default(),
            refused: Vec::new(),
            snapshots: Vec::new(),
        }
    }

    /// Appends a collapse.
    pub fn push(&mut self, entry: LogEntry) {
        self.collapses += 1;
        self.log.push(entry);
        self.max_cost = self.max_cost.max(entry.cost);
    }

    /// Counts a rejection that a run reaches after `collapses` collapses.
    pub fn refuse(&mut self, rejection: Rejection, collapses: usize) {
        self.rejections.count(rejection);
        self.refused.push((as_u32(collapses), rejection));
    }

    /// Keeps only the first collapses, as if the run had been limited to them. The caller must set the reason for the
    /// stop; `protected` still describes the end. Rejections in blocks are kept, because their times are
    /// unknown.
    pub fn truncate(&mut self, collapses: usize) {
        self.log.truncate(collapses);
        self.collapses = self.log.len();
        self.max_cost = self.log.entries().iter().map(|entry| entry.cost).fold(0.0, f64::max);
        let kept = self.refused.partition_point(|&(needed, _)| needed as usize <= collapses);
        self.refused.drain(kept..).for_each(|(_, rejection)| self.rejections.take_back(rejection));
    }
}
