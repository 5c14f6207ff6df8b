//! A job with its outcome: one line of a record.

use serde::{Deserialize, Serialize};

use crate::machine::Machine;
use crate::timing::Cost;

/// A job and its outcome. `J` describes the job, `V` has what was measured of the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Record<J, V> {
    /// The name of the tool on the command line.
    pub(super) tool: String,
    /// Its version, if it can be had.
    pub(super) version: Option<String>,
    pub(super) job: J,
    pub(super) repeats: usize,
    /// Jobs that take longer are ended.
    pub(super) limit_seconds: u64,
    pub(super) machine: Machine,
    /// How many programs wanted to work, on average over the minute before the job, if the system reports it.
    pub(super) load: Option<f64>,
    /// None if the job failed.
    pub(super) outcome: Option<Outcome<V>>,
    /// Why the job failed.
    pub(super) failure: Option<String>,
}

/// What a job cost and left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Outcome<V> {
    pub(super) cost: Cost,
    pub(super) values: V,
}

impl<J, V> Record<J, V> {
    /// The time of the core that worked, if it is known.
    pub(super) fn time(&self) -> Option<f64> {
        let cost = self.outcome.as_ref()?.cost;
        Some(cost.cpu.unwrap_or(cost.seconds))
    }
}
