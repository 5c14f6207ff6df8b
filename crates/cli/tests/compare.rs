//! Versions of a surface against the original.
#![allow(clippy::unwrap_used)]

use crate::common::{code, json, write};
use mesh_shapes::Sphere;

/// Each row has what `distance` says of the file, and a sphere of another radius is that far away everywhere.
#[test]
fn each_file_is_measured_against_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let [original, larger, coarse] = ["original.ply", "larger.ply", "coarse.ply"].map(path);
    for (path, radius, steps) in [(&original, 1.0, 5), (&larger, 1.1, 5), (&coarse, 1.0, 2)] {
        write(Sphere { radius }.icosphere(steps).unwrap(), path.as_ref());
    }
    let samples = ["--samples", "20000"];
    let more = ["--exact", "1%"];
    let compare = ["compare", &original, &original, &larger, &coarse];
    let report = json(&[&compare[..], &samples, &more].concat());
    let rows = report["files"].as_array().unwrap();
    assert_eq!(rows.len(), 3);
    for (row, file) in rows.iter().zip([&original, &larger, &coarse]) {
        let alone = json(&[&["distance", file.as_str(), &original][..], &samples].concat());
        for key in ["mean", "rms", "max", "faces"] {
            assert_eq!(row[key], alone[key], "{file}: {key}");
        }
        let [max, proved] = ["max", "proved_max"].map(|key| row[key].as_f64().unwrap());
        let slack = 0.01 * report["bbox_diagonal"].as_f64().unwrap();
        assert!(max <= proved && proved <= max + 2.0 * slack, "{max} {proved}");
    }
    let value = |row: usize, key: &str| rows[row][key].as_f64().unwrap();
    assert!(value(0, "max") < 1e-9 && value(0, "normal_deviation") < 1e-6);
    assert!((value(1, "mean") - 0.1).abs() < 1e-3 && (value(1, "max") - 0.1).abs() < 1e-3);
    assert!(value(1, "normal_deviation") < 1.0);
    // Faces of a coarse sphere are about 10 degrees apart.
    assert!((1.0..20.0).contains(&value(2, "normal_deviation")));

    let page = path("page.html");
    let output = crate::common::curvmesh(&[&compare[..], &samples, &["--view", &page]].concat());
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(table.lines().count(), 5, "{table}");
    assert!(std::fs::read_to_string(page).unwrap().contains("larger.ply"));
}

/// Points are measured from a surface in one direction, like `distance` measures them; two clouds in both.
#[test]
fn points_are_compared_as_distance_measures_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let [sphere, cloud, page] = ["sphere.ply", "cloud.ply", "page.html"].map(path);
    write(Sphere { radius: 1.0 }.icosphere(3).unwrap(), sphere.as_ref());
    let none: &[[u32; 3]] = &[];
    let points = [[2.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 3.0]];
    write(mesh_core::PolygonSoup::from_triangles(&points, none).unwrap(), cloud.as_ref());
    for (reference, file, side) in [
        (&sphere, &cloud, Some("forward")),
        (&cloud, &sphere, Some("backward")),
        (&cloud, &cloud, None),
    ] {
        let row = &json(&["compare", reference, file])["files"][0];
        let alone = json(&["distance", file, reference]);
        for key in ["mean", "rms", "max"] {
            let expected = side.map_or(&alone[key], |side| &alone[side][key]);
            assert_eq!(row[key], *expected, "{reference} {file}: {key}");
        }
        assert_eq!(row["one_sided"], side.is_some());
        assert!(row["normal_deviation"].is_null());
        for (option, value) in [("--exact", "1%"), ("--view", page.as_str())] {
            let (status, message) = code(&["compare", reference, file, option, value]);
            assert!(status == 2 && message.contains(option), "{status} {message}");
        }
    }
}

#[test]
fn options_without_an_effect_are_refused() {
    let (status, message) = code(&["compare", "a.ply", "b.ply", "--colormap", "magma"]);
    assert!(status == 2 && message.contains("--view"), "{status} {message}");
    let (status, message) = code(&["compare", "-", "-"]);
    assert!(status == 2 && message.contains("one of the files"), "{status} {message}");
}
