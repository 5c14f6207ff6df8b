//! The output of other programs.

use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What a command prints, or the last line of its error messages.
pub(crate) fn command_output(command: &mut Command) -> Result<Vec<u8>, String> {
    let output = command.output().map_err(|e| format!("{:?}: {e}", command.get_program()))?;
    if output.status.success() {
        return Ok(output.stdout);
    }
    Err(complaint(&output.stderr))
}

fn complaint(said: &[u8]) -> String {
    let said = String::from_utf8_lossy(said);
    said.lines().last().unwrap_or("it failed without a word").to_owned()
}

/// The text that a command prints, or the last line of its error messages. It is ended if it takes longer than a limit.
pub(crate) fn output_within(command: &mut Command, limit: Duration) -> Result<String, String> {
    const PAUSE: Duration = Duration::from_millis(5);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|e| format!("{:?}: {e}", command.get_program()))?;
    let [out, err] = [read_all(child.stdout.take()), read_all(child.stderr.take())];
    let start = Instant::now();
    let status = loop {
        match child.try_wait().map_err(|e| e.to_string())? {
            Some(status) => break status,
            None if start.elapsed() > limit => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("not done after {} s", limit.as_secs()));
            }
            None => std::thread::sleep(PAUSE),
        }
    };
    let [out, err] = [out, err].map(|text| text.join().unwrap_or_default());
    if status.success() {
        Ok(String::from_utf8_lossy(&out).into_owned())
    } else {
        Err(complaint(&err))
    }
}

/// Reads a pipe to its end, so that the other side never waits.
fn read_all<R: Read + Send + 'static>(pipe: Option<R>) -> std::thread::JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            // What was read before an error counts.
            let _ = pipe.read_to_end(&mut bytes);
        }
        bytes
    })
}

/// A command that is restricted to some cores, if the system supports it, and works in a folder.
pub(crate) fn on_cores(threads: usize, program: &Path, folder: &Path) -> Command {
    let has_taskset = succeed(Command::new("taskset").arg("--version")).is_ok();
    let mut command = if has_taskset {
        let mut command = Command::new("taskset");
        command.args(["-c", &format!("0-{}", threads.max(1) - 1)]).arg(program);
        command
    } else {
        Command::new(program)
    };
    command.env("OMP_NUM_THREADS", threads.to_string()).current_dir(folder);
    command
}

/// The text that a header defines a name as.
pub(crate) fn defined(header: &str, name: &str) -> Option<String> {
    let words = header.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    words.into_iter().find_map(|words| match words[..] {
        ["#define", defined, value] if defined == name => Some(value.to_owned()),
        _ => None,
    })
}

/// The text that a command prints, or the last line of its error messages.
pub(crate) fn succeed(command: &mut Command) -> Result<String, String> {
    Ok(String::from_utf8_lossy(&command_output(command)?).into_owned())
}

#[cfg(test)]
mod tests {
    use std::process::Command;
    use std::time::Duration;

    use super::{defined, output_within};

    #[test]
    fn a_command_that_takes_too_long_is_ended() {
        let quick = output_within(Command::new("echo").arg("done"), Duration::from_secs(60));
        assert_eq!(quick.as_deref(), Ok("done\n"));
        let slow = output_within(Command::new("sleep").arg("60"), Duration::from_millis(50));
        assert_eq!(slow, Err("not done after 0 s".to_owned()));
        let failing = output_within(&mut Command::new("false"), Duration::from_secs(60));
        assert_eq!(failing, Err("it failed without a word".to_owned()));
    }

    #[test]
    fn versions_are_read_from_headers() {
        let header = "#define CGAL_VERSION_NR 1060101000\n#define CGAL_VERSION 6.1\n";
        assert_eq!(defined(header, "CGAL_VERSION").as_deref(), Some("6.1"));
        assert_eq!(defined(header, "CGAL"), None);
    }
}
