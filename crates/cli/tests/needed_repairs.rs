//! Meshes that are no oriented 2-manifold, with commands that need one.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use mesh_shapes::Torus;

use crate::common::{code, curvmesh, json, write};

/// A defect of each kind, and the name of its repair in the message.
const DEFECTS: [(&str, &str, &str); 7] = [
    (
        "duplicate face",
        "OFF\n4 5 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n3 2 0 3\n",
        "dropped duplicate triangles: 1",
    ),
    (
        "repeated vertex",
        "OFF\n4 5 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n3 1 1 2\n",
        "dropped degenerate triangles: 1",
    ),
    (
        "three faces at an edge",
        "OFF\n5 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 -1 1\n3 0 1 2\n3 1 0 3\n3 0 1 4\n",
        "cut edges: 1",
    ),
    (
        "two tetrahedra at a vertex",
        "OFF\n7 8 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n-1 0 0\n0 -1 0\n0 0 -1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n3 0 4 5\n3 0 6 4\n3 4 6 5\n3 5 6 0\n",
        "duplicated vertices: 1",
    ),
    (
        "a reversed face",
        "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 3 0\n",
        "reversed triangles: 1",
    ),
    (
        "a Moebius strip",
        "OFF\n6 6 0\n2 0 0\n1 0 1\n-1 2 0\n-1 1 1\n-1 -2 0\n-1 -1 1\n3 0 1 2\n3 2 1 3\n3 2 3 4\n3 4 3 5\n3 4 5 1\n3 1 5 0\n",
        "cut edges",
    ),
    (
        "vertices at no place",
        "OFF\n5 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 nan inf\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 4\n",
        "dropped faces with infinite or undefined positions: 1",
    ),
];

/// Every command that needs a manifold, in its simplest form.
fn commands(input: &str, folder: &Path) -> Vec<Vec<String>> {
    let out = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let words = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect::<Vec<_>>();
    vec![
        words(&["simplify", input, "-o", &out("small.ply")]),
        words(&["curvature", input, "-o", &out("curved.ply")]),
        words(&["flip", input, "-o", &out("flipped.ply")]),
        words(&["subdivide", input, "-o", &out("fine.ply")]),
        words(&["lod", input, "-o", &out("levels"), "--levels", "0.5"]),
        words(&["patch", input, "-o", &out("cover.ply")]),
        words(&["render", input, "-o", &out("picture.png"), "--size", "8,8"]),
        words(&["view", input, "-o", &out("page.html"), "--curvature"]),
    ]
}

#[test]
fn a_defect_of_any_kind_is_repaired_and_named() {
    for (kind, text, repair) in DEFECTS {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("in.off");
        std::fs::write(&input, text).unwrap();
        for command in commands(input.to_str().unwrap(), folder.path()) {
            let words: Vec<&str> = command.iter().map(String::as_str).collect();
            let (status, message) = code(&words);
            assert_eq!(status, 0, "{kind}: {words:?}: {message}");
            assert!(message.contains(repair), "{kind}: {words:?}: {message}");
            let line = message.lines().find(|line| line.contains(repair)).unwrap();
            assert!(line.contains("--strict"), "{line}");
            let (status, message) = code(&[&words[..], &["--strict"]].concat());
            // Numbers that are none make a file invalid.
            let refused = if kind == "vertices at no place" { 3 } else { 4 };
            assert_eq!(status, refused, "{kind}: {words:?}: {message}");
        }
    }
}

#[test]
fn the_report_lists_the_repairs() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("in.off");
    std::fs::write(&input, DEFECTS[0].1).unwrap();
    let (input, output) = (input.to_str().unwrap(), folder.path().join("out.ply"));
    let report = json(&["flip", input, "-o", output.to_str().unwrap()]);
    let repair = &report["repairs"][0];
    assert_eq!(repair["what"], "dropped duplicate triangles");
    assert_eq!((&repair["count"], &repair["file"]), (&1.into(), &input.into()));
}

/// Files with vertices at no place, as depth cameras make them, are measured and shown without their faces.
#[test]
fn faces_at_no_place_are_not_measured() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (scan, whole) = (path("scan.obj"), path("whole.obj"));
    let text = |height: &str| {
        format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 {height}\nf 1 2 3 4\nf 2 5 3\n")
    };
    std::fs::write(&scan, text("nan")).unwrap();
    std::fs::write(&whole, text("0")).unwrap();
    for command in [["distance", &scan, &whole], ["compare", &whole, &scan]] {
        let report = json(&command);
        assert_eq!(report["repairs"][0]["count"], 1, "{report}");
        assert_eq!(code(&[&command[..], &["--strict"]].concat()).0, 3);
    }
    let found = json(&["distance", &scan, &whole, "--samples", "20000"]);
    assert_eq!(found["forward"]["max"], 0.0, "{found}");
    assert!((found["backward"]["max"].as_f64().unwrap() - 1.0).abs() < 0.01, "{found}");
    let (status, message) = code(&["view", &scan, "-o", &path("page.html")]);
    assert!(status == 0 && message.contains("undefined positions: 1"), "{message}");
    // A conversion copies the file as it is.
    assert_eq!(code(&["convert", &scan, &path("copy.obj")]), (0, String::new()));
    assert!(std::fs::read_to_string(path("copy.obj")).unwrap().to_lowercase().contains("nan"));
}

