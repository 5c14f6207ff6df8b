//! Ctrl-C: the program ends between files, never within one.
//!
//! A file is written beside its target and then takes its place. Ended in between, the program would
//! leave half a file behind under another name.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The exit code of a program that was interrupted: 128 and the number of the signal.
const INTERRUPTED: i32 = 130;

/// The files that have been written. Held while another one is.
static WRITTEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// From now on, Ctrl-C ends the program as soon as no file is being written, and says which were.
pub(crate) fn watch() {
    // Without it the system ends the program, which does as well unless a file is being written.
    let _ = ctrlc::set_handler(|| {
        let written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
        // A progress bar leaves its line unfinished.
        let line = if std::io::stderr().is_terminal() { "\n" } else { "" };
        eprintln!("{line}interrupted: {}", outcome(&written));
        std::process::exit(INTERRUPTED);
    });
}

/// Writes a file, which an interruption waits for.
pub(crate) fn while_writing<T, E>(
    path: &Path,
    write: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    while_writing_all(&[path], write)
}

/// Writes files, all of which an interruption waits for.
pub(crate) fn while_writing_all<T, E>(
    paths: &[&Path],
    write: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    let mut written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
    let result = write()?;
    written.extend(paths.iter().map(|path| path.to_path_buf()));
    Ok(result)
}

fn outcome(written: &[PathBuf]) -> String {
    if written.is_empty() {
        return "nothing was written".into();
    }
    let names: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    format!("only {} was written", names.join(", "))
}
