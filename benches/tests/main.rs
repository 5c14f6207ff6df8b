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

#[test]
fn the_pages_agree_with_the_records() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = tempfile::tempdir().unwrap();
    for (command, page) in [
        ("peers", "docs/results/peers.md"),
        ("peers", "README.md"),
        ("peers", "COMPARE.md"),
        ("flips", "docs/results/flips-and-distances.md"),
        ("distances", "docs/results/flips-and-distances.md"),
    ] {
        let record = format!("benches/recorded/{command}.jsonl");
        let (old, copy) = (root.join(page), folder.path().join("page.md"));
        std::fs::copy(&old, &copy).unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_benches"));
        program.args([command, "--from"]).arg(root.join(&record));
        let output = program.arg("--pages").arg(&copy).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let [old, new] = [old, copy].map(|path| std::fs::read_to_string(path).unwrap());
        let count = new.matches(&format!("<!-- {command}: end -->")).count();
        assert!(count > 0, "{page} has no table of the record");
        let cure = format!("cargo run -p benches -- {command} --from {record} writes it anew");
        assert!(old == new, "{page} does not agree with the record; {cure}");
    }
}

/// The whole way from a set of jobs to a page, with our tools only.
#[test]
fn flips_and_distances_are_measured_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    for (command, tables, row) in [
        ("flips", ["quality", "growth", "agreement"], "| `f2` | noisy | 484 |"),
        ("distances", ["proved", "sampled", "closest"], "| curvmesh, proved | 1e-3 | 3 of 3 |"),
    ] {
        let run = |arguments: &[&str]| {
            let mut program = Command::new(env!("CARGO_BIN_EXE_benches"));
            let output = program.arg(command).args(arguments).output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            String::from_utf8_lossy(&output.stdout).into_owned()
        };
        let said = run(&["--jobs", "tiny", "--out", folder.path().to_str().unwrap()]);
        assert!(said.contains(row), "{said}");
        let record = folder.path().join(format!("{command}.jsonl"));
        let block = |table: &str| format!("<!-- {command}: {table} -->\n<!-- {command}: end -->\n");
        std::fs::write(&page, tables.map(block).concat()).unwrap();
        run(&["--from", record.to_str().unwrap(), "--pages", page.to_str().unwrap()]);
        let text = std::fs::read_to_string(&page).unwrap();
        assert!(text.contains(row), "{text}");
        // Flips lower the cost that they are asked to lower, and every sample is below the proved bound.
        for line in std::fs::read_to_string(&record).unwrap().lines() {
            let job: serde_json::Value = serde_json::from_str(line).unwrap();
            let of = |path: &str| job.pointer(&format!("/outcome/values/{path}"));
            let number = |path: &str| of(path).and_then(serde_json::Value::as_f64);
            match job["tool"].as_str().unwrap() {
                cost @ ("f1" | "f2" | "f3") => {
                    let [before, after] =
                        ["before", "after"].map(|at| number(&format!("{at}/{cost}")));
                    assert!(after < before, "{line}");
                }
                "proved" => {
                    let width = number("upper").unwrap() - number("lower").unwrap();
                    assert!((0.0..=1.001e-3).contains(&width), "{line}");
                }
                "sampled" => {
                    assert!(number("lower") > Some(0.0) && number("upper").is_none(), "{line}");
                }
                _ => assert!(number("after/mean_smallest_angle").is_some(), "{line}"),
            }
        }
    }
    let unknown = Command::new(env!("CARGO_BIN_EXE_benches"))
        .args(["flips", "--jobs", "tiny", "--tools", "none"])
        .output()
        .unwrap();
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("meshlab-mean"));
}

/// Whether a line of COMPARE.md is in a table that is made from the record, and the lines.
fn comparison() -> Vec<(bool, String)> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = std::fs::read_to_string(root.join("COMPARE.md")).unwrap();
    let mut is_generated = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        is_generated = match line {
            "<!-- peers: end -->" => false,
            line => is_generated || line.starts_with("<!-- peers: "),
        };
        lines.push((is_generated, line.to_owned()));
    }
    lines
}

/// Figures of measurements stand in tables of the record only. Other figures are in names, links and commands.
#[test]
fn the_comparison_has_no_figure_without_a_record() {
    let mut is_code = false;
    for (_, line) in comparison().into_iter().filter(|(is_generated, _)| !is_generated) {
        is_code ^= line.starts_with("```");
        let texts = line.split("](").enumerate();
        let texts = texts.map(|(i, part)| match part.split_once(')') {
            Some((_, rest)) if i > 0 => rest,
            _ => part,
        });
        let text: String = texts.collect::<String>().replace("Open3D", "");
        assert!(is_code || !text.contains(|c: char| c.is_ascii_digit()), "{line}");
    }
}

/// What the words say of time and distance is in the figures.
#[test]
fn the_words_of_the_comparison_agree_with_the_record() {
    let lines = comparison();
    let rows = lines.iter().filter(|(is_generated, line)| *is_generated && line.starts_with("| "));
    let mut checked = 0;
    for (_, row) in rows.skip(1) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let name = cells[1].split([' ', ',']).next().unwrap();
        if name == "`default`" {
            continue;
        }
        let [time, mean] = [3, 4].map(|i| cells[i].parse::<f64>().unwrap());
        let heading = format!("[{name}]");
        let (_, words) = lines.iter().find(|(_, line)| line.contains(&heading)).unwrap();
        let says = |claim: &str| words.contains(claim);
        assert!(!says("Slower than `default`") || time > 1.0, "{row}");
        assert!(!(says("Faster than `default`") || says("The fastest")) || time < 1.0, "{row}");
        assert!(!says("Far from the input") || mean > 2.5, "{row}");
        assert!(says("Far from the input") || says("arther from the input") && mean > 1.0, "{row}");
        checked += 1;
    }
    assert!(checked > 5, "{checked}");
}
