//! Functions that run the program and find the real meshes.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use mesh_core::PolygonSoup;
use mesh_io::{Model, WriteOptions};

/// The folder of real meshes, or `None` with a note that the test is skipped.
pub(crate) fn models() -> Option<PathBuf> {
    let folder = std::env::var_os("CURVMESH_MODELS").map(PathBuf::from).filter(|f| f.is_dir());
    if folder.is_none() {
        println!("skipped: set CURVMESH_MODELS to a folder of meshes");
    }
    folder
}

/// The files of a folder, in order.
pub(crate) fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut files: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    files.sort();
    files
}

pub(crate) fn curvmesh(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_curvmesh")).args(arguments).output().unwrap()
}

/// Runs and returns the exit code and the output.
pub(crate) fn code(arguments: &[&str]) -> (i32, String) {
    let output = curvmesh(arguments);
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

/// Runs with `--json` and returns the object.
pub(crate) fn json(arguments: &[&str]) -> serde_json::Value {
    let output = curvmesh(&[arguments, &["--json"]].concat());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    serde_json::from_slice(&output.stdout).unwrap()
}

pub(crate) fn name(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

pub(crate) fn write(soup: PolygonSoup, path: &Path) {
    mesh_io::write(path, &Model::from(soup), &WriteOptions::default()).unwrap();
}
