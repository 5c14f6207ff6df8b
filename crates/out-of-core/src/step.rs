//! The progress of a run.

/// The progress of a run. An observer receives it, and returns whether to go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The current task.
    pub what: &'static str,
    /// The number of finished parts of it.
    pub done: u64,
    /// The number of its parts; 0 if unknown.
    pub of: u64,
    /// The level of the task.
    pub level: u32,
}
