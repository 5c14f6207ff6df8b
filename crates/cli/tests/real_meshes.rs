//! Every real mesh through every command. Needs `CURVMESH_MODELS`.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::common::{curvmesh, files, json, models, name};

/// Defects of widely used test meshes, counted independently: polygons cut into fans, seams of
/// glTF files not welded (`raw`) or vertices welded exactly (`weld`).
const DEFECTS: &str = include_str!("defects.csv");

/// Files whose counts differ intentionally; `docs/defects.md` explains each.
const EXPLAINED: [&str; 9] = [
    // Instances and node transforms are expanded.
    "helicopter.glb",
    "cesium_milk_truck.glb",
    "engine_2cyl.glb",
    // Undefined coordinates equal nothing, so they are not welded.
    "box_infinite.glb",
    // Triangles that use a vertex twice are no duplicates.
    "spider_ascii.stl",
    // Polygons are cut along real diagonals, not into fans.
    "beast.obj",
    "office_chair.obj",
    "zurich_georef.obj",
    "box_longline.obj",
];

#[test]
fn info_of_every_file_agrees_with_the_table() {
    let Some(folder) = models() else { return };
    let mut lines = DEFECTS.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut different = Vec::new();
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        let path = folder.join(fields[0]);
        if !path.is_file() {
            println!("{}: not there", fields[0]);
            continue;
        }
        let weld = if fields[1] == "weld" { "exact" } else { "none" };
        let welded: &[&str] = &["--weld", weld];
        let output = curvmesh(&[&["info", path.to_str().unwrap(), "--json"], welded].concat());
        if !output.status.success() {
            assert_eq!(output.status.code(), Some(3), "{}", fields[0]);
            println!("{}: {}", fields[0], String::from_utf8_lossy(&output.stderr).trim());
            continue;
        }
        let info: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        for (key, expected) in header.iter().zip(&fields).skip(2) {
            let expected: i64 = expected.parse().unwrap();
            if info[*key] != expected && !EXPLAINED.contains(&fields[0]) {
                different.push(format!(
                    "{} {} {key}: {} instead of {expected}",
                    fields[0], fields[1], info[*key]
                ));
            }
        }
    }
    assert!(different.is_empty(), "\n{}", different.join("\n"));
}

#[test]
fn every_file_is_understood_or_refused_with_its_place() {
    let Some(folder) = models() else { return };
    for path in files(&folder) {
        let output = curvmesh(&["info", path.to_str().unwrap(), "--json"]);
        let message = String::from_utf8_lossy(&output.stderr);
        match output.status.code() {
            Some(0) => {}
            // An empty file has no place to name.
            Some(3) if message.contains("no vertex and no face") => {
                json(&["info", "--allow-empty", path.to_str().unwrap()]);
            }
            Some(3) => assert!(message.contains("line") || message.contains("byte"), "{message}"),
            other => panic!("{}: {other:?} {message}", name(&path)),
        }
    }
}

/// All finite meshes are repaired, converted to every format, and read again with the same faces.
#[test]
fn every_finite_mesh_converts_to_every_format() {
    let Some(folder) = models() else { return };
    let empty = mesh_io::ReadOptions { allow_empty: true, ..mesh_io::ReadOptions::default() };
    for path in files(&folder) {
        // Separate folders, so that the pictures of one mesh do not replace the pictures of another.
        let out = tempfile::tempdir().unwrap();
        let input = path.to_str().unwrap();
        for extension in ["obj", "ply", "stl", "off", "gltf", "glb"] {
            let target = out.path().join("out").with_extension(extension);
            let target = target.to_str().unwrap();
            let output =
                curvmesh(&["convert", input, target, "--lenient", "--json", "--allow-empty"]);
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            if output.status.code() == Some(3) {
                let infinite = message.contains("not finite");
                assert!(infinite || message.contains("line"), "{}: {message}", name(&path));
                break;
            }
            assert!(output.status.success(), "{} to {extension}: {message}", name(&path));
            let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            let again = mesh_io::read_with(target, &empty).unwrap().soup.faces().len();
            assert_eq!(report["faces"], again, "{} to {extension}", name(&path));
        }
    }
}

/// Flips terminate on every mesh with valid coordinates and indices, with a valid mesh and a cost that is not higher.
/// No option is needed.
#[test]
fn flips_end_on_every_mesh_and_lower_the_cost() {
    let Some(folder) = models() else { return };
    let out = tempfile::tempdir().unwrap();
    let target = out.path().join("out.ply");
    let target = target.to_str().unwrap();
    let mut refused = Vec::new();
    for path in files(&folder) {
        let output = curvmesh(&["flip", path.to_str().unwrap(), "-o", target, "--json"]);
        if matches!(output.status.code(), Some(3 | 4)) {
            refused.push(name(&path));
            continue;
        }
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{}: {message}", name(&path));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let cost = |key: &str| report[key].as_f64().unwrap();
        assert!(cost("cost_after") <= cost("cost_before"), "{}: {report}", name(&path));
        let info = json(&["info", target]);
        assert_eq!(info["faces"], report["faces"], "{}", name(&path));
        assert!(info["manifold"] == true && info["oriented"] == true, "{}", name(&path));
    }
    assert!(refused.len() <= 4, "{refused:?}");
}
