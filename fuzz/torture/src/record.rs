//! The outcome of a run, and the files of all outcomes.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use xtask_common::{Failure, Numbers};

/// The outcome of a job on a file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Record {
    pub(super) file: String,
    /// The size of the file.
    pub(super) bytes: u64,
    pub(super) command: String,
    pub(super) job: String,
    /// The exit code of the last step; `None` if it did not exit by itself.
    pub(super) exit: Option<i32>,
    /// The fault, if any.
    pub(super) fault: Option<String>,
    /// Processor time of all steps.
    pub(super) seconds: f64,
    /// The largest resident set of any step.
    pub(super) peak_mib: f64,
    /// The faces of the outputs, as read by the other reader.
    pub(super) faces: Option<usize>,
    /// The message of a refusal.
    pub(super) message: String,
}

/// The names of the fields, in their order.
const FIELDS: [&str; 10] =
    ["file", "bytes", "command", "job", "exit", "fault", "seconds", "peak_mib", "faces", "message"];

/// Opens the file of outcomes, which is appended to as runs end, and returns the outcomes of an earlier call.
pub(super) fn open(folder: &Path, resume: bool) -> Result<(Numbers, Vec<Record>), Failure> {
    let path = path(folder);
    if !resume && path.exists() {
        std::fs::remove_file(&path).map_err(Failure::writing(&path))?;
    }
    Numbers::open(path, &FIELDS, |row| row.deserialize(None).ok())
}

/// Writes the outcomes in order, as CSV and as JSON.
pub(super) fn write(records: &[Record], folder: &Path) -> Result<(), Failure> {
    let path = path(folder);
    let failed = |error: csv::Error| Failure::writing(&path)(error);
    let mut writer = csv::Writer::from_path(&path).map_err(failed)?;
    records.iter().try_for_each(|record| writer.serialize(record)).map_err(failed)?;
    writer.flush().map_err(Failure::writing(&path))?;
    let path = folder.join("runs.json");
    let text = serde_json::to_string_pretty(records).map_err(Failure::mesh)?;
    std::fs::write(&path, text).map_err(Failure::writing(&path))
}

fn path(folder: &Path) -> PathBuf {
    folder.join("runs.csv")
}
