//! One command on many files.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::common::{code, curvmesh, files, json, write};
use mesh_shapes::{Sphere, Torus};
use serde_json::Value;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A folder with five meshes, one of them in a subfolder and one broken, and another file.
fn scans(folder: &Path) -> PathBuf {
    let scans = folder.join("scans");
    std::fs::create_dir_all(scans.join("below")).unwrap();
    for (name, around) in [("a.ply", 30), ("b.stl", 24), ("below/c.off", 20), ("d.obj", 40)] {
        write(Torus { major: 5.0, minor: 2.0 }.mesh(around, 12).unwrap(), &scans.join(name));
    }
    std::fs::write(scans.join("bad.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n").unwrap();
    std::fs::write(scans.join("notes.txt"), "nothing to see").unwrap();
    scans
}

/// Runs with `--json` and returns the objects of the files and the summary.
fn lines(arguments: &[&str], expected: i32) -> (Vec<Value>, Value) {
    let output = curvmesh(&[arguments, &["--json"]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(expected), "{arguments:?}: {said}");
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines: Vec<Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let summary = lines.pop().unwrap();
    (lines, summary)
}

#[test]
fn every_file_is_done_or_reported() {
    let folder = tempfile::tempdir().unwrap();
    let scans = scans(folder.path());
    let extra = folder.path().join("extra.ply");
    write(Sphere { radius: 1.0 }.icosphere(3).unwrap(), &extra);
    let out = folder.path().join("out");
    for arguments in [
        &["simplify", "--ratio", "0.5", "--preset", "fast"][..],
        &["flip", "--cost", "f2"],
        &["convert"],
        &["curvature"],
        &["patch", "--tolerance", "2%", "--to", "ply"],
        &["subdivide"],
    ] {
        let (files, summary) =
            lines(&[arguments, &[text(&extra), text(&scans), "-o", text(&out)]].concat(), 4);
        assert_eq!(
            (&summary["files"], &summary["done"], &summary["failed"]),
            (&6.into(), &5.into(), &1.into()),
            "{arguments:?}"
        );
        let inputs: Vec<&str> = files.iter().map(|line| line["input"].as_str().unwrap()).collect();
        let names = ["a.ply", "b.stl", "bad.off", "below/c.off", "d.obj"];
        let expected = names.map(|name| text(&scans.join(name)).to_owned());
        assert_eq!(inputs[0], text(&extra));
        assert_eq!(inputs[1..], expected);
        assert_eq!(files[3]["error"]["code"], "malformed");
        assert!(files.iter().enumerate().all(|(i, line)| (i == 3) == line["output"].is_null()));
        for line in files.iter().filter(|line| !line["output"].is_null()) {
            assert!(json(&["info", line["output"].as_str().unwrap()])["faces"].is_u64());
        }
        assert!(!out.join("bad.off").exists());
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn results_do_not_depend_on_threads_and_shards_are_parts() {
    let folder = tempfile::tempdir().unwrap();
    let scans = scans(folder.path());
    let run = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let arguments = ["simplify", text(&scans), "-o", text(&out), "--ratio", "0.5", "-q"];
        curvmesh(&[&arguments[..], more].concat());
        out
    };
    let content = |out: &Path| {
        let mut all = files(out);
        all.extend(files(&out.join("below")));
        all.retain(|path| path.is_file());
        all.into_iter()
            .map(|path| (path.strip_prefix(out).unwrap().to_owned(), std::fs::read(&path).unwrap()))
            .collect::<Vec<_>>()
    };
    let one = content(&run("one", &["--threads", "1"]));
    assert_eq!(one.len(), 4);
    assert!(one == content(&run("many", &["--threads", "8"])));
    for shard in ["1/3", "2/3", "3/3"] {
        run("shards", &["--shard", shard]);
    }
    assert!(one == content(&folder.path().join("shards")));
}

#[test]
fn resuming_does_what_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let scans = scans(folder.path());
    std::fs::remove_file(scans.join("bad.off")).unwrap();
    let out = folder.path().join("out");
    let arguments = ["convert", text(&scans), "-o", text(&out), "--to", "ply", "--resume"];
    let (_, summary) = lines(&arguments, 0);
    assert_eq!((&summary["done"], &summary["passed_over"]), (&4.into(), &0.into()));
    std::fs::remove_file(out.join("b.ply")).unwrap();
    // An input that was changed after the run.
    let changed = std::fs::File::options().append(true).open(scans.join("d.obj")).unwrap();
    changed.set_modified(SystemTime::now() + Duration::from_secs(9)).unwrap();
    let (files, summary) = lines(&arguments, 0);
    assert_eq!((&summary["done"], &summary["passed_over"]), (&2.into(), &2.into()));
    assert!(files[0]["passed_over"].is_string() && files[1]["passed_over"].is_null(), "{files:?}");
}

#[test]
fn the_table_is_for_people() {
    let folder = tempfile::tempdir().unwrap();
    let scans = scans(folder.path());
    let output = curvmesh(&["curvature", text(&scans)]);
    assert_eq!(output.status.code(), Some(4));
    let table = String::from_utf8(output.stdout).unwrap();
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows.len(), 6, "{table}");
    assert!(rows[0].contains("done") && rows[0].contains("integral of K"), "{table}");
    assert!(rows[2].contains("failed") && rows[2].contains("line 6"), "{table}");
    assert!(rows[5].starts_with("5 files in ") && rows[5].ends_with("4 done, 1 failed"), "{table}");
    assert!(String::from_utf8(output.stderr).unwrap().contains("bad.off: line 6"));
}

#[test]
fn names_that_would_collide_are_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let scans = scans(folder.path());
    let path = |name: &str| text(&scans.join(name)).to_owned();
    let (a, b, c) = (path("a.ply"), path("b.stl"), path("below/c.off"));
    let out = folder.path().join("out");
    std::fs::copy(&a, scans.join("below/a.ply")).unwrap();
    let twice = path("below/a.ply");
    for arguments in [
        &["convert", &a, &twice, "-o", text(&out)][..],
        &["convert", &a, &b, &c, "-o", &path("one.ply")],
        &["convert", &a, &b, &c],
        &["convert", &a, &b, "-o", "-", "--to", "ply"],
        &["convert", &a, &b, &c, &twice, "-o", text(&scans), "--shard", "5/4"],
        &["convert", &twice, &b, "-o", text(&scans), "--to", "xyz"],
        // The result for below/a.ply would replace a.ply, which is read too.
        &["flip", "--cost", "f2", &twice, &a, "-o", &path("")],
    ] {
        let (status, message) = code(arguments);
        assert_eq!(status, 2, "{arguments:?}: {message}");
    }
    assert!(!out.exists());
    let empty = folder.path().join("empty");
    std::fs::create_dir(&empty).unwrap();
    assert_eq!(code(&["flip", "--cost", "f2", text(&empty)]).0, 3);
    // A missing file is an error of this file only.
    let (files, summary) = lines(&["flip", "--cost", "f2", &a, &path("none.ply")], 4);
    assert_eq!((&summary["done"], &files[1]["error"]["code"]), (&1.into(), &"unreadable".into()));
}

