//! Constraints of `simplify` and the size of its file, on generated meshes.
#![allow(clippy::unwrap_used, clippy::float_cmp)]

use std::collections::HashSet;
use std::path::Path;

use crate::common::{code, json};
use glam::DVec3;
use mesh_io::{Model, Scalars, WriteOptions};
use mesh_shapes::Sphere;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A sphere with marks: vertices near the north pole, faces near the south pole, and importance along x.
fn marked(path: &Path) -> Model {
    let mut model = Model::from(Sphere { radius: 1.0 }.icosphere(4).unwrap());
    // Coordinates that a file keeps exactly.
    let positions =
        model.soup.positions().iter().map(|p| p.as_vec3().as_dvec3()).collect::<Vec<_>>();
    let faces: Vec<[u32; 3]> = model.soup.faces().map(|f| f.try_into().unwrap()).collect();
    model.soup = mesh_core::PolygonSoup::from_triangles(&positions, &faces).unwrap();
    let vertices: Vec<u8> = positions.iter().map(|p| u8::from(p.z > 0.95)).collect();
    let of_face = |f: &[u32; 3]| f.iter().map(|&v| positions[v as usize].z).sum::<f64>() < -2.9;
    let marks: Vec<i32> = faces.iter().map(|f| i32::from(of_face(f))).collect();
    let weights: Vec<f32> = positions.iter().map(|p| if p.x > 0.0 { 50.0 } else { 1.0 }).collect();
    model.vertex_scalars = vec![Scalars::new("pole", vertices), Scalars::new("weight", weights)];
    model.face_scalars = vec![Scalars::new("pole", marks)];
    mesh_io::write(path, &model, &WriteOptions::default()).unwrap();
    model
}

fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

fn triangles(model: &Model) -> HashSet<Vec<[u64; 3]>> {
    let corners = |face: &[u32]| {
        let mut corners: Vec<_> =
            face.iter().map(|&v| bits(model.soup.positions()[v as usize])).collect();
        corners.sort_unstable();
        corners
    };
    model.soup.faces().map(corners).collect()
}

#[test]
fn marked_elements_are_in_the_file_of_the_result() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.ply", "out.ply"].map(|name| folder.path().join(name));
    let model = marked(&input);
    for preset in ["draft", "default", "quality"] {
        let report = json(&[
            "simplify",
            text(&input),
            "-o",
            text(&output),
            "--ratio",
            "0.1",
            "--keep",
            "pole",
            "--preset",
            preset,
            "--precision",
            "double",
        ]);
        assert_eq!(report["settings"]["keep"], "pole");
        assert!(report.get("unreached").is_none(), "{report}");
        let result = mesh_io::read(&output).unwrap();
        let places: HashSet<_> = result.soup.positions().iter().map(|&p| bits(p)).collect();
        let marks = model.vertex_scalars[0].values.clone();
        for (v, &p) in model.soup.positions().iter().enumerate() {
            assert!(marks.get(v) == Some(0.0) || places.contains(&bits(p)), "{preset} {v}");
        }
        let (before, after) = (triangles(&model), triangles(&result));
        let kept: HashSet<_> = {
            let marks = &model.face_scalars[0].values;
            let faces = model.soup.faces().enumerate();
            let kept = faces.filter(|(f, _)| marks.get(*f) != Some(0.0)).map(|(_, face)| {
                let mut corners: Vec<_> =
                    face.iter().map(|&v| bits(model.soup.positions()[v as usize])).collect();
                corners.sort_unstable();
                corners
            });
            kept.collect()
        };
        assert!(kept.len() > 5 && kept.is_subset(&before) && kept.is_subset(&after), "{preset}");
    }
}

