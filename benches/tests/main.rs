//! Tests of the command line.
#![allow(clippy::unwrap_used)]

use std::process::Command;

use mesh_core::{Repair, build};

#[test]
fn a_giant_is_a_closed_mesh_with_about_the_faces_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("giant.ply");
    let mut giant = Command::new(env!("CARGO_BIN_EXE_benches"));
    giant.args(["giant", "--faces", "2000", "-o"]).arg(&path);
    assert!(giant.output().unwrap().status.success());
    let mesh = build(&mesh_io::read(&path).unwrap().soup, &Repair::strict()).unwrap().mesh;
    let topology = mesh.topology();
    assert!((1800..2200).contains(&topology.face_count()), "{}", topology.face_count());
    assert_eq!((topology.genus(), topology.boundaries().count()), (1, 0));
}