/// An output folder inside the input folder is not read.
#[test]
fn results_are_not_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let scans = scans(folder.path());
    let out = scans.join("out");
    for _ in 0..2 {
        let (_, summary) = lines(&["convert", text(&scans), "-o", text(&out)], 4);
        assert_eq!(summary["files"], 5);
    }
}

#[test]
fn info_takes_folders() {
    let folder = tempfile::tempdir().unwrap();
    let scans = scans(folder.path());
    let (files, summary) = lines(&["info", text(&scans)], 4);
    assert_eq!((files.len(), &summary["failed"]), (5, &1.into()));
    for line in files.iter().filter(|line| line["error"].is_null()) {
        let alone = json(&["info", line["input"].as_str().unwrap()]);
        for key in ["faces", "euler_characteristic", "volume", "bbox_max"] {
            assert_eq!(line[key], alone[key], "{key}");
        }
    }
}

/// A page is not called .png, and a picture not .pdf: programs go by the name.
#[test]
fn outputs_are_not_named_after_something_else() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("in.ply");
    write(Torus { major: 5.0, minor: 2.0 }.mesh(12, 8).unwrap(), &input);
    for (arguments, name, cure) in [
        (&["view"][..], "page.png", "page.html"),
        (&["render"], "picture.pdf", "picture.png"),
        (&["render"], "picture.html", "picture.png"),
        (&["simplify"], "small.html", ".ply"),
        (&["convert"], "small.png", ".ply"),
    ] {
        let output = folder.path().join(name);
        let (code, message) = code(&[arguments, &[text(&input), "-o", text(&output)]].concat());
        assert!(code == 2 && message.contains(cure), "{name}: {code} {message}");
        assert!(!output.exists(), "{name}");
    }
    let small = folder.path().join("small.ply");
    let page = folder.path().join("page.jpg");
    let (code, message) =
        code(&["simplify", text(&input), "-o", text(&small), "--view", text(&page)]);
    assert!(code == 2 && message.contains("page.html") && !small.exists(), "{code} {message}");
}
