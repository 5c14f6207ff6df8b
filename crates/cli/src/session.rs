//! What a run has besides the options of its command.

use crate::console::Console;
use crate::given::Given;
use crate::interrupt::is_asked_to_end;

/// A run of the program.
#[derive(Debug)]
pub(crate) struct Session {
    pub(crate) console: Console,
    pub(crate) given: Given,
    /// How many files are worked on at a time.
    pub(crate) threads: usize,
}

/// How a run that has reported its results ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Done,
    /// Of many files, some could not be processed.
    SomeFailed,
    /// It was interrupted, and has written what was best by then.
    Interrupted,
}

impl Outcome {
    /// The outcome of a run without failures.
    pub(crate) fn of_run() -> Self {
        if is_asked_to_end() { Self::Interrupted } else { Self::Done }
    }
}
