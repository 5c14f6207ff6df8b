//! `curvmesh simplify`, `lod` and `distance` on generated meshes.
#![allow(clippy::unwrap_used, clippy::float_cmp)]

use std::path::{Path, PathBuf};

use crate::common::{code, json, write};
use mesh_core::PolygonSoup;
use mesh_shapes::{Sphere, Torus};
use serde_json::Value;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn torus(folder: &Path, around: usize) -> PathBuf {
    let path = folder.join(format!("torus{around}.ply"));
    write(Torus { major: 5.0, minor: 2.0 }.mesh(around, around / 2).unwrap(), &path);
    path
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn trap_1_the_result_has_as_many_faces_as_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (torus(folder.path(), 60), folder.path().join("out.ply"));
    for faces in [1001, 600, 77] {
        let count = faces.to_string();
        let arguments = ["simplify", text(&input), "-o", text(&output), "--faces", &count];
        let report = json(&arguments);
        let found = report["faces_out"].as_u64().unwrap();
        assert!(found == faces || found == faces - 1, "{report}");
        assert_eq!((&report["stop"], &report["faces_in"]), (&"faces".into(), &3600.into()));
        assert_eq!(json(&["info", text(&output)])["faces"], found);
        for key in ["vertices_out", "max_cost", "collapses"] {
            assert!(report[key].is_number(), "{key}");
        }
        assert!(report["rejected"].is_object());
    }
}

#[test]
fn the_first_target_that_is_reached_ends_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (torus(folder.path(), 80), folder.path().join("out.ply"));
    let run = |more: &[&str]| {
        json(&[&["simplify", text(&input), "-o", text(&output)][..], more].concat())
    };
    let report = run(&["--ratio", "0.01", "--max-error", "0.05", "--verify"]);
    assert_eq!(report["stop"], "error", "{report}");
    assert!(number(&report["error"]["upper"]) <= 0.05, "{report}");
    let measured = json(&["distance", text(&input), text(&output), "--samples", "50000"]);
    assert!(number(&measured["max"]) <= number(&report["error"]["upper"]) + 1e-12);
    let report = run(&["--ratio", "0.5", "--max-error", "5", "--vertices", "10"]);
    assert_eq!((&report["stop"], &report["faces_out"]), (&"faces".into(), &3200.into()));
    assert_eq!(run(&["--vertices", "300", "--preset", "fast"])["vertices_out"], 300);

    let wrong = ["simplify", text(&input), "-o", text(&output), "--ratio", "1.5"];
    assert_eq!(code(&wrong).0, 2);
}

#[test]
fn endpoint_placement_keeps_a_subset_of_the_vertices() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (torus(folder.path(), 40), folder.path().join("out.ply"));
    let arguments = ["simplify", text(&input), "-o", text(&output), "--faces", "200"];
    json(&[&arguments[..], &["--placement", "endpoint", "--fit-rounds", "0"]].concat());
    let before = mesh_io::read(&input).unwrap();
    let after = mesh_io::read(&output).unwrap();
    assert!(after.soup.positions().iter().all(|p| before.soup.positions().contains(p)));
}

#[test]
fn levels_have_sensible_defaults_and_go_to_a_folder_of_any_name() {
    let folder = tempfile::tempdir().unwrap();
    let levels = folder.path().join("scan.v2");
    // Levels with fewer than 100 faces are omitted, except for the first one.
    for (size, expected) in [(60, &[1800, 900, 360, 180][..]), (24, &[288, 144]), (12, &[72])] {
        let input = torus(folder.path(), size);
        let report = json(&["lod", text(&input), "-o", text(&levels)]);
        let found = report["levels"].as_array().unwrap();
        let faces: Vec<u64> = found.iter().map(|level| level["faces"].as_u64().unwrap()).collect();
        assert_eq!(faces, expected);
        assert!(found.iter().all(|level| level["output"].as_str().unwrap().contains("scan.v2")));
    }
    let (code, said) = code(&["lod", text(&torus(folder.path(), 60)), "-o", text(&levels)]);
    assert!(code == 0 && said.contains("50 %, 25 %, 10 %, 5 % of the faces"), "{said}");
    // A single file for several levels has to be GLB or glTF, as before.
    let single = folder.path().join("single.ply");
    let refused =
        crate::common::code(&["lod", text(&folder.path().join("torus.ply")), "-o", text(&single)]);
    assert_eq!(refused.0, 2, "{refused:?}");
}

