//! Ctrl-C in the middle of a run.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)]

use std::io::Read;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use crate::common::{files, json, write};
use mesh_shapes::Torus;

/// Whether a signal is in a set of signals of a process, such as `SigCgt:` or `SigIgn:`.
fn is_set(set: &str, process: u32, signal: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix(set)).unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap() & (1 << (signal - 1)) != 0
}

/// Whether a process handles SIGINT and SIGTERM, 2 and 15.
fn catches_signals(process: u32) -> bool {
    [2, 15].into_iter().all(|signal| is_set("SigCgt:", process, signal))
}

/// Starts a run and sends it Ctrl-C once it can be interrupted and is ready.
fn interrupted(
    arguments: &[&str],
    files: [&Path; 2],
    is_ready: impl Fn() -> bool,
) -> (Option<i32>, Output) {
    signalled("INT", arguments, files, is_ready)
}

/// Starts a run and sends it a signal once it can be interrupted and is ready.
fn signalled(
    signal: &str,
    arguments: &[&str],
    files: [&Path; 2],
    is_ready: impl Fn() -> bool,
) -> (Option<i32>, Output) {
    let mut run = Command::new(env!("CARGO_BIN_EXE_curvmesh"));
    run.args(arguments).arg(files[0]).arg("-o").arg(files[1]);
    let mut run = run.stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    while !(catches_signals(run.id()) && is_ready()) {
        assert!(run.try_wait().unwrap().is_none(), "the run has ended before the signal");
        std::thread::sleep(Duration::from_millis(5));
    }
    let kill =
        Command::new("kill").args([&format!("-{signal}"), &run.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let ended = run.wait_with_output().unwrap();
    (ended.status.code(), ended)
}

#[test]
fn an_interrupted_run_keeps_the_best_so_far_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.ply", "out.ply"].map(|name| folder.path().join(name));
    write(Torus { major: 5.0, minor: 2.0 }.shifted_mesh(300, 150).unwrap(), &input);
    for arguments in [
        &["simplify", "--preset", "paper-l1", "--faces", "100"][..],
        &["flip", "--cost", "f1", "--anneal-steps", "10000"],
    ] {
        let arguments = [arguments, &["--keep-partial", "--json"]].concat();
        let (code, ended) = interrupted(&arguments, [&input, &output], || true);
        let said = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(code, Some(130), "{said}");
        assert!(said.contains("writing the best so far"), "{said}");
        let report: serde_json::Value = serde_json::from_slice(&ended.stdout).unwrap();
        assert_eq!(report["stop"], "cancelled", "{report}");
        let faces = json(&["info", output.to_str().unwrap()])["faces"].as_u64().unwrap();
        assert!(faces > 100 && faces <= 90_000, "{faces}");
        assert_eq!(files(folder.path()), [input.clone(), output.clone()]);
    }
}

#[test]
fn an_interrupted_run_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.ply", "out.ply"].map(|name| folder.path().join(name));
    write(Torus { major: 5.0, minor: 2.0 }.mesh(1000, 500).unwrap(), &input);
    std::fs::write(&output, "what was there before").unwrap();
    let arguments = ["simplify", "--preset", "paper-l1", "--faces", "100"];
    let (code, ended) = interrupted(&arguments, [&input, &output], || true);
    let said = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(code, Some(130), "{said}");
    assert!(said.contains("interrupted: nothing was written"), "{said}");
    assert_eq!(files(folder.path()), [input, output.clone()]);
    assert_eq!(std::fs::read_to_string(output).unwrap(), "what was there before");
}

/// The folder of a streamed mesh is removed too.
#[test]
fn an_interrupted_stream_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.ply", "out.ply"].map(|name| folder.path().join(name));
    write(Torus { major: 5.0, minor: 2.0 }.mesh(1000, 500).unwrap(), &input);
    let is_ready = || {
        let mut entries = std::fs::read_dir(folder.path()).unwrap();
        entries.any(|entry| entry.unwrap().path().join("mesh").exists())
    };
    // Under `nohup` the program keeps ignoring the hang-up signal.
    let hang_up = (!is_set("SigIgn:", std::process::id(), 1)).then_some(("HUP", 129));
    for (signal, expected) in [("INT", 130), ("TERM", 143)].into_iter().chain(hang_up) {
        let arguments = ["curvature", "--memory", "31MiB"];
        let (code, ended) = signalled(signal, &arguments, [&input, &output], is_ready);
        let said = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(code, Some(expected), "{said}");
        assert_eq!(files(folder.path()), std::slice::from_ref(&input));
    }
}

/// A reader that has stopped to read blocks the program; a signal ends it all the same.
#[test]
fn a_signal_ends_a_run_that_waits_for_the_reader_of_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.ply", "out.ply"].map(|name| folder.path().join(name));
    // A pipe holds 64 KiB, and the mesh takes more.
    write(Torus { major: 5.0, minor: 2.0 }.mesh(200, 100).unwrap(), &input);
    assert!(Command::new("mkfifo").arg(&output).status().unwrap().success());
    let mut run = Command::new(env!("CARGO_BIN_EXE_curvmesh"));
    run.arg("convert").arg(&input).arg("-o").arg(&output).stderr(Stdio::piped());
    let run = run.spawn().unwrap();
    let mut reader = std::fs::File::open(&output).unwrap();
    reader.read_exact(&mut [0; 4]).unwrap();
    let kill = Command::new("kill").args(["-TERM", &run.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let ended = run.wait_with_output().unwrap();
    let said = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(143), "{said}");
    assert!(said.contains("interrupted: nothing was written"), "{said}");
    assert_eq!(files(folder.path()), [input, output]);
}
