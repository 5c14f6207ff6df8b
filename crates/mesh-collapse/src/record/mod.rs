//! Records of runs: the log of the collapses, the levels made from it, and the reason for the end of a run.

pub(crate) mod level;
pub(crate) mod log;
pub(crate) mod run;
pub(crate) mod snapshot;
pub(crate) mod target;