#[test]
fn levels_are_nested_and_a_record_replays_them_exactly() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path(), 60);
    let (levels, record) = (folder.path().join("levels"), folder.path().join("torus.lod"));
    let report = json(&[
        "lod",
        text(&input),
        "-o",
        text(&levels),
        "--levels",
        "0.1,0.5,0.25",
        "--record",
        text(&record),
    ]);
    let found = report["levels"].as_array().unwrap();
    let faces: Vec<u64> = found.iter().map(|level| level["faces"].as_u64().unwrap()).collect();
    assert_eq!(faces, [1800, 900, 360]);
    assert!(found.is_sorted_by_key(|level| number(&level["mean"])));
    for level in found {
        let file = level["output"].as_str().unwrap();
        let measured = json(&["distance", text(&input), file, "--samples", "200000"]);
        assert_eq!(measured["max"], level["max"]);
        let count = level["faces"].to_string();
        let again = folder.path().join("again.ply");
        let arguments = ["lod", text(&input), "-o", text(&again), "--replay", text(&record)];
        json(&[&arguments[..], &["--faces", &count]].concat());
        assert!(std::fs::read(file).unwrap() == std::fs::read(again).unwrap(), "{count}");
    }

    // A record holds no fewer faces than its coarsest level, and that is said.
    let out = folder.path().join("other.ply");
    let below = ["lod", text(&input), "-o", text(&out), "--replay", text(&record), "--faces", "90"];
    let report = json(&below);
    assert_eq!(
        (&report["missed_faces"], &report["levels"][0]["faces"]),
        (&[90].into(), &360.into())
    );
    let (status, said) = code(&below);
    assert!(status == 0 && said.contains("the record ends at 360 faces"), "{said}");

    let other = torus(folder.path(), 40);
    let replay = |input: &Path| {
        code(&["lod", text(input), "-o", text(&out), "--replay", text(&record), "--faces", "90"])
    };
    let (status, message) = replay(&other);
    assert_eq!(status, 3);
    assert!(message.contains("1800 vertices"), "{message}");
    let mut bytes = std::fs::read(&record).unwrap();
    for (cut, reason) in [(5, "cut off or changed"), (60, "ends within collapse")] {
        std::fs::write(&record, &bytes[..bytes.len() - cut]).unwrap();
        let (status, message) = replay(&input);
        assert!(status == 3 && message.contains(reason), "{message}");
    }
    // Two collapses of a half-edge that does not exist, or of one that can no longer be collapsed; with a checksum.
    let trailer = bytes[bytes.len() - 32..bytes.len() - 8].to_vec();
    bytes.truncate(28 + 96);
    bytes[24..28].copy_from_slice(&2_u32.to_le_bytes());
    for (half_edge, reason) in [(u32::MAX, "does not fit the mesh"), (0, "belong to another mesh")]
    {
        for place in [28, 28 + 48] {
            bytes[place..place + 4].copy_from_slice(&half_edge.to_le_bytes());
        }
        let mut content = [&bytes[..], &trailer].concat();
        content.extend(mesh_core::Checksum::of(&content).value().to_le_bytes());
        std::fs::write(&record, content).unwrap();
        let (status, message) = replay(&input);
        assert!(status == 3 && message.contains(reason), "{message}");
    }
}

#[test]
fn one_glb_holds_all_levels() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (torus(folder.path(), 40), folder.path().join("out.glb"));
    json(&["lod", text(&input), "-o", text(&output), "--errors", "0.5,0.3"]);
    let bytes = std::fs::read(&output).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let document: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    assert_eq!(document["extensionsUsed"], serde_json::json!(["MSFT_lod"]));
    assert_eq!(document["nodes"][0]["extensions"]["MSFT_lod"]["ids"], serde_json::json!([1, 2]));
    assert_eq!(document["scenes"][0]["nodes"], serde_json::json!([0]));
    let coverage = document["nodes"][0]["extras"]["MSFT_screencoverage"].as_array().unwrap();
    assert_eq!(coverage.len(), 3);
    assert!(coverage.is_sorted_by(|a, b| number(a) > number(b)), "{coverage:?}");
    // A reader that does not know the extension sees the input.
    assert_eq!(json(&["info", text(&output)])["faces"], 1600);
}

