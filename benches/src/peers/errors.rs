//! Distances and normals, measured by independent code.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::environment::Environment;
use crate::process::Process;

/// Distances between a result and its original, in both directions. The diagonal is one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Errors {
    /// The mean, averaged over the two directions.
    pub(super) mean: f64,
    pub(super) rms: f64,
    pub(super) max: f64,
    /// The mean angle between normals at nearest points, in degrees.
    pub(super) normals: f64,
}

/// The seed of the points at which distances are measured.
pub(super) const SEED: u64 = 1;

/// Measures results of one original. Points of the original are found once.
pub(super) struct Meter<'e> {
    environment: &'e Environment,
    original: &'e Path,
    /// None before the first request and after a crash.
    process: Option<Process>,
}

impl<'e> Meter<'e> {
    /// For an original as a raw mesh.
    pub(super) fn new(environment: &'e Environment, original: &'e Path) -> Self {
        Self { environment, original, process: None }
    }

    /// Measures a result.
    pub(super) fn measure(&mut self, result: &Path) -> Result<Errors, String> {
        if self.process.is_none() {
            let seed = SEED.to_string();
            let arguments = [self.original.as_os_str(), seed.as_ref()];
            let mut command = self.environment.script("errors.py", &arguments);
            self.process = Some(Process::start(&mut command).map_err(|e| e.to_string())?);
        }
        let answer = self.process.as_mut().and_then(|process| {
            let request = result.to_str()?;
            process.ask(request)
        });
        let Some(answer) = answer else {
            self.process = None;
            return Err("the distances cannot be measured: errors.py ended".into());
        };
        let numbers: Vec<f64> = answer.split_whitespace().filter_map(|w| w.parse().ok()).collect();
        match numbers[..] {
            [mean, rms, max, normals] => Ok(Errors { mean, rms, max, normals }),
            _ => Err(format!("the distances cannot be measured: {}", answer.trim())),
        }
    }
}
