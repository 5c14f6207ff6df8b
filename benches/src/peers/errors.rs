//! Distances and normals, measured by independent code.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::environment::Environment;

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

/// Measures two raw meshes.
pub(super) fn measure(
    environment: &Environment,
    original: &Path,
    result: &Path,
) -> Result<Errors, String> {
    let seed = SEED.to_string();
    let arguments = [original.as_os_str(), result.as_os_str(), seed.as_ref()];
    let text = environment.python("errors.py", &arguments)?;
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    match numbers[..] {
        [mean, rms, max, normals] => Ok(Errors { mean, rms, max, normals }),
        _ => Err(format!("errors.py answers {text:?}")),
    }
}
