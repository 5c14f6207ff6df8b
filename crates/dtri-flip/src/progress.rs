//! Progress reports, cancellation and limits of a run.

use core::ops::ControlFlow;
use std::time::Instant;

use crate::options::FlipOptions;
use crate::report::Stop;

/// State of a run, for a progress display.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Progress {
    /// The current stage.
    pub phase: Phase,
    /// Number of flips so far.
    pub flips: u64,
    /// Current cost, from the initial cost and the sum of the gains.
    pub cost: f64,
    /// Work that remains. Greedy: edges in the queue. Rebuilding: vertices to remove. Annealing:
    /// steps.
    pub remaining: u64,
}

/// Stage of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Phase {
    /// Greedy descent: the best flip first.
    Greedy,
    /// Ruin and recreate: vertices are removed and inserted again.
    Rebuilding,
    /// Simulated annealing: random flips at a falling temperature.
    Annealing,
}

/// Checks the limits of a run and reports its progress at intervals.
pub(crate) struct Monitor<'p> {
    progress: &'p mut dyn FnMut(Progress) -> ControlFlow<()>,
    deadline: Option<Instant>,
    max_flips: u64,
    calls: u32,
    /// Number of calls between two checks of the clock.
    interval: u32,
}

impl<'p> Monitor<'p> {
    pub(crate) fn new(
        options: &FlipOptions,
        progress: &'p mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Self {
        Self {
            progress,
            deadline: options.time_limit.and_then(|limit| Instant::now().checked_add(limit)),
            max_flips: options.max_flips.unwrap_or(u64::MAX),
            calls: 0,
            interval: match options.look_ahead {
                0 | 1 => 256,
                2 => 32,
                _ => 1,
            },
        }
    }

    /// The end of the time limit.
    pub(crate) fn deadline(&self) -> Option<Instant> {
        self.deadline
    }

    /// Number of flips that the limit still allows after `flips`.
    pub(crate) fn flips_left(&self, flips: usize) -> usize {
        usize::try_from(self.max_flips.saturating_sub(flips as u64)).unwrap_or(usize::MAX)
    }

    /// The reason to stop before the next flip, if there is one.
    #[inline]
    pub(crate) fn stop(&mut self, now: impl FnOnce() -> Progress, flips: usize) -> Option<Stop> {
        if flips as u64 >= self.max_flips {
            return Some(Stop::FlipLimit);
        }
        self.calls = self.calls.wrapping_add(1);
        if self.calls % self.interval != 1 % self.interval {
            return None;
        }
        self.check(now)
    }

    /// Checks the clock and reports progress. Returns the reason to stop, if there is one.
    pub(crate) fn check(&mut self, now: impl FnOnce() -> Progress) -> Option<Stop> {
        if self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            return Some(Stop::TimeLimit);
        }
        (self.progress)(now()).is_break().then_some(Stop::Cancelled)
    }
}
