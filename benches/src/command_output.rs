//! The output of other programs.

use std::path::Path;
use std::process::Command;

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
    use super::defined;

    #[test]
    fn versions_are_read_from_headers() {
        let header = "#define CGAL_VERSION_NR 1060101000\n#define CGAL_VERSION 6.1\n";
        assert_eq!(defined(header, "CGAL_VERSION").as_deref(), Some("6.1"));
        assert_eq!(defined(header, "CGAL"), None);
    }
}
