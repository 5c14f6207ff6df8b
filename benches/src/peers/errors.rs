//! Distances and normals, measured by independent code.

use std::path::Path;

use super::environment::Environment;
use xtask_common::Failure;

/// Distances between a result and its original, in both directions. The diagonal is one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors {
    /// The mean, averaged over the two directions.
    pub(super) mean: f64,
    pub(super) rms: f64,
    pub(super) max: f64,
    /// The mean angle between normals at nearest points, in degrees.
    pub(super) normals: f64,
}

/// Measures two raw meshes.
pub(super) fn measure(
    environment: &Environment,
    original: &Path,
    result: &Path,
) -> Result<Errors, Failure> {
    let text = environment.python("errors.py", &[original.as_os_str(), result.as_os_str()]);
    let text = text.map_err(Failure::Usage)?;
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    match numbers[..] {
        [mean, rms, max, normals] => Ok(Errors { mean, rms, max, normals }),
        _ => Err(Failure::Usage(format!("errors.py answers {text:?}"))),
    }
}
