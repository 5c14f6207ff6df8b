//! Every command of `docs/questions.md` runs.
#![allow(clippy::unwrap_used)]
#![cfg(unix)]

use std::path::Path;
use std::process::Command;

use crate::common::{json, write};
use mesh_core::{Repair, build};
use mesh_io::{Model, WriteOptions};
use mesh_shapes::{Saddle, Torus, polyhedra};

const QUESTIONS: &str = include_str!("../../../docs/questions.md");

/// The files that the commands name.
fn files(folder: &Path) {
    let torus = Torus { major: 5.0, minor: 2.0 };
    write(torus.mesh(60, 30).unwrap(), &folder.join("scan.ply"));
    write(polyhedra::cube(), &folder.join("part.stl"));
    let open = Saddle { coefficient: 0.5, half_width: 1.0 }.mesh(12, Default::default()).unwrap();
    write(open, &folder.join("open.ply"));
    let soup = torus.mesh(40, 20).unwrap();
    let corners = soup.corners().iter().map(|&v| soup.positions()[v as usize]);
    let uvs = corners.map(|p| [p.x, p.y].map(|x| x as f32)).collect();
    let truck = Model { corner_uvs: Some(uvs), ..Model::from(soup) };
    mesh_io::write(folder.join("truck.glb"), &truck, &WriteOptions::default()).unwrap();
}

#[test]
fn every_command_runs() {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path());
    let program = Path::new(env!("CARGO_BIN_EXE_curvmesh")).parent().unwrap().to_owned();
    let mut path = program.into_os_string();
    path.push(":");
    path.push(std::env::var_os("PATH").unwrap_or_default());
    let mut count = 0;
    for block in QUESTIONS.split("```sh\n").skip(1) {
        for line in block.split("```").next().unwrap().lines() {
            let mut shell = Command::new("sh");
            let run = shell.args(["-c", line]).current_dir(&folder).env("PATH", &path);
            let output = run.output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{line}: {said}");
            count += 1;
        }
    }
    assert!(count > 20, "{count}");
}

/// The five lines of Rust.
#[test]
fn vertices_are_followed() {
    let soup = Torus { major: 5.0, minor: 2.0 }.mesh(60, 30).unwrap();
    let mesh = build(&soup, &Repair::strict()).unwrap().mesh;
    let result = simplify::simplify(&mesh, &simplify::Options::default().to_faces(500)).unwrap();
    assert_eq!(result.vertex_map.iter().count(), 1800);
    assert!(result.vertex_map.iter().all(|(_, new)| new.is_some()));
}

/// What the pages say of the report of a run that cannot reach its target.
#[test]
fn a_run_that_stops_early_says_why() {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path());
    let [open, out] = ["open.ply", "out.ply"].map(|name| folder.path().join(name));
    let [open, out] = [&open, &out].map(|path| path.to_str().unwrap());
    let report = json(&["simplify", open, "-o", out, "--faces", "4", "--lock-boundary"]);
    assert_eq!(report["stop"], "nothing_left", "{report}");
    assert!(report["rejected"].as_object().is_some_and(|counts| !counts.is_empty()), "{report}");
}
