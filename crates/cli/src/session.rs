//! What a run has besides the options of its command.

use std::num::NonZero;

use rayon::ThreadPoolBuilder;

use crate::console::Console;
use crate::failure::Failure;
use crate::given::Given;
use crate::interrupt::is_asked_to_end;

/// A run of the program.
#[derive(Debug)]
pub(crate) struct Session {
    pub(crate) console: Console,
    pub(crate) given: Given,
    /// How many threads there are to be, if that was said.
    pub(crate) threads: Option<NonZero<usize>>,
}

impl Session {
    /// This run, whose work this thread hands out, which does a share of it itself: from a thread that is not one of
    /// those that compute, every loop over elements would cost a change of threads there and back.
    pub(crate) fn on_one_thing(&self) -> Result<&Self, Failure> {
        self.pool().use_current_thread().build_global().map_err(Failure::pool)?;
        Ok(self)
    }

    /// This run, whose work other threads hand out while this one waits for them.
    pub(crate) fn on_many_files(&self) -> Result<&Self, Failure> {
        self.pool().build_global().map_err(Failure::pool)?;
        Ok(self)
    }

    fn pool(&self) -> ThreadPoolBuilder {
        ThreadPoolBuilder::new().num_threads(self.threads.map_or(0, NonZero::get))
    }

    /// How many files are worked on at a time.
    pub(crate) fn files_at_a_time(&self) -> usize {
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        self.threads.map_or(cores, NonZero::get)
    }
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