#[test]
fn limits_hold_in_the_file_and_a_target_that_they_exclude_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.ply", "out.ply"].map(|name| folder.path().join(name));
    marked(&input);
    let run = |more: &[&str]| {
        let arguments = ["simplify", text(&input), "-o", text(&output), "--precision", "double"];
        json(&[&arguments[..], more].concat())
    };
    let report =
        run(&["--faces", "40", "--max-edge", "10%", "--min-angle", "20", "--max-valence", "8"]);
    let diagonal = 12_f64.sqrt();
    let limits = &report["settings"]["protect"]["limits"];
    assert!((limits["max_edge"].as_f64().unwrap() / diagonal - 0.1).abs() < 1e-3, "{limits}");
    assert!((limits["min_angle"].as_f64().unwrap() - 20_f64.to_radians()).abs() < 1e-15);
    assert_eq!(limits["max_valence"], 8);
    let unreached = &report["unreached"];
    assert_eq!(
        (&unreached["wanted_faces"], &unreached["faces"]),
        (&40.into(), &report["faces_out"])
    );
    assert!(unreached["held_by"]["max_edge"].as_u64().unwrap() > 0, "{unreached}");
    let result = mesh_io::read(&output).unwrap();
    for face in result.soup.faces() {
        let corners: Vec<DVec3> =
            face.iter().map(|&v| result.soup.positions()[v as usize]).collect();
        for i in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
            assert!(a.distance(b) <= 0.1001 * diagonal);
            assert!((b - a).angle_between(c - a) >= 19.99_f64.to_radians());
        }
    }
    let (status, message) = code(&[
        "simplify",
        text(&input),
        "-o",
        text(&output),
        "--faces",
        "40",
        "--max-edge",
        "10%",
    ]);
    assert_eq!(status, 0);
    assert!(message.contains("target of 40 faces was not reached"), "{message}");
    assert!(message.contains("--max-edge"), "{message}");
    let report = run(&["--ratio", "0.05", "--weight", "weight"]);
    assert_eq!(report["settings"]["weight"], "weight");
    let result = mesh_io::read(&output).unwrap();
    let right = result.soup.positions().iter().filter(|p| p.x > 0.0).count();
    assert!(3 * right > 2 * result.soup.vertex_count(), "{right}");
}

#[test]
fn constraints_that_cannot_be_honoured_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.ply", "out.ply"].map(|name| folder.path().join(name));
    marked(&input);
    let refused = |more: &[&str], word: &str| {
        let arguments = ["simplify", text(&input), "-o", text(&output)];
        let (status, message) = code(&[&arguments[..], more].concat());
        assert!(status != 0 && message.contains(word), "{more:?} {status} {message}");
        assert!(!output.exists());
    };
    refused(&["--keep", "nothing"], "pole, weight");
    refused(&["--weight", "nothing"], "pole, weight");
    refused(&["--max-edge", "0"], "above zero");
    refused(&["--min-angle", "60"], "below 60");
    refused(&["--max-valence", "2"], "3");
    refused(&["--bytes", "5 bananas"], "size of a file");
    refused(&["--bytes", "5k", "--faces", "9"], "cannot be used with");
    for option in [
        &["--keep", "pole"][..],
        &["--weight", "weight"],
        &["--max-edge", "1"],
        &["--min-angle", "5"],
        &["--max-valence", "9"],
        &["--bytes", "5k"],
    ] {
        refused(&[option, &["--memory", "1M"]].concat(), option[0]);
    }
}

#[test]
fn the_file_is_the_largest_that_fits() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("in.ply");
    marked(&input);
    for (name, limit, bytes) in [
        ("a.ply", "30k", 30_000_u64),
        ("b.stl", "20KiB", 20_480),
        ("c.off", "25000", 25_000),
        ("d.glb", "0.02MB", 20_000),
        ("e.obj", "20kb", 20_000),
    ] {
        let output = folder.path().join(name);
        let run = |more: &[&str]| {
            let arguments = ["simplify", text(&input), "-o", text(&output), "--preset", "fast"];
            json(&[&arguments[..], more].concat())
        };
        let report = run(&["--bytes", limit]);
        let written = std::fs::metadata(&output).unwrap().len();
        let size = &report["size"];
        assert_eq!((&size["bytes"], &size["limit"]), (&written.into(), &bytes.into()));
        assert!(size["fits"] == true && written <= bytes, "{report}");
        // A closed mesh has an even number of faces. Two more do not fit.
        let more = (report["faces_out"].as_u64().unwrap() + 2).to_string();
        run(&["--faces", &more]);
        assert!(std::fs::metadata(&output).unwrap().len() > bytes, "{name}");
    }
    let output = folder.path().join("f.stl");
    let run = |limit: &str| {
        let arguments = ["simplify", text(&input), "-o", text(&output), "--bytes", limit];
        (json(&arguments), code(&arguments).1)
    };
    let (report, message) = run("1GB");
    assert_eq!((&report["faces_out"], &report["size"]["trials"]), (&report["faces_in"], &1.into()));
    assert!(message.contains("of 1000000000 bytes"), "{message}");
    let (report, message) = run("100");
    assert_eq!(report["size"]["fits"], false);
    assert!(message.contains("does not fit into 100 bytes"), "{message}");
}

