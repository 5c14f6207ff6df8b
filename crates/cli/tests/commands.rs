//! The commands on small generated meshes: results, exit codes, and files that stay unchanged on failure.
#![allow(clippy::unwrap_used, clippy::float_cmp)]

use std::path::Path;

use crate::common::{code, curvmesh, json, write};
use mesh_core::PolygonSoup;
use mesh_io::{Model, WriteOptions};
use mesh_shapes::{Torus, polyhedra};

fn torus(folder: &Path) -> String {
    let path = folder.join("torus.ply");
    write(Torus { major: 5.0, minor: 2.0 }.shifted_mesh(12, 6).unwrap(), &path);
    path.to_str().unwrap().to_owned()
}

/// Three triangles on one edge.
fn book(folder: &Path) -> String {
    let mut soup = PolygonSoup::new();
    for i in 0..5 {
        let t = f64::from(i);
        soup.push_vertex([t, t * t, t * t * t]);
    }
    for face in [[0, 1, 2], [1, 0, 3], [0, 1, 4]] {
        soup.push_face(&face).unwrap();
    }
    let path = folder.join("book.off");
    write(soup, &path);
    path.to_str().unwrap().to_owned()
}

#[test]
fn info_counts_and_measures() {
    let folder = tempfile::tempdir().unwrap();
    let info = json(&["info", &torus(folder.path())]);
    for (key, value) in [("vertices", 72), ("faces", 144), ("edges", 216), ("components", 1)] {
        assert_eq!(info[key], value, "{key}");
    }
    for (key, value) in [("euler_characteristic", 0), ("boundary_edges", 0), ("boundary_loops", 0)]
    {
        assert_eq!(info[key], value, "{key}");
    }
    for key in ["closed", "manifold", "oriented"] {
        assert_eq!(info[key], true, "{key}");
    }
    let bound = info["bbox_max"][0].as_f64().unwrap();
    assert!((bound - 7.0).abs() < 1e-6);
    for key in ["load", "compute", "save", "total"] {
        assert!(info["seconds"][key].is_number(), "{key}");
    }
}

#[test]
fn info_measures_a_cube() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cube.stl");
    write(polyhedra::cube(), &path);
    let info = json(&["info", path.to_str().unwrap()]);
    assert_eq!((&info["area"], &info["volume"]), (&24.0.into(), &8.0.into()));
    assert_eq!(info["bbox_min"], serde_json::json!([-1.0, -1.0, -1.0]));
}

#[test]
fn info_works_on_defects_and_repairs_cure_them() {
    let folder = tempfile::tempdir().unwrap();
    let book = book(folder.path());
    let info = json(&["info", &book]);
    assert_eq!((&info["manifold"], &info["non_manifold_edges"]), (&false.into(), &1.into()));
    assert_eq!(info["volume"], serde_json::Value::Null);
    let cured = json(&["info", &book, "--lenient"]);
    assert_eq!((&cured["manifold"], &cured["vertices"]), (&true.into(), &7.into()));
}

/// A closed surface whose faces have vertices of their own, in the formats that keep them apart: every command on a
/// surface works on the closed surface, and says so.
#[test]
fn faces_with_vertices_of_their_own_are_joined() {
    let folder = tempfile::tempdir().unwrap();
    let whole = Torus { major: 5.0, minor: 2.0 }.shifted_mesh(24, 12).unwrap();
    let mut soup = PolygonSoup::new();
    for face in whole.faces() {
        let first = soup.vertex_count() as u32;
        face.iter().for_each(|&v| soup.push_vertex(whole.positions()[v as usize]));
        soup.push_face(&(first..).take(face.len()).collect::<Vec<_>>()).unwrap();
    }
    for extension in ["ply", "obj", "off"] {
        let path = folder.path().join("soup").with_extension(extension);
        write(soup.clone(), &path);
        let input = path.to_str().unwrap();
        let info = json(&["info", input]);
        assert_eq!(info["seam_edges"], info["boundary_edges"]);
        let out = folder.path().join("out").with_extension(extension);
        let output = out.to_str().unwrap();
        for command in [
            &["simplify", input, "-o", output, "--ratio", "0.5"][..],
            &["flip", input, "-o", output],
            &["curvature", input, "-o", output],
        ] {
            let report = json(command);
            assert!(report["repairs"].to_string().contains("merged vertices"), "{report}");
            let made = json(&["info", output]);
            assert_eq!((&made["closed"], &made["components"]), (&true.into(), &1.into()));
        }
        let kept = json(&["simplify", input, "-o", output, "--ratio", "0.5", "--weld", "none"]);
        assert!(kept.get("repairs").is_none(), "{kept}");
        let copied = json(&["convert", input, "-o", output]);
        assert_eq!(copied["vertices"], soup.vertex_count());
    }
    // A format that splits vertices: `info` sees the mesh that the others see.
    let path = folder.path().join("soup.glb");
    write(soup.clone(), &path);
    let path = path.to_str().unwrap();
    let info = json(&["info", path]);
    let count = |key: &str| info[key].as_u64().unwrap() as usize;
    assert_eq!(
        (&info["closed"], count("vertices")),
        (&true.into(), whole.vertex_count()),
        "{info}"
    );
    assert_eq!(count("joined_vertices") + count("vertices"), 3 * count("triangles"));
    let apart = json(&["info", path, "--weld", "none"]);
    assert_eq!((&apart["closed"], &apart["joined_vertices"]), (&false.into(), &0.into()));
}

