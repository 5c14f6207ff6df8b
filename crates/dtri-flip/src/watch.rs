//! Progress, cancelling and limits.

use core::ops::ControlFlow;
use std::time::Instant;

use crate::options::FlipOptions;
use crate::report::Stop;

/// Where a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Progress {
    /// What it is doing.
    pub phase: Phase,
    /// Flips so far.
    pub flips: u64,
    /// The cost so far, added up from the gains.
    pub cost: f64,
    /// Greedy: edges in the queue. Rebuilding: vertices to take out.
    /// Annealing: steps to go.
    pub waiting: u64,
}

/// What a run is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Phase {
    /// Taking the best flip while there is one.
    Greedy,
    /// Taking vertices out and putting them back.
    Rebuilding,
    /// Taking random flips at a falling temperature.
    Annealing,
}

/// Asks now and then whether to go on.
pub(crate) struct Watch<'p> {
    progress: &'p mut dyn FnMut(Progress) -> ControlFlow<()>,
    deadline: Option<Instant>,
    max_flips: u64,
    calls: u32,
    /// Looks at the clock and tells the caller once in so many calls.
    interval: u32,
}

impl<'p> Watch<'p> {
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

    /// When the time is over.
    pub(crate) fn deadline(&self) -> Option<Instant> {
        self.deadline
    }

    /// How many flips may still be done after so many.
    pub(crate) fn flips_left(&self, flips: usize) -> usize {
        usize::try_from(self.max_flips.saturating_sub(flips as u64)).unwrap_or(usize::MAX)
    }

    /// Why to stop before the next flip, if so.
    #[inline]
    pub(crate) fn stop(&mut self, now: impl FnOnce() -> Progress, flips: usize) -> Option<Stop> {
        if flips as u64 >= self.max_flips {
            return Some(Stop::FlipLimit);
        }
        self.calls = self.calls.wrapping_add(1);
        if self.calls % self.interval != 1 % self.interval {
            return None;
        }
        self.look(now)
    }

    /// Looks at the clock and tells the caller; why to stop, if so.
    pub(crate) fn look(&mut self, now: impl FnOnce() -> Progress) -> Option<Stop> {
        if self.deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            return Some(Stop::TimeLimit);
        }
        (self.progress)(now()).is_break().then_some(Stop::Cancelled)
    }
}
