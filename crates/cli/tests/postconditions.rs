//! No command makes a mesh worse in kind: random meshes of many kinds through all commands.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::path::Path;

use mesh_core::SplitMix64;
use mesh_io::{Format, WriteOptions};
use postconditions::commands::{self, Command};
use postconditions::{kinds, violations, wear};

use crate::common::curvmesh;

/// Meshes for each command, unless `PROPTEST_CASES` says how many.
const CASES: u64 = 1;

/// The number of combinations of options that chance chooses.
const COMBINED: u64 = 12;

/// Runs in which a chain of collapses or moves turns faces over, which a single flip or move does not turn back.
const FOLDED: [(&str, &str, u64); 11] = [
    ("simplify --preset default --ratio 0.5", "marching", 1003),
    ("simplify --preset thin-features --ratio 0.5", "marched plate", 1026),
    ("simplify --ratio 0.2 --lock-boundary", "marched plate", 1004),
    ("simplify --ratio 0.1 --no-attributes --preset quality", "dome with holes", 1055),
    ("simplify --ratio 0.1 --preset quality --norm max", "height field", 1005),
    ("simplify --preset fast --ratio 0.3", "height field", 1005),
    ("simplify --ratio 0.2 --preset fast --placement optimal", "height field", 1005),
    ("simplify --preset draft --ratio 0.1", "dome with holes", 1033),
    ("simplify --preset quality --ratio 0.1", "dome with holes", 1055),
    ("simplify --preset default --ratio 0.05", "dome with holes", 505),
    ("simplify --preset draft --ratio 0.3", "marching", 1003),
];

/// Runs a command on a mesh, and returns the violations of its promise.
fn run(command: &Command, kind: usize, seed: u64, folder: &Path) -> Vec<String> {
    let mut worn = wear::wear(&kinds::mesh(kind, seed, command.density), seed);
    if command.density > 1.0 && matches!(worn.format, Format::Off | Format::Glb) {
        // These cannot be read in pieces.
        worn.format = Format::Ply;
    }
    let input = folder.join(format!("in.{}", worn.format.extension()));
    mesh_io::write(&input, &worn.model, &WriteOptions::default()).unwrap();
    let out = folder.join("out");
    std::fs::create_dir_all(&out).unwrap();
    let words = command.words(input.to_str().unwrap(), out.to_str().unwrap());
    let words: Vec<&str> =
        words.iter().map(String::as_str).chain(["--json", "--threads", "1"]).collect();
    let output = curvmesh(&words);
    if !output.status.success() {
        return vec![String::from_utf8_lossy(&output.stderr).into_owned()];
    }
    let report = serde_json::from_slice(&output.stdout).unwrap();
    let before = mesh_io::read(&input).unwrap();
    let judge = |name: &String| {
        let path = out.join(name.replace("{stem}", "in"));
        let after = mesh_io::read(&path).unwrap();
        let formats = (Some(worn.format), Format::from_extension(&path));
        let found =
            violations((&before, formats.0), (&after, formats.1), &report, &command.promise);
        found.into_iter().map(move |text| format!("{name}: {text}")).collect::<Vec<_>>()
    };
    let found: Vec<String> = command.outputs.iter().flat_map(judge).collect();
    let about = |text: String| format!("{text} ({}, {})", kinds::name(kind), worn.description);
    found.into_iter().map(about).collect()
}

#[test]
fn faces_that_chains_of_changes_turn_over_are_turned_back() {
    let commands = commands::all();
    for (name, kind, seed) in FOLDED {
        let command = commands.iter().find(|command| command.name == name).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let faults = run(command, kinds::named(kind).unwrap(), seed, folder.path());
        assert!(faults.is_empty(), "{name}, {kind}, {seed}: {faults:?}");
    }
}

#[test]
fn no_face_of_an_outline_is_turned_over() {
    let outline = kinds::named("outline").unwrap();
    let commands = commands::all();
    for preset in ["fast", "default", "quality", "thin-features"] {
        for ratio in ["0.5", "0.1"] {
            let name = format!("simplify --preset {preset} --ratio {ratio}");
            let command = commands.iter().find(|command| command.name == name).unwrap();
            for seed in 0..6 {
                let folder = tempfile::tempdir().unwrap();
                let faults = run(command, outline, seed, folder.path());
                assert!(faults.is_empty(), "{name}, {seed}: {faults:?}");
            }
        }
    }
}

#[test]
fn no_command_makes_a_mesh_worse_in_kind() {
    let setting = |name: &str| std::env::var(name).ok();
    let cases = setting("PROPTEST_CASES").map_or(CASES, |cases| cases.parse().unwrap());
    let first: u64 = setting("CURVMESH_SEED").map_or(0, |seed| seed.parse().unwrap());
    let only = setting("CURVMESH_ONLY").unwrap_or_default();
    let mut faults = Vec::new();
    let combined = (0..COMBINED).map(|n| commands::combined(first * COMBINED + n));
    for (number, command) in commands::all().into_iter().chain(combined).enumerate() {
        if !command.name.contains(&only) {
            continue;
        }
        for case in first..first + cases {
            let seed = SplitMix64::new(1000 * case + number as u64).bits();
            let kind = (case as usize + number) % kinds::count();
            let folder = tempfile::tempdir().unwrap();
            for fault in run(&command, kind, seed, folder.path()) {
                let text = format!("{}: case {case}: {fault}", command.name);
                println!("{text}");
                faults.push(text);
                if let Some(kept) = setting("CURVMESH_KEEP") {
                    let to = Path::new(&kept).join(format!("{number}-{case}"));
                    std::fs::create_dir_all(&to).unwrap();
                    for file in std::fs::read_dir(folder.path()).unwrap() {
                        let file = file.unwrap().path();
                        if file.is_file() {
                            std::fs::copy(&file, to.join(file.file_name().unwrap())).unwrap();
                        }
                    }
                }
            }
        }
    }
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}