/// Patches whose common points differ by rounding stay apart; the message names the gap and the option that closes it.
#[test]
fn cracks_are_named_with_their_cure() {
    let folder = tempfile::tempdir().unwrap();
    let mut soup = PolygonSoup::new();
    for strip in 0..2_u32 {
        let first = 12 * strip;
        for (y, x) in (0..6).flat_map(|y| (0..2).map(move |x| (y, x))) {
            soup.push_vertex([f64::from(strip) * (1.0 + 1e-6) + f64::from(x), f64::from(y), 0.0]);
        }
        for v in (0..5).map(|y| first + 2 * y) {
            soup.push_face(&[v, v + 1, v + 3, v + 2]).unwrap();
        }
    }
    let path = folder.path().join("strips.obj");
    write(soup, &path);
    let input = path.to_str().unwrap();
    let output = folder.path().join("out.obj");
    let fixed = ["repair", input, "-o", output.to_str().unwrap()];
    let report = json(&fixed);
    let what = report["stayed"][0]["what"].as_str().unwrap();
    let weld = what.split("--weld ").nth(1).unwrap().split(' ').next().unwrap();
    let report = json(&[&fixed[..], &["--weld", weld]].concat());
    assert!(report.get("stayed").is_none(), "{report}");
    assert_eq!(json(&["info", output.to_str().unwrap()])["boundary_loops"], 1);
}

#[test]
fn flip_reaches_the_published_triangulation() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.obj");
    let report =
        json(&["flip", &torus(folder.path()), "-o", out.to_str().unwrap(), "--cost", "f2"]);
    assert_eq!((&report["flips"], &report["stop"]), (&54.into(), &"local-minimum".into()));
    assert!((report["cost_before"].as_f64().unwrap() - 220.300037).abs() < 1e-5);
    assert!((report["cost_after"].as_f64().unwrap() - 138.196323).abs() < 1e-5);
    let info = json(&["info", out.to_str().unwrap()]);
    assert_eq!((&info["closed"], &info["euler_characteristic"]), (&true.into(), &0.into()));
}

/// Two texture charts on a bumpy grid: after flips, each corner still has the texture coordinate of its vertex in its
/// chart.
#[test]
fn flip_keeps_texture_seams_and_coordinates() {
    let cells = 8_u32;
    let at = |i: u32, j: u32| i * (cells + 1) + j;
    let mut soup = PolygonSoup::new();
    for i in 0..=cells {
        for j in 0..=cells {
            let (x, y) = (f64::from(i), f64::from(j));
            soup.push_vertex([x, y, (1.3 * x + 0.4 * y * y).sin()]);
        }
    }
    let chart = |x: f64, y: f64, second: bool| {
        if second {
            [y as f32 / 16.0 + 0.5, x as f32 / 16.0]
        } else {
            [x as f32 / 16.0, y as f32 / 16.0]
        }
    };
    let mut uvs = Vec::new();
    let mut materials = Vec::new();
    for i in 0..cells {
        for j in 0..cells {
            let second = i >= cells / 2;
            for face in [
                [at(i, j), at(i + 1, j), at(i + 1, j + 1)],
                [at(i, j), at(i + 1, j + 1), at(i, j + 1)],
            ] {
                soup.push_face(&face).unwrap();
                materials.push(u32::from(second));
                for v in face {
                    let p = soup.positions()[v as usize];
                    uvs.push(chart(p.x, p.y, second));
                }
            }
        }
    }
    let model = Model { corner_uvs: Some(uvs), ..Model::from(soup) };
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in.obj"), folder.path().join("out.obj"));
    mesh_io::write(&input, &model, &WriteOptions::default()).unwrap();
    let report =
        json(&["flip", input.to_str().unwrap(), "-o", output.to_str().unwrap(), "--cost", "f2"]);
    assert!(report["flips"].as_u64().unwrap() > 10, "{report}");

    let flipped = mesh_io::read(&output).unwrap();
    let uvs = flipped.corner_uvs.as_ref().unwrap();
    for face in 0..flipped.soup.face_count() {
        let corners = flipped.soup.face(face).to_vec();
        let points = corners.iter().map(|&v| flipped.soup.positions()[v as usize]);
        let points: Vec<_> = points.collect();
        let middle = points.iter().map(|p| p.x).sum::<f64>() / 3.0;
        let second = middle > f64::from(cells / 2);
        for (corner, p) in flipped.soup.corner_range(face).zip(&points) {
            assert_eq!(uvs[corner], chart(p.x, p.y, second), "face {face}");
        }
    }
}

