//! Ctrl-C: the program ends between files, never within one.
//!
//! A file is written beside its target and then takes its place. Ended in between, the program would
//! leave half a file behind under another name.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError, RwLock};

use out_of_core::ScratchFolder;

use crate::text::printable;

/// The exit code of a program that was interrupted: 128 and the number of the signal.
pub(crate) const INTERRUPTED: u8 = 130;

/// Shared by those who write a file; who has it alone knows that nobody does.
static WRITING: RwLock<()> = RwLock::new(());

/// The files that have been written.
static WRITTEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The folders of what is needed for a while.
static SCRATCH: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Whether the first Ctrl-C asks for what is best so far.
static KEEPS_PARTIAL: AtomicBool = AtomicBool::new(false);

/// Whether it has been asked for.
static IS_ASKED: AtomicBool = AtomicBool::new(false);

/// What Ctrl-C does to a run that gets better and better.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct Interruption {
    /// On Ctrl-C write the best so far instead of nothing; a second Ctrl-C ends at once
    #[arg(long, help_heading = None)]
    pub(crate) keep_partial: bool,
}

/// The field of [`Interruption`].
pub(crate) const KEEP_PARTIAL: &str = "keep_partial";

/// From now on, Ctrl-C ends the program as soon as no file is being written, and says which were. Or
/// it asks for the best so far first.
pub(crate) fn watch(keeps_partial: bool) {
    KEEPS_PARTIAL.store(keeps_partial, Ordering::SeqCst);
    // Without it the system ends the program, which does as well unless a file is being written.
    let _ = ctrlc::set_handler(|| {
        // A progress bar leaves its line unfinished.
        let line = if std::io::stderr().is_terminal() { "\n" } else { "" };
        if KEEPS_PARTIAL.load(Ordering::SeqCst) && !IS_ASKED.swap(true, Ordering::SeqCst) {
            eprintln!("{line}interrupted: writing the best so far; again to end at once");
            return;
        }
        let _nobody_writes = WRITING.write().unwrap_or_else(PoisonError::into_inner);
        let written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
        for folder in SCRATCH.lock().unwrap_or_else(PoisonError::into_inner).iter() {
            // The run goes on meanwhile, and may add to it.
            let mut tries = 0..3;
            while folder.exists() && tries.next().is_some() {
                ScratchFolder::remove(folder);
            }
        }
        eprintln!("{line}interrupted: {}", outcome(&written));
        std::process::exit(i32::from(INTERRUPTED));
    });
}

/// An interruption removes this folder of what is needed for a while.
pub(crate) fn removes(scratch: &Path) {
    SCRATCH.lock().unwrap_or_else(PoisonError::into_inner).push(scratch.to_owned());
}

/// Whether the run was interrupted and is to end with what is best so far.
pub(crate) fn is_asked_to_end() -> bool {
    IS_ASKED.load(Ordering::Relaxed)
}

/// Whether a run goes on.
pub(crate) fn flow() -> ControlFlow<()> {
    if is_asked_to_end() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
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
    let _writing = WRITING.read().unwrap_or_else(PoisonError::into_inner);
    let result = write()?;
    let mut written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
    written.extend(paths.iter().map(|path| path.to_path_buf()));
    Ok(result)
}

fn outcome(written: &[PathBuf]) -> String {
    /// More than these are counted only.
    const MOST_NAMES: usize = 5;
    let names: Vec<String> = written.iter().map(|path| printable(path.display())).collect();
    match &names[..] {
        [] => "nothing was written".into(),
        [name] => format!("only {name} was written"),
        names if names.len() <= MOST_NAMES => format!("only {} were written", names.join(", ")),
        names => format!("{} files were written, all of them whole", names.len()),
    }
}
