//! Signals that end the program, such as Ctrl-C: the program ends between files, never while it writes one.
//!
//! A file is written under another name and then renamed. A program that ends in between would leave half a file under
//! that name.

use std::io::{IsTerminal, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError, RwLock};

use crate::text::printable;

/// The exit code after Ctrl-C: 128 and the number of the signal.
pub(crate) const INTERRUPTED: u8 = 130;

/// Threads that write a file hold a shared lock. With the exclusive lock, no thread is writing.
static WRITING: RwLock<()> = RwLock::new(());

/// The files that have been written.
static WRITTEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The folders for temporary files.
static SCRATCH: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Whether the first signal asks for the best result so far.
static KEEPS_PARTIAL: AtomicBool = AtomicBool::new(false);

/// Whether the best result was asked for.
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

/// Installs the signal handling. A signal ends the program as soon as no file is being written, and the written files
/// are listed. Or the first signal asks for the best result so far.
pub(crate) fn watch(keeps_partial: bool) {
    KEEPS_PARTIAL.store(keeps_partial, Ordering::SeqCst);
    // If this fails, the system ends the program, which is equivalent unless a file is being written.
    #[cfg(unix)]
    if let Ok(mut signals) = signal_hook::iterator::Signals::new(wanted_signals()) {
        let wait = move || signals.forever().for_each(end);
        let _ = std::thread::Builder::new().spawn(wait);
    }
    #[cfg(not(unix))]
    let _ = ctrlc::set_handler(|| end(i32::from(INTERRUPTED) - 128));
}

/// The signals that end the program: Ctrl-C, a scheduler, a terminal that closes. Under `nohup` the last one stays
/// ignored.
#[cfg(unix)]
fn wanted_signals() -> Vec<i32> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    let ignores_hang_up = ignored >> (SIGHUP - 1) & 1 == 1;
    let hang_up = (!ignores_hang_up).then_some(SIGHUP);
    [SIGINT, SIGTERM].into_iter().chain(hang_up).collect()
}

/// Ends the program on a signal.
fn end(signal: i32) {
    // A progress bar leaves its line unfinished.
    let line = if std::io::stderr().is_terminal() { "\n" } else { "" };
    // If the terminal is closed, the message is lost.
    let say = |text: &str| drop(writeln!(std::io::stderr(), "{line}interrupted: {text}"));
    if KEEPS_PARTIAL.load(Ordering::SeqCst) && !IS_ASKED.swap(true, Ordering::SeqCst) {
        say("writing the best so far; again to end at once");
        return;
    }
    let _nobody_writes = WRITING.write().unwrap_or_else(PoisonError::into_inner);
    let written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
    for folder in SCRATCH.lock().unwrap_or_else(PoisonError::into_inner).iter() {
        // The run continues in the meantime, and may add to the folder.
        let mut tries = 0..3;
        while folder.exists() && tries.next().is_some() {
            let _ = std::fs::remove_dir_all(folder);
        }
    }
    say(&outcome(&written));
    std::process::exit(128 + signal);
}

/// A signal will remove this folder for temporary files.
pub(crate) fn removes(scratch: &Path) {
    SCRATCH.lock().unwrap_or_else(PoisonError::into_inner).push(scratch.to_owned());
}

/// Whether the run was interrupted and should end with the best result so far.
pub(crate) fn is_asked_to_end() -> bool {
    IS_ASKED.load(Ordering::Relaxed)
}

/// Whether a run should continue.
pub(crate) fn flow() -> ControlFlow<()> {
    if is_asked_to_end() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// Writes a file; an interruption waits for it.
pub(crate) fn while_writing<T, E>(
    path: &Path,
    write: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    while_writing_all(&[path], write)
}

/// Writes files; an interruption waits for all of them. It waits for no pipe, which may have no reader.
pub(crate) fn while_writing_all<T, E>(
    paths: &[&Path],
    write: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    let is_device = |path: &&Path| path.metadata().is_ok_and(|m| !m.is_file() && !m.is_dir());
    let waits = !paths.iter().any(is_device);
    let _writing = waits.then(|| WRITING.read().unwrap_or_else(PoisonError::into_inner));
    let result = write()?;
    let mut written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
    written.extend(paths.iter().map(|path| path.to_path_buf()));
    Ok(result)
}

fn outcome(written: &[PathBuf]) -> String {
    /// Only this number of names is printed.
    const MOST_NAMES: usize = 5;
    let names: Vec<String> = written.iter().map(|path| printable(path.display())).collect();
    match &names[..] {
        [] => "nothing was written".into(),
        [name] => format!("only {name} was written"),
        names if names.len() <= MOST_NAMES => format!("only {} were written", names.join(", ")),
        names => format!("{} files were written, all of them whole", names.len()),
    }
}