#[test]
fn exit_codes_tell_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (good, bad) = (torus(folder.path()), book(folder.path()));

    assert_eq!(code(&["convert", &good, &path("out.xyz")]).0, 2);
    assert_eq!(code(&["flip", &good, "-o", &path("o.ply"), "--cost", "f9"]).0, 2);

    let (status, message) = code(&["info", &path("missing.ply")]);
    assert_eq!(status, 3, "{message}");
    std::fs::write(path("bad.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n").unwrap();
    let (status, message) = code(&["info", &path("bad.off")]);
    assert_eq!(status, 3);
    assert!(message.contains("line 6"), "{message}");
    std::fs::write(path("nan.obj"), "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let (status, message) = code(&["flip", &path("nan.obj"), "-o", &path("o.ply"), "--cost", "f2"]);
    assert_eq!(status, 3);
    assert!(message.contains("vertex 0"), "{message}");

    let (status, message) = code(&["flip", &bad, "-o", &path("o.ply"), "--strict"]);
    assert_eq!(status, 4);
    assert!(message.contains("--cut-non-manifold") && message.contains("0"), "{message}");

    let (status, message) = code(&["convert", &good, &path("no/such/folder/o.ply")]);
    assert_eq!(status, 1, "{message}");
}

#[test]
fn json_is_the_only_thing_on_stdout() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.stl");
    let output =
        curvmesh(&["convert", &book(folder.path()), out.to_str().unwrap(), "--json", "--lenient"]);
    assert!(serde_json::from_slice::<serde_json::Value>(&output.stdout).is_ok());
    assert!(String::from_utf8_lossy(&output.stderr).contains("cut along edges"));
    let quiet = curvmesh(&[
        "convert",
        &book(folder.path()),
        out.to_str().unwrap(),
        "-q",
        "--json",
        "--lenient",
    ]);
    assert!(quiet.status.success() && quiet.stderr.is_empty());
}

/// An output that cannot be completed leaves the existing file.
#[test]
fn a_failed_write_leaves_the_old_file_whole() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("old.ply");
    write(polyhedra::tetrahedron(), &target);
    let before = std::fs::read(&target).unwrap();
    // A coordinate beyond 32 bits cannot be written in single precision.
    let huge = folder.path().join("huge.obj");
    std::fs::write(&huge, "v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let (status, message) = code(&[
        "convert",
        huge.to_str().unwrap(),
        target.to_str().unwrap(),
        "--precision",
        "single",
    ]);
    assert_eq!(status, 4, "{message}");
    assert_eq!(std::fs::read(&target).unwrap(), before);
    let leftovers = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(leftovers, 2, "temporary files stay behind");
}

#[test]
fn trap_17_the_bytes_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("big.ply");
    write(Torus { major: 5.0, minor: 2.0 }.shifted_mesh(120, 60).unwrap(), &path);
    let bytes = |threads: &str| {
        let out = folder.path().join(format!("out{threads}.ply"));
        let arguments = ["flip", path.to_str().unwrap(), "-o", out.to_str().unwrap()];
        let run = curvmesh(&[&arguments[..], &["--cost", "f1", "--threads", threads]].concat());
        assert!(run.status.success());
        std::fs::read(out).unwrap()
    };
    let one = bytes("1");
    assert!(one == bytes("2") && one == bytes("8"));
}

/// The missing folder is reported before the input is read, which does not exist either.
#[test]
fn a_folder_that_is_not_there_is_named_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output, record, plain] =
        ["in.ply", "none/out.ply", "none/out.json", "out.ply"].map(|name| folder.path().join(name));
    let [input, output, record, plain] =
        [&input, &output, &record, &plain].map(|path| path.to_str().unwrap());
    for arguments in [
        &["convert", input, output][..],
        &["simplify", input, "-o", output, "--faces", "100"],
        &["flip", input, "-o", output, "--cost", "f2"],
        &["patch", input, "-o", record, "--tolerance", "1%"],
        &["distance", input, input, "-o", output],
    ] {
        let (status, message) = code(arguments);
        assert_eq!(status, 1, "{arguments:?}: {message}");
        assert!(message.contains("there is no folder") && message.contains("none"), "{message}");
    }
    let (_, message) = code(&["convert", input, plain]);
    assert!(!message.contains("there is no folder"), "{message}");
}