/// With `--memory`, the same faces are dropped, in formats with and without vertices.
#[test]
fn faces_at_no_place_are_dropped_out_of_core() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let mut soup = Torus { major: 5.0, minor: 2.0 }.shifted_mesh(24, 12).unwrap();
    for vertex in [7, 100, 101] {
        soup.positions_mut()[vertex].y = f64::NAN;
    }
    for name in ["in.ply", "in.obj", "in.off", "in.stl"] {
        let input = path(name);
        let model = mesh_io::Model::from(soup.clone());
        mesh_io::write(&input, &model, &mesh_io::WriteOptions::default()).unwrap();
        let work = path("work");
        let split = ["region", "split", &input, "-w", &work, "--faces", "100", "--memory", "64MiB"];
        let (status, message) = code(&[&split[..], &["--strict"]].concat());
        assert!(status == 3 && message.contains("NaN"), "{name}: {message}");
        let (status, message) = code(&split);
        assert!(status == 0 && message.contains("at them: 16"), "{name}: {message}");
        std::fs::remove_dir_all(work).unwrap();
    }
}

/// Defects that cannot be repaired without a guess are refused.
#[test]
fn a_face_without_its_vertex_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("in.obj");
    std::fs::write(&input, "v 0 0 0\nv 1 0 0\nv 0 1 nan\nf 1 2 3\n").unwrap();
    for command in commands(input.to_str().unwrap(), folder.path()) {
        let words: Vec<&str> = command.iter().map(String::as_str).collect();
        assert_eq!(code(&words).0, 3, "{words:?}");
    }
}

/// A valid mesh has the same result with and without `--strict`, and no message.
#[test]
fn a_sound_mesh_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let input = path("torus.ply");
    write(Torus { major: 5.0, minor: 2.0 }.shifted_mesh(24, 12).unwrap(), Path::new(&input));
    let [repaired, strict] = [path("a.ply"), path("b.ply")];
    let run = curvmesh(&["flip", &input, "-o", &repaired]);
    assert!(run.status.success() && run.stderr.is_empty());
    assert_eq!(code(&["flip", &input, "-o", &strict, "--strict"]).0, 0);
    assert!(std::fs::read(repaired).unwrap() == std::fs::read(strict).unwrap());
}

#[test]
fn counts_and_shares_are_read_as_people_write_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (input, output) = (path("torus.ply"), path("out.ply"));
    write(Torus { major: 5.0, minor: 2.0 }.shifted_mesh(50, 40).unwrap(), Path::new(&input));
    let faces = |target: &[&str]| {
        let run = ["simplify", &input, "-o", &output, "--preset", "draft"];
        json(&[&run[..], target].concat())["faces_out"].as_u64().unwrap()
    };
    assert_eq!(faces(&["--ratio", "10%"]), 400);
    assert_eq!(faces(&["--ratio", "0.1"]), 400);
    assert_eq!(faces(&["--faces", "1k"]), 1000);
    assert_eq!(faces(&["--faces", "0.5K"]), 500);
    assert_eq!(faces(&[]), 2000);
    for (option, value) in
        [("--ratio", "110%"), ("--ratio", "x%"), ("--faces", "-1k"), ("--faces", "k")]
    {
        let target = format!("{option}={value}");
        assert_eq!(code(&["simplify", &input, "-o", &output, &target]).0, 2, "{target}");
    }
    let (_, message) = code(&["simplify", &input, "-o", &output]);
    assert!(message.contains("half of the faces"), "{message}");
}

/// Without `-o`, the page is written beside the input; another file of that name is kept.
#[test]
fn a_page_goes_beside_its_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let [input, page] = ["torus.ply", "torus.html"].map(|name| folder.path().join(name));
    write(Torus { major: 5.0, minor: 2.0 }.shifted_mesh(8, 6).unwrap(), &input);
    let view = || {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_curvmesh"));
        command.args(["view", input.to_str().unwrap()]);
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").output().unwrap()
    };
    // A second page replaces the first one.
    assert!(view().status.success() && view().status.success());
    assert!(std::fs::read_to_string(&page).unwrap().contains("<canvas"));
    std::fs::write(&page, "<html>mine</html>").unwrap();
    let refused = view();
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("-o PAGE.html"));
    assert_eq!(std::fs::read_to_string(&page).unwrap(), "<html>mine</html>");
}
