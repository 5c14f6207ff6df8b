//! The outcome of a run, and the files that hold all of them.

use std::path::Path;

use serde::Serialize;

use crate::failure::Failure;

/// The outcome of a job on a file.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Record {
    pub(super) file: String,
    /// The size of the file.
    pub(super) bytes: u64,
    pub(super) command: String,
    pub(super) job: String,
    /// The exit code of the last step that ran; nothing when it did not come to an end by itself.
    pub(super) exit: Option<i32>,
    /// What is wrong, if anything is.
    pub(super) fault: Option<String>,
    /// Processor time of all steps.
    pub(super) seconds: f64,
    /// The largest resident set of any step.
    pub(super) peak_mib: f64,
    /// The faces of the outputs, as read by the other reader.
    pub(super) faces: Option<usize>,
    /// What the program said when it refused.
    pub(super) message: String,
}

/// Writes the outcomes as CSV and as JSON.
pub(super) fn write(records: &[Record], folder: &Path) -> Result<(), Failure> {
    let path = folder.join("runs.csv");
    let failed = |error: csv::Error| Failure::writing(&path)(error.into());
    let mut writer = csv::Writer::from_path(&path).map_err(failed)?;
    records.iter().try_for_each(|record| writer.serialize(record)).map_err(failed)?;
    writer.flush().map_err(Failure::writing(&path))?;
    let path = folder.join("runs.json");
    let text = serde_json::to_string_pretty(records).map_err(Failure::mesh)?;
    std::fs::write(&path, text).map_err(Failure::writing(&path))
}
