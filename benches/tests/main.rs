//! Tests of the command line.
#![allow(clippy::unwrap_used)]

mod page_in_browser;

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

#[test]
fn the_pages_agree_with_the_record() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = tempfile::tempdir().unwrap();
    let mut blocks = 0;
    for (name, page) in [("peers.md", "docs/results/peers.md"), ("README.md", "README.md")] {
        let (old, copy) = (root.join(page), folder.path().join(name));
        std::fs::copy(&old, &copy).unwrap();
        let mut peers = Command::new(env!("CARGO_BIN_EXE_benches"));
        peers.args(["peers", "--from"]).arg(root.join("benches/recorded/peers.jsonl"));
        let output = peers.arg("--pages").arg(&copy).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let [old, new] = [old, copy].map(|path| std::fs::read_to_string(path).unwrap());
        blocks += new.matches("<!-- peers: end -->").count();
        let cure =
            "cargo run -p benches -- peers --from benches/recorded/peers.jsonl writes it anew";
        assert!(old == new, "{page} does not agree with the record; {cure}");
    }
    assert!(blocks > 0, "no page has a table of the record");
}