/// A disk that becomes full, simulated by a limit on the size of files.
#[test]
#[cfg(unix)]
fn a_full_disk_leaves_the_old_file_whole() {
    let folder = tempfile::tempdir().unwrap();
    let (big, target) = (folder.path().join("big.ply"), folder.path().join("old.ply"));
    write(Torus { major: 5.0, minor: 2.0 }.mesh(100, 50).unwrap(), &big);
    write(polyhedra::tetrahedron(), &target);
    let before = std::fs::read(&target).unwrap();
    for blocks in [0, 1, 8, 100] {
        let script = format!("ulimit -f {blocks}; trap '' XFSZ; exec \"$@\"");
        let run = std::process::Command::new("sh")
            .args(["-c", &script, "sh", env!("CARGO_BIN_EXE_curvmesh"), "convert"])
            .args([&big, &target])
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(1), "{blocks}: {message}");
        assert!(message.contains("cannot write"), "{message}");
        assert_eq!(std::fs::read(&target).unwrap(), before);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "leftovers");
    }
}

/// Killed at any moment, the program leaves the old file or the new one.
#[test]
fn an_interrupted_write_leaves_one_whole_file() {
    let folder = tempfile::tempdir().unwrap();
    let (big, target) = (folder.path().join("big.ply"), folder.path().join("old.obj"));
    write(Torus { major: 5.0, minor: 2.0 }.mesh(400, 200).unwrap(), &big);
    write(polyhedra::tetrahedron(), &target);
    let old = std::fs::read(&target).unwrap();
    let command = || {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_curvmesh"));
        command.args(["convert", "-q"]).args([&big, &target]);
        command.stdout(std::process::Stdio::null());
        command
    };
    assert!(command().status().unwrap().success());
    let new = std::fs::read(&target).unwrap();
    for milliseconds in (0..120).step_by(6) {
        std::fs::write(&target, &old).unwrap();
        let mut run = command().spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(milliseconds));
        run.kill().unwrap();
        run.wait().unwrap();
        let found = std::fs::read(&target).unwrap();
        assert!(found == old || found == new, "after {milliseconds} ms: {} bytes", found.len());
    }
}

/// Strips of a coarse tube are longer than wide. Delaunay flips twist them, and the tube gets narrower.
#[test]
fn flips_tell_how_they_change_the_volume() {
    let folder = tempfile::tempdir().unwrap();
    let [tube, output] = ["tube.obj", "out.obj"].map(|name| folder.path().join(name));
    let (rings, sides) = (12, 24);
    let mut text = String::new();
    for (ring, side) in (0..rings).flat_map(|ring| (0..sides).map(move |side| (ring, side))) {
        let [around, along] = [(ring, rings), (side, sides)]
            .map(|(place, count)| std::f64::consts::TAU * f64::from(place) / f64::from(count));
        let radius = 50.0 + along.cos();
        let [x, y, z] = [radius * around.cos(), radius * around.sin(), along.sin()];
        text += &format!("v {x} {y} {z}\n");
    }
    for (ring, side) in (0..rings).flat_map(|ring| (0..sides).map(move |side| (ring, side))) {
        let vertex = |r: i32, s: i32| (ring + r) % rings * sides + (side + s) % sides + 1;
        let [a, b, c, d] = [vertex(0, 0), vertex(1, 0), vertex(1, 1), vertex(0, 1)];
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    std::fs::write(&tube, text).unwrap();
    let [tube, output] = [&tube, &output].map(|path| path.to_str().unwrap());
    let run = ["flip", tube, "-o", output, "--cost", "delaunay"];
    let report = json(&run);
    let volume = |path: &str| json(&["info", path])["volume"].as_f64().unwrap();
    for (key, path) in [("volume_before", tube), ("volume_after", output)] {
        let [told, is] = [report[key].as_f64().unwrap(), volume(path)];
        assert!((told / is - 1.0).abs() < 1e-9, "{key} {told} {is}");
    }
    let change = volume(output) / volume(tube) - 1.0;
    assert!(change.abs() > 0.01, "{change}");
    let said = String::from_utf8(curvmesh(&run).stderr).unwrap();
    assert!(said.contains(&format!("by {:.1} %", 100.0 * change)), "{said}");
    let kept = json(&[&run[..], &["--feature-angle", "1"]].concat());
    assert_eq!(kept["volume_before"], kept["volume_after"]);
    let open = folder.path().join("open.obj");
    std::fs::write(&open, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n").unwrap();
    let report = json(&["flip", open.to_str().unwrap()]);
    assert!(report.get("volume_before").is_none());
}
