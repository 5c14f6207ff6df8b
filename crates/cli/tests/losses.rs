//! Losses of a command are in its report and on stderr; labels stay labels.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use crate::common::{code, json};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvn 0 0 1\nl 1 2\np 1\ng a\ns 1\n\
                   f 1//1 2//1 3//1\nf 1//1 3//1 4//1\n";

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                   property float z\nproperty uchar part\nproperty float heat\nelement face 2\n\
                   property list uchar int vertex_indices\nproperty short label\nend_header\n\
                   0 0 0 10 0.5\n1 0 0 20 1\n1 1 0 30 2\n0 1 0.5 40 4\n3 0 1 2 -7\n3 0 2 3 9\n";

fn file(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

fn out(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().unwrap().to_owned()
}

/// The content lost by reading, by writing or by the command.
fn lost(report: &serde_json::Value, by: &str) -> Vec<String> {
    let all = report["lost"].as_array().unwrap();
    let of = all.iter().filter(|lost| lost["by"] == by);
    of.map(|lost| lost["what"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn losses_are_in_the_report_and_on_stderr() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let obj = file(folder, "a.obj", OBJ);
    let report = json(&["convert", &obj, "-o", &out(folder, "a.stl")]);
    assert_eq!(lost(&report, "reading"), ["lines", "points"]);
    let writing = lost(&report, "writing");
    for what in ["corner normals", "smoothing groups", "names of groups"] {
        assert!(writing.iter().any(|lost| lost == what), "{what}: {writing:?}");
    }
    let (status, said) = code(&["convert", &obj, "-o", &out(folder, "b.stl")]);
    assert_eq!(status, 0);
    assert!(said.contains("lost lines (1)") && said.contains("lost corner normals"), "{said}");
    // Content that the command itself omits.
    let report = json(&["subdivide", &obj, "-o", &out(folder, "a.glb")]);
    assert!(lost(&report, "subdivide").contains(&"normals".to_owned()), "{report}");
    // A report of a command that writes has the list, even when it is empty.
    let ply = file(folder, "a.ply", PLY);
    let report = json(&["convert", &ply, "-o", &out(folder, "b.ply")]);
    assert_eq!(report["lost"], serde_json::json!([]));
    assert!(json(&["info", &ply]).get("lost").is_none());
}

#[test]
fn types_and_labels_come_through() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let ply = file(folder, "a.ply", PLY);
    let fine = out(folder, "fine.ply");
    json(&["subdivide", &ply, "-o", &fine]);
    let model = mesh_io::read(&fine).unwrap();
    let types = |model: &mesh_io::Model| -> Vec<&str> {
        let all = model.vertex_scalars.iter().chain(&model.face_scalars);
        all.map(|scalars| scalars.values.scalar_type().ply_name()).collect()
    };
    assert_eq!(types(&model), ["uchar", "float", "short"]);
    assert!(model.vertex_scalars[0].values.iter().all(|part| part % 10.0 == 0.0));
    assert!(model.face_scalars[0].values.iter().all(|label| label == -7.0 || label == 9.0));
    json(&["subdivide", &ply, "-o", &fine, "--blend", "part", "--labels", "heat"]);
    let model = mesh_io::read(&fine).unwrap();
    assert_eq!(types(&model), ["uchar", "float", "short"]);
    assert!(model.vertex_scalars[0].values.iter().any(|part| part % 10.0 != 0.0));
    let known = [0.5, 1.0, 2.0, 4.0];
    assert!(model.vertex_scalars[1].values.iter().all(|heat| known.contains(&heat)));
    let (status, said) = code(&["subdivide", &ply, "-o", &fine, "--labels", "weight"]);
    assert_eq!(status, 2);
    assert!(said.contains("weight") && said.contains("part, heat, label"), "{said}");
}

#[test]
fn what_results_replace_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let ply = PLY
        .replace("uchar part", "uchar red\nproperty uchar green\nproperty uchar blue")
        .replace("float heat", "float k1\nproperty float distance")
        .replace(" 10 0.5", " 9 8 7 1 1")
        .replace(" 20 1\n", " 9 8 7 1 1\n")
        .replace(" 30 2", " 9 8 7 1 1")
        .replace(" 40 4", " 9 8 7 1 1")
        .replace("short label", "short K_known");
    let ply = file(folder, "a.ply", &ply);
    let output = out(folder, "b.ply");
    for estimator in ["auto", "vertex", "fit"] {
        let report = json(&["curvature", &ply, "-o", &output, "--estimator", estimator]);
        assert_eq!(lost(&report, "curvature"), ["colours", "numbers k1"], "{estimator}");
    }
    let report = json(&["distance", &ply, &ply, "-o", &output]);
    assert_eq!(lost(&report, "distance"), ["colours", "numbers distance"]);
    // Nothing is replaced where nothing was.
    let plain = file(folder, "plain.obj", OBJ);
    let report = json(&["curvature", &plain, "-o", &output]);
    assert!(lost(&report, "curvature").iter().all(|what| !what.contains("colours")), "{report}");
}
