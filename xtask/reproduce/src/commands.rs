//! Runs the commands that the page shows, for tests.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use mesh_core::TriMesh;

/// Has the words of the command, one a line.
const COMMAND: &str = "REPRODUCE_COMMAND";

/// Runs a command with its meshes in a folder, in a process of its own, as a program does.
pub(crate) fn run_in(folder: &Path, command: &str) {
    let word = |word: &str| match word.ends_with(".ply") {
        true => folder.join(word).display().to_string(),
        false => word.to_owned(),
    };
    let words: Vec<String> = command.split_whitespace().map(word).collect();
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["--ignored", "--exact", "commands::one_command"]).env(COMMAND, words.join("\n"));
    let output = child.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.contains("1 passed"), "{command}: {text}");
}

#[test]
#[ignore = "a process of the other tests"]
fn one_command() {
    let words = std::env::var(COMMAND).unwrap();
    let words: Vec<OsString> = words.lines().map(OsString::from).collect();
    assert_eq!(curvmesh_cli::run_program(&words), 0);
}

/// A mesh of the folder.
pub(crate) fn read_in(folder: &Path, name: &str) -> TriMesh {
    TriMesh::from_soup(&mesh_io::read(folder.join(name)).unwrap().soup).unwrap()
}
