//! `curvmesh distance` of point clouds, with signs, and the values of faces on its page.
#![allow(clippy::unwrap_used, clippy::float_cmp)]

use std::path::{Path, PathBuf};

use crate::common::{code, curvmesh, json, write};
use mesh_core::PolygonSoup;
use mesh_shapes::{Plane, Sphere};
use serde_json::Value;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn cloud(folder: &Path, name: &str, points: &[[f64; 3]]) -> PathBuf {
    let path = folder.join(name);
    let none: &[[u32; 3]] = &[];
    write(PolygonSoup::from_triangles(points, none).unwrap(), &path);
    path
}

fn plane(folder: &Path) -> PathBuf {
    let path = folder.join("plane.ply");
    write(Plane { half_width: 1.0 }.mesh(4, Default::default()).unwrap(), &path);
    path
}

const POINTS: [[f64; 3]; 4] =
    [[0.3, 0.3, 0.125], [0.5, 0.5, -0.0625], [0.75, 0.25, 0.5], [2.0, 0.5, 0.0]];

#[test]
fn points_are_measured_in_one_direction_and_that_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let plane = plane(folder.path());
    for name in ["cloud.ply", "cloud.obj", "cloud.glb", "cloud.gltf"] {
        let points = cloud(folder.path(), name, &POINTS);
        let copy = folder.path().join(format!("copy-{name}"));
        let report = json(&["convert", text(&points), "-o", text(&copy)]);
        let expected = serde_json::json!([4, []]);
        assert_eq!(serde_json::json!([report["vertices"], report["lost"]]), expected, "{report}");
        for (first, second, side, other) in
            [(&points, &plane, "forward", "backward"), (&plane, &points, "backward", "forward")]
        {
            let report = json(&["distance", text(first), text(second)]);
            assert_eq!((&report["one_sided"], report.get(other)), (&true.into(), None), "{report}");
            let mean = (0.125 + 0.0625 + 0.5 + 1.0) / 4.0;
            assert!((number(&report[side]["mean"]) - mean).abs() < 1e-12, "{report}");
            assert_eq!((&report["mean"], &report["max"]), (&report[side]["mean"], &1.0.into()));
            assert_eq!(report[side]["max_at"], serde_json::json!([2.0, 0.5, 0.0]));
            assert!(report.get("samples").is_none());
            let output = curvmesh(&["distance", text(first), text(second)]);
            let said = String::from_utf8(output.stdout).unwrap();
            assert!(said.contains("one direction only") && !said.contains("both"), "{said}");
        }
        let kinds = &json(&["distance", text(&points), text(&plane)])["kinds"];
        assert_eq!(*kinds, serde_json::json!(["points", "surface"]));
    }
    let one = cloud(folder.path(), "one.ply", &[[0.0, 0.0, 0.0]]);
    let two = cloud(folder.path(), "two.ply", &[[0.0, 0.0, 1.0], [0.0, 3.0, 0.0]]);
    let report = json(&["distance", text(&one), text(&two)]);
    assert_eq!((&report["one_sided"], number(&report["forward"]["max"])), (&false.into(), 1.0));
    assert_eq!(number(&report["backward"]["mean"]), 2.0);
    let output = folder.path().join("out.ply");
    let points = cloud(folder.path(), "cloud.ply", &POINTS);
    json(&["distance", text(&points), text(&plane), "-o", text(&output)]);
    let written = mesh_io::read(&output).unwrap();
    assert_eq!(written.vertex_scalars[0].values.get(1), Some(0.0625));
}

#[test]
fn options_without_meaning_for_points_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let plane = plane(folder.path());
    let points = cloud(folder.path(), "cloud.ply", &POINTS);
    let [output, page] = ["out.ply", "page.html"].map(|name| folder.path().join(name));
    for (more, word) in [
        (vec![text(&points), text(&plane), "--exact", "1%"], "--exact"),
        (vec![text(&points), text(&plane), "--samples", "9"], "--samples"),
        (vec![text(&points), text(&plane), "--view", text(&page)], "--view"),
        (vec![text(&plane), text(&points), "--signed"], "--signed"),
        (vec![text(&plane), text(&points), "-o", text(&output)], "-o"),
    ] {
        let (status, message) = code(&[&["distance"][..], &more].concat());
        assert!(status == 2 && message.contains(word), "{status} {message}");
    }
    assert!(!output.exists() && !page.exists());
    let empty = folder.path().join("empty.off");
    std::fs::write(&empty, "OFF\n0 0 0\n").unwrap();
    assert_ne!(code(&["distance", text(&empty), text(&plane), "--allow-empty"]).0, 0);
}