/// Two plates, one above the other: every distance is the offset.
#[test]
fn an_offset_copy_is_at_the_offset() {
    let folder = tempfile::tempdir().unwrap();
    let plate = |z: f64, name: &str| {
        let mut soup = PolygonSoup::new();
        for (x, y) in [(0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0)] {
            soup.push_vertex([x, y, z]);
        }
        soup.push_face(&[0, 1, 2, 3]).unwrap();
        let path = folder.path().join(name);
        write(soup, &path);
        path
    };
    let (low, high) = (plate(100.0, "low.obj"), plate(100.37, "high.obj"));
    let output = folder.path().join("errors.ply");
    let arguments = ["distance", text(&low), text(&high), "--samples", "20000"];
    let report = json(&[&arguments[..], &["--exact", "1e-6", "-o", text(&output)]].concat());
    let offset = 100.37 - 100.0;
    for way in ["forward", "backward"] {
        for measure in ["mean", "rms", "max"] {
            let found = number(&report[way][measure]);
            assert!((found - offset).abs() < 1e-12, "{way} {measure}: {found}");
        }
    }
    let bounds = &report["hausdorff"];
    assert!(
        number(&bounds["lower"]) <= offset + 1e-12 && offset <= number(&bounds["upper"]) + 1e-12
    );
    let colored = mesh_io::read(&output).unwrap();
    let errors = colored.vertex_scalars.iter().find(|s| s.name == "distance").unwrap();
    assert!(errors.values.iter().all(|d| (d - offset).abs() < 1e-12));
    assert_eq!(colored.vertex_colors.unwrap().len(), 4);
}

#[test]
fn proved_bounds_hold_the_largest_sample() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let sphere = Sphere { radius: 1.0 };
    write(sphere.icosphere(2).unwrap(), &path("coarse.ply"));
    write(sphere.icosphere(5).unwrap(), &path("fine.ply"));
    let [coarse, fine] = ["coarse.ply", "fine.ply"].map(path);
    let report = json(&["distance", text(&coarse), text(&fine), "--exact", "1e-4"]);
    let (lower, upper) =
        (number(&report["hausdorff"]["lower"]), number(&report["hausdorff"]["upper"]));
    let max = number(&report["max"]);
    // A sample is rounded, so it raises the lower bound only up to its certified distance.
    assert!(max <= lower + 1e-12 && lower <= upper && upper - lower <= 1e-4, "{report}");
    assert!(max > lower - 1e-3, "{report}");
}

#[test]
fn the_norm_is_in_the_report_and_annealing_ends_in_time() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (torus(folder.path(), 60), folder.path().join("out.ply"));
    let run = |more: &[&str]| {
        let start = ["simplify", text(&input), "-o", text(&output), "--faces", "300"];
        let report = json(&[&start[..], more].concat());
        let d = json(&["distance", text(&output), text(&input), "--samples", "100000"]);
        (report["fit"]["norm"].clone(), ["mean", "rms", "max"].map(|key| number(&d[key])))
    };
    let (usual, [mean, rms, max]) = run(&["--preset", "quality"]);
    let (l1, [mean1, ..]) = run(&["--preset", "quality", "--norm", "l1"]);
    let (l2, same) = run(&["--preset", "quality", "--norm", "l2"]);
    let (largest, [.., max3]) = run(&["--preset", "quality", "--norm", "max"]);
    assert_eq!([usual, l1, l2, largest], ["l2", "l1", "l2", "max"]);
    assert_eq!(same, [mean, rms, max]);
    assert!(mean1 < mean && max3 < max, "{mean1} {mean}, {max3} {max}");
    run(&["--preset", "extreme", "--anneal-time", "0"]);
}

/// The settings in a report are all settings of the run: with them, the library makes the same mesh.
#[test]
fn the_report_has_all_settings_of_the_preset() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (torus(folder.path(), 40), folder.path().join("out.ply"));
    let mesh =
        |path: &Path| mesh_core::TriMesh::from_soup(&mesh_io::read(path).unwrap().soup).unwrap();
    let original = mesh(&input);
    for preset in simplify::Preset::ALL.iter().filter(|&&p| p != simplify::Preset::Extreme) {
        let arguments = ["simplify", text(&input), "-o", text(&output), "--ratio", "0.3"];
        let report = json(&[&arguments[..], &["--preset", preset.name()]].concat());
        let settings: simplify::Options =
            serde_json::from_value(report["settings"].clone()).unwrap();
        let mut again = simplify::simplify(&original, &settings).unwrap().mesh;
        again.compact();
        assert_eq!(again.positions(), mesh(&output).positions(), "{preset}");
    }
    assert_eq!(
        json(&["simplify", text(&input), "-o", text(&output), "--preset", "paper-l1"])["settings"]
            ["protect"]["min_cosine"],
        Value::Null
    );
}
