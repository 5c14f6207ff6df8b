//! The state of a run besides the options of its command.

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
    /// The number of threads, if given.
    pub(crate) threads: Option<NonZero<usize>>,
}

impl Session {
    /// This run on one file. This thread distributes the work and takes part in it: from a thread outside the pool,
    /// every loop over elements would cost two thread switches.
    pub(crate) fn on_one_thing(&self) -> Result<&Self, Failure> {
        self.pool().use_current_thread().build_global().map_err(Failure::pool)?;
        Ok(self)
    }

    /// This run on many files. Other threads distribute the work while this one waits for them.
    pub(crate) fn on_many_files(&self) -> Result<&Self, Failure> {
        self.pool().build_global().map_err(Failure::pool)?;
        Ok(self)
    }

    fn pool(&self) -> ThreadPoolBuilder {
        // Beyond this, threads only look for work: a tiny mesh would take seconds with 1024 of them on two cores.
        let most = 128.max(2 * cores());
        ThreadPoolBuilder::new().num_threads(self.threads.map_or(0, |n| n.get().min(most)))
    }

    /// The number of files processed in parallel.
    pub(crate) fn files_at_a_time(&self) -> usize {
        self.threads.map_or_else(cores, NonZero::get)
    }
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

/// The outcome of a run that has reported its results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Done,
    /// Of many files, some could not be processed.
    SomeFailed,
    /// The run was interrupted, and has written the best result so far.
    Interrupted,
}

impl Outcome {
    /// The outcome of a run without failures.
    pub(crate) fn of_run() -> Self {
        if is_asked_to_end() { Self::Interrupted } else { Self::Done }
    }
}
