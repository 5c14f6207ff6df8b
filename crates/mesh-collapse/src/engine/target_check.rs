//! The test whether a run has reached one of its limits.

use core::ops::ControlFlow;
use std::time::Instant;

use crate::record::run::{Phase, Progress};
use crate::record::target::{StopReason, Target};

/// The number of collapses between two checks of the clock and the observer.
const OBSERVED_EVERY: usize = 1024;

/// The largest number of turns between two checks, with or without collapses.
const OBSERVED_TURNS: usize = 16 * OBSERVED_EVERY;

/// The limits of a run, and the data to test them.
pub(super) struct TargetCheck<'a> {
    limits: &'a Target,
    observe: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
    start: Instant,
    faces_before: usize,
    face_target: usize,
    observed: usize,
    /// The number of turns since the last check.
    turns: usize,
}

impl<'a> TargetCheck<'a> {
    /// Limits for a mesh with this many faces. The clock starts now.
    pub(super) fn new(
        limits: &'a Target,
        faces_before: usize,
        observe: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Self {
        let face_target = limits.face_target(faces_before);
        Self {
            limits,
            observe,
            start: Instant::now(),
            faces_before,
            face_target,
            observed: 0,
            // The first check is immediate: the time may be over before anything is done.
            turns: OBSERVED_TURNS,
        }
    }

    pub(super) fn reached(
        &mut self,
        faces: usize,
        vertices: usize,
        collapses: usize,
    ) -> Option<StopReason> {
        let Target { vertices: fewest, collapses: most, time, .. } = *self.limits;
        if faces <= self.face_target {
            return Some(StopReason::Faces);
        }
        if fewest.is_some_and(|limit| vertices <= limit) {
            return Some(StopReason::Vertices);
        }
        if most.is_some_and(|limit| collapses >= limit) {
            return Some(StopReason::Collapses);
        }
        self.turns += 1;
        if collapses < self.observed + OBSERVED_EVERY && self.turns < OBSERVED_TURNS {
            return None;
        }
        (self.observed, self.turns) = (collapses, 0);
        if time.is_some_and(|time| self.start.elapsed() >= time) {
            return Some(StopReason::Time);
        }
        let Self { faces_before, face_target, .. } = *self;
        let phase = Phase::Collapse;
        let progress = Progress { phase, faces_before, faces, face_target, collapses };
        (self.observe)(&progress).is_break().then_some(StopReason::Cancelled)
    }

    /// The largest allowed cost.
    pub(super) fn cost(&self) -> f64 {
        self.limits.cost.unwrap_or(f64::INFINITY)
    }
}