#[test]
fn levels_of_detail_have_the_constraints_of_simplify() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.ply", "levels"].map(|name| folder.path().join(name));
    let model = marked(&input);
    let run = |more: &[&str]| {
        let common = ["lod", text(&input), "-o", text(&output), "--levels", "0.3,0.1"];
        json(&[&common[..], &["--to", "ply", "--precision", "double"], more].concat())
    };
    let report = run(&["--keep", "pole", "--weight", "weight", "--max-edge", "40%"]);
    let settings = &report["settings"];
    assert_eq!((&settings["keep"], &settings["weight"]), (&"pole".into(), &"weight".into()));
    let marks = &model.vertex_scalars[0].values;
    for level in 1..=2 {
        let result = mesh_io::read(output.join(format!("in-{level}.ply"))).unwrap();
        let places: HashSet<_> = result.soup.positions().iter().map(|&p| bits(p)).collect();
        for (v, &p) in model.soup.positions().iter().enumerate() {
            assert!(marks.get(v) == Some(0.0) || places.contains(&bits(p)), "{level} {v}");
        }
        let near = |x: f64| result.soup.positions().iter().filter(|p| p.x * x > 0.3).count();
        assert!(near(1.0) > 2 * near(-1.0), "{} {}", near(1.0), near(-1.0));
    }
    // What cannot be met together is said.
    let report = run(&["--max-edge", "2%"]);
    assert!(report["unreached"]["held_by"]["max_edge"].as_u64().unwrap() > 0, "{report}");
    let longest = |level: usize| {
        let result = mesh_io::read(output.join(format!("in-{level}.ply"))).unwrap();
        let at = |v: u32| result.soup.positions()[v as usize];
        let lengths = result
            .soup
            .faces()
            .flat_map(|f| [0, 1, 2].map(|i| at(f[i]).distance(at(f[(i + 1) % 3]))));
        lengths.fold(0.0, f64::max)
    };
    let diagonal = 2.0 * 3.0_f64.sqrt();
    let of_input = model.soup.faces().flat_map(|f| {
        let at = |v: u32| model.soup.positions()[v as usize];
        [0, 1, 2].map(|i| at(f[i]).distance(at(f[(i + 1) % 3])))
    });
    assert!(longest(2) <= of_input.fold(0.02 * diagonal, f64::max) * (1.0 + 1e-9));
    // A record has its collapses already.
    let record = folder.path().join("r.lod");
    run(&["--record", text(&record)]);
    let words =
        ["lod", text(&input), "-o", text(&output), "--replay", text(&record), "--max-edge", "2%"];
    let (status, message) = code(&words);
    assert_eq!(status, 2, "{message}");
    assert!(message.contains("--max-edge"), "{message}");
}

/// Kept faces that leave no room in the target do not make the other faces vanish.
#[test]
fn what_is_not_kept_gets_its_share() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.ply", "out.ply"].map(|name| folder.path().join(name));
    let mut model = Model::from(Sphere { radius: 1.0 }.icosphere(3).unwrap());
    let marks: Vec<u8> = (0..model.soup.face_count())
        .map(|face| {
            model.soup.face(face).iter().map(|&v| model.soup.positions()[v as usize].z).sum()
        })
        .map(|height: f64| u8::from(height < -1.5))
        .collect();
    let (all, kept) = (marks.len(), marks.iter().filter(|&&mark| mark == 1).count());
    model.face_scalars = vec![Scalars::new("south", marks)];
    mesh_io::write(&input, &model, &WriteOptions::default()).unwrap();
    for ratio in [0.1, 0.2] {
        let share = ((all - kept) as f64 * ratio).round() as usize;
        let run = ["simplify", text(&input), "-o", text(&output), "--keep", "south", "--ratio"];
        let ratio = ratio.to_string();
        let report = json(&[&run[..], &[&ratio]].concat());
        let faces = report["faces_out"].as_u64().unwrap() as usize;
        assert!((kept + share - 1..=kept + share).contains(&faces), "{faces} of {kept} + {share}");
        assert!(report["stayed"][0]["what"].as_str().unwrap().contains("no room"), "{report}");
        let found = json(&["distance", text(&input), text(&output)]);
        assert!(found["max"].as_f64().unwrap() < 0.2, "{found}");
    }
}
