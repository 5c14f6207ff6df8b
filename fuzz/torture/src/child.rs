//! Runs one process under limits.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use wait4::Wait4;

/// The limits of a process.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Processor time, user and system.
    pub(super) processor: Duration,
    /// Bytes of address space.
    pub(super) address_space: u64,
}

/// Largest ratio of wall-clock time to processor time: the machine is shared with other processes.
const PATIENCE: u32 = 5;

/// How a process ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    Exit(i32),
    Signal(i32),
    /// It ran out of processor time, or waited forever.
    OutOfTime,
}

/// The result of a process.
#[derive(Debug)]
pub(super) struct Ended {
    pub(super) end: End,
    pub(super) stdout: String,
    pub(super) stderr: String,
    /// Processor time, user and system.
    pub(super) processor: Duration,
    /// The largest resident set in bytes, as last seen.
    pub(super) peak: u64,
}

/// Runs a program to its end. Its output goes through files in `folder`, so that it never waits
/// for a reader.
///
/// The shell sets the limits, which the program inherits.
pub(super) fn run(
    program: &Path,
    arguments: &[String],
    folder: &Path,
    limits: Limits,
) -> std::io::Result<Ended> {
    let [stdout, stderr] = ["stdout", "stderr"].map(|name| folder.join(name));
    let script = format!(
        "ulimit -v {} && ulimit -t {} && ulimit -c 0 && exec \"$@\"",
        limits.address_space >> 10,
        limits.processor.as_secs().max(1),
    );
    let mut child = Command::new("sh")
        .args(["-c", &script, "sh"])
        .arg(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(File::create(&stdout)?)
        .stderr(File::create(&stderr)?)
        .spawn()?;
    let start = Instant::now();
    let mut is_killed = false;
    let mut pause = Duration::from_millis(1);
    let mut peak = 0;
    let used = loop {
        if let Some(used) = child.try_wait4()? {
            break used;
        }
        peak = high_water(child.id()).unwrap_or(0).max(peak);
        if start.elapsed() > limits.processor * PATIENCE && !is_killed {
            is_killed = true;
            child.kill()?;
        }
        sleep(pause);
        pause = (2 * pause).min(Duration::from_millis(20));
    };
    let processor = used.rusage.utime + used.rusage.stime;
    Ok(Ended {
        end: end(used.status, is_killed || processor >= limits.processor),
        stdout: String::from_utf8_lossy(&std::fs::read(&stdout)?).into_owned(),
        stderr: String::from_utf8_lossy(&std::fs::read(&stderr)?).into_owned(),
        processor,
        peak,
    })
}

/// The largest resident set of a process so far. The value available after its end is at least the largest one of its
/// parent process.
fn high_water(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? << 10)
}

fn end(status: std::process::ExitStatus, is_out_of_time: bool) -> End {
    match status.code() {
        Some(code) => End::Exit(code),
        None if is_out_of_time => End::OutOfTime,
        None => End::Signal(signal(status)),
    }
}

#[cfg(unix)]
fn signal(status: std::process::ExitStatus) -> i32 {
    std::os::unix::process::ExitStatusExt::signal(&status).unwrap_or_default()
}

#[cfg(not(unix))]
fn signal(_: std::process::ExitStatus) -> i32 {
    0
}
