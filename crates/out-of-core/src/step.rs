//! How far a run has come.

/// How far a run has come. It is given to an observer, which returns whether to go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// What is being done.
    pub what: &'static str,
    /// How many parts of it are done.
    pub done: u64,
    /// How many parts there are; 0 if that is unknown.
    pub of: u64,
    /// The level on which it is done.
    pub level: u32,
}
