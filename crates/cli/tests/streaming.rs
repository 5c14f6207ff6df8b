//! Streamed meshes that exceed the memory limit.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use crate::common::{code, json, write};
use mesh_shapes::Torus;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A torus with 200 faces per column.
fn torus(folder: &Path, name: &str, columns: usize) -> PathBuf {
    let input = folder.join(name);
    write(Torus { major: 5.0, minor: 2.0 }.shifted_mesh(columns, 100).unwrap(), &input);
    input
}

const LITTLE: [&str; 2] = ["--memory", "31MiB"];

#[test]
fn what_passes_by_is_what_it_is_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path(), "in.ply", 500);
    let at = |name: &str| folder.path().join(name);

    let info = ["info", text(&input)];
    let (mut whole, mut little) = (json(&info), json(&[&info[..], &LITTLE].concat()));
    let area = |report: &mut serde_json::Value| {
        let sizes = ["area", "volume"].map(|name| report[name].take().as_f64().unwrap());
        for other in ["options", "seconds"] {
            report[other].take();
        }
        sizes
    };
    let [a, b] = [area(&mut whole), area(&mut little)];
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-11 * a), "{a:?} {b:?}");
    // Orientation and seams need the whole mesh: they are unknown for a streamed mesh.
    for unknown in ["inside_out", "seam_edges"] {
        let found = [&mut whole, &mut little].map(|report| report[unknown].take());
        assert_eq!(found, [0.into(), serde_json::Value::Null]);
    }
    assert_eq!(whole, little);

    for (from, to) in
        [("in.ply", "a.stl"), ("a.stl", "b.ply"), ("in.ply", "c.obj"), ("c.obj", "d.ply")]
    {
        let (from, to, there) = (at(from), at(to), at(&format!("memory-{to}")));
        json(&["convert", text(&from), "-o", text(&there)]);
        json(&[&["convert", text(&from), "-o", text(&to)][..], &LITTLE].concat());
        assert!(std::fs::read(&to).unwrap() == std::fs::read(there).unwrap(), "{}", to.display());
    }

    for (extension, quantity) in [("ply", "mean"), ("obj", "gaussian")] {
        let [here, there] = ["here", "there"].map(|name| at(name).with_extension(extension));
        let curvature = |output: &Path, more: &[&str]| {
            let fixed = ["curvature", text(&input), "--quantity", quantity, "-o", text(output)];
            json(&[&fixed[..], &["--estimator", "vertex"], more].concat())
        };
        let [mut whole, mut little] = [curvature(&there, &[]), curvature(&here, &LITTLE)];
        assert!(std::fs::read(&here).unwrap() == std::fs::read(&there).unwrap(), "{extension}");
        for key in ["f1", "f2", "f3", "willmore", "integral_abs_gaussian", "norm_l1"] {
            let [a, b] = [&mut whole, &mut little].map(|found| found[key].take().as_f64().unwrap());
            assert!((a - b).abs() <= 1e-11 * a, "{key} {a} {b}");
        }
        for key in
            ["range", "clamped_vertices", "boundary_vertices", "vertices", "faces", "quantity"]
        {
            assert_eq!(whole[key], little[key], "{key}");
        }
    }

    let other = torus(folder.path(), "other.ply", 420);
    let distance = ["distance", text(&input), text(&other), "--samples", "20000"];
    let (whole, little) = (json(&distance), json(&[&distance[..], &LITTLE].concat()));
    for side in ["forward", "backward"] {
        assert_eq!(whole[side]["max"], little[side]["max"]);
        for key in ["mean", "rms"] {
            let [a, b] = [&whole, &little].map(|found| found[side][key].as_f64().unwrap());
            assert!((a - b).abs() <= 1e-11 * a, "{side} {key} {a} {b}");
        }
    }
    assert_eq!(whole["other_faces"], little["other_faces"]);
    // No temporary folder is left.
    let left: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .filter(|name| name.to_string_lossy().contains("work"))
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn what_cannot_be_done_as_a_stream_is_wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path(), "in.ply", 500);
    let output = folder.path().join("out.ply");
    let (input, output) = (text(&input), text(&output));
    let glb = folder.path().join("out.glb");
    let cases: &[&[&str]] = &[
        &["info", input, "--lenient"],
        &["convert", input, "-o", text(&glb)],
        &["convert", input, "-o", output, "--weld", "exact"],
        &["convert", input, "-o", output, "--resume"],
        &["curvature", input, "-o", output, "--estimator", "fit"],
        &["curvature", input, "-o", text(&glb)],
        &["curvature", input, "--view", output],
        &["curvature", input, "--drop-degenerate"],
        &["distance", input, input, "--exact", "1%"],
        &["distance", input, input, "-o", output],
        &["distance", input, input, "--view", output],
        &["distance", input, input, "--lenient"],
    ];
    for case in cases {
        let (code, message) = code(&[case, &LITTLE[..]].concat());
        assert_eq!(code, 2, "{case:?}: {message}");
    }
    let (code, message) = code(&["info", input, "--memory", "1MiB"]);
    assert!(code == 2 && message.contains("allow at least"), "{message}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn invalid_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                  property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    // A header that is too long for the memory limit.
    let padding = "comment ".to_owned() + &"x".repeat(1000) + "\n";
    let long = header.replace("element vertex", &(padding.repeat(3000) + "element vertex"));
    let cases = [
        (format!("{long}0 0 0\n"), 3),
        (format!("{long}0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"), 3),
        (format!("{long}0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n"), 3),
        (long.replace("vertex 3", "vertex 3000000000"), 3),
    ];
    for (content, expected) in cases {
        let input = folder.path().join("in.ply");
        std::fs::write(&input, content).unwrap();
        let output = folder.path().join("out.stl");
        for command in [
            &["info", text(&input)][..],
            &["convert", text(&input), "-o", text(&output)],
            &["curvature", text(&input)],
            &["distance", text(&input), text(&input)],
        ] {
            let (code, message) = code(&[command, &LITTLE].concat());
            assert!(code == expected && !output.exists(), "{command:?}: {code} {message}");
        }
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
