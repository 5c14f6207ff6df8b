//! What a run of collapses did: its log, the levels that the log leads to, and why the run stopped.

pub(crate) mod level;
pub(crate) mod log;
pub(crate) mod run;
pub(crate) mod snapshot;
pub(crate) mod target;
