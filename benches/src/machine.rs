//! The machine of a measurement.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Where a job ran.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Machine {
    pub(crate) cores: usize,
    pub(crate) cpu: Option<String>,
}

impl Machine {
    /// This one.
    pub(crate) fn this() -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let cpu = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        Self { cores, cpu: cpu.map(|(_, name)| name.trim().to_owned()) }
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cpu = self.cpu.as_deref().unwrap_or("unknown processor");
        write!(f, "{cpu}, {} cores", self.cores)
    }
}

/// How many programs wanted to work, on average over the last minute, if the system reports it.
pub(crate) fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}
