//! Records of measurements: JSON lines, one for each job.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use xtask_common::Failure;

/// Writes records, one a line.
pub(crate) fn write<R: Serialize>(records: &[R], path: &Path) -> Result<(), Failure> {
    let mut text = String::new();
    for record in records {
        let line = serde_json::to_string(record).map_err(Failure::numbers)?;
        let _ = writeln!(text, "{line}");
    }
    std::fs::write(path, text).map_err(Failure::writing(path))
}

/// Reads records.
pub(crate) fn read<R: DeserializeOwned>(path: &Path) -> Result<Vec<R>, Failure> {
    let text = std::fs::read_to_string(path).map_err(Failure::reading(path))?;
    let parse = |(index, line): (usize, &str)| {
        serde_json::from_str(line).map_err(|error| {
            let place = format!("{}, line {}", path.display(), index + 1);
            Failure::Usage(format!(
                "{place}: {error}; the command that reads a record also writes one"
            ))
        })
    };
    text.lines().enumerate().filter(|(_, line)| !line.is_empty()).map(parse).collect()
}