#[test]
fn a_sign_is_negative_inside_and_the_rule_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let sphere = |radius: f64, name: &str| {
        let path = folder.path().join(name);
        write(Sphere { radius }.icosphere(4).unwrap(), &path);
        path
    };
    let (ball, smaller) = (sphere(1.0, "ball.stl"), sphere(0.9, "smaller.ply"));
    let report = json(&["distance", text(&smaller), text(&ball), "--signed", "--samples", "20000"]);
    let (forward, backward) = (&report["forward"]["signed"], &report["backward"]["signed"]);
    assert_eq!((&forward["by"], &forward["inside"]), (&"winding_number".into(), &1.0.into()));
    assert!((number(&forward["mean"]) + 0.1).abs() < 5e-3 && number(&forward["max"]) < -0.09);
    assert_eq!(backward["inside"], 0.0);
    assert!((number(&backward["mean"]) - 0.1).abs() < 5e-3);
    // Signs do not change sizes.
    let plain = json(&["distance", text(&smaller), text(&ball), "--samples", "20000"]);
    assert_eq!(plain["forward"]["mean"], report["forward"]["mean"]);
    assert!(plain["forward"].get("signed").is_none());
    let plane = plane(folder.path());
    let points = cloud(folder.path(), "cloud.ply", &POINTS);
    let output = folder.path().join("out.ply");
    let report = json(&["distance", text(&points), text(&plane), "--signed", "-o", text(&output)]);
    let signed = &report["forward"]["signed"];
    assert_eq!((&signed["by"], number(&signed["min"])), (&"pseudonormal".into(), -0.0625));
    let written = mesh_io::read(&output).unwrap();
    assert_eq!(
        [0, 1].map(|v| written.vertex_scalars[0].values.get(v)),
        [Some(0.125), Some(-0.0625)]
    );
    let output = curvmesh(&["distance", text(&points), text(&plane), "--signed"]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("negative inside by the pseudonormal"), "{said}");
}

/// A large face over a dent: no vertex of it is wrong, but the page starts with the values of faces.
#[test]
fn a_page_shows_an_error_in_the_middle_of_a_face() {
    let folder = tempfile::tempdir().unwrap();
    let [flat, dented, page] =
        ["flat.ply", "dented.ply", "page.html"].map(|name| folder.path().join(name));
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    write(PolygonSoup::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap(), &flat);
    let fine = Plane { half_width: 1.0 }.mesh(40, Default::default()).unwrap();
    let centre = glam::DVec3::new(0.4, -0.3, 0.0);
    let dent = |p: &glam::DVec3| p.with_z(-0.2 * (1.0 - p.distance(centre) / 0.2).max(0.0));
    let points: Vec<glam::DVec3> = fine.positions().iter().map(dent).collect();
    let faces: Vec<[u32; 3]> = fine.faces().map(|f| f.try_into().unwrap()).collect();
    write(PolygonSoup::from_triangles(&points, &faces).unwrap(), &dented);
    let arguments =
        ["distance", text(&flat), text(&dented), "--samples", "20000", "--view", text(&page)];
    let report = json(&arguments);
    assert!(number(&report["forward"]["max"]) > 0.1, "{report}");
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("face:largest distance in face"));
    // Between equal surfaces there is nothing to see inside faces.
    json(&["distance", text(&flat), text(&flat), "--samples", "100", "--view", text(&page)]);
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("vertex:distance") && !html.contains("\"face:largest"));
}

#[test]
fn commands_on_surfaces_refuse_points() {
    let folder = tempfile::tempdir().unwrap();
    let points = cloud(folder.path(), "cloud.ply", &POINTS);
    let points = text(&points);
    let out = folder.path().join("out.ply");
    let levels = folder.path().join("levels");
    let (out, levels) = (text(&out), text(&levels));
    let commands: [&[&str]; 7] = [
        &["simplify", points, "-o", out, "--ratio", "0.5"],
        &["curvature", points, "-o", out],
        &["flip", points, "-o", out],
        &["patch", points, "-o", out],
        &["subdivide", points, "-o", out],
        &["repair", points, "-o", out],
        &["lod", points, "-o", levels],
    ];
    for command in commands {
        let (status, said) = code(command);
        assert_eq!(status, 4, "{command:?}: {said}");
        assert!(said.contains("4 points and no faces") && said.contains("--allow-empty"), "{said}");
        assert!(!Path::new(out).exists() && !Path::new(levels).exists(), "{command:?}");
    }
    let (status, _) = code(&["simplify", points, "-o", out, "--ratio", "0.5", "--allow-empty"]);
    assert_eq!(status, 0);
    for command in [&["info", points][..], &["convert", points, "-o", out]] {
        assert_eq!(code(command).0, 0, "{command:?}");
    }
}
