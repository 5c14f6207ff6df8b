//! Consistent conventions in all commands: lengths, standard input and output, names of options, and errors as JSON.
#![allow(clippy::unwrap_used, clippy::float_cmp)]

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::common::{code, curvmesh, json, write};
use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_shapes::{Sphere, Torus, polyhedra};
use serde_json::Value;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn torus(folder: &Path) -> String {
    let path = folder.join("torus.ply");
    write(Torus { major: 5.0, minor: 2.0 }.mesh(40, 20).unwrap(), &path);
    text(&path).to_owned()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Runs with this content on the standard input.
fn fed(arguments: &[&str], input: &[u8]) -> Output {
    let mut run = Command::new(env!("CARGO_BIN_EXE_curvmesh"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = run.stdin.take().unwrap();
    let input = input.to_vec();
    // A program that ends early does not read everything.
    let feeder = std::thread::spawn(move || drop(stdin.write_all(&input)));
    let output = run.wait_with_output().unwrap();
    feeder.join().unwrap();
    output
}

#[test]
fn a_percentage_and_a_relative_length_are_the_same_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let path = |name: &str| folder.path().join(name);
    let out = path("out.ply");
    let diagonal = number(&json(&["distance", &input, &input, "--samples", "10"])["bbox_diagonal"]);
    let units = |share: f64| format!("{:?}", share * diagonal);
    let runs: [(&[&str], &str, &str, f64); 5] = [
        (&["simplify", &input, "-o", text(&out)], "--max-error", "1", 0.01),
        (&["curvature", &input, "-o", text(&out), "--estimator", "face"], "--radius", "10", 0.1),
        (&["patch", &input, "-o", text(&out)], "--tolerance", "2", 0.02),
        (&["convert", &input, "-o", text(&out), "--lenient"], "--weld", "4", 0.04),
        (&["lod", &input, "-o", text(&out), "--preset", "fast"], "--errors", "1", 0.01),
    ];
    for (arguments, option, percent, share) in runs {
        let written = |length: &str, more: &[&str]| {
            json(&[arguments, &[option, length], more].concat());
            std::fs::read(&out).unwrap()
        };
        let in_units = written(&units(share), &[]);
        assert!(in_units == written(&format!("{percent}%"), &[]), "{option} {percent}%");
        assert!(in_units == written(&format!("{share}"), &["--relative"]), "{option} {share}");
    }
    let bounds = |length: &str, more: &[&str]| {
        let arguments = ["distance", &input, &input, "--samples", "10", "--exact", length];
        json(&[&arguments[..], more].concat())["hausdorff"].clone()
    };
    let in_units = bounds(&units(0.02), &[]);
    assert_eq!(in_units, bounds("2%", &[]));
    assert_eq!(in_units, bounds("0.02", &["--relative"]));
}

#[test]
fn options_that_would_do_nothing_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    let (ply, glb, record) = (path("o.ply"), path("o.glb"), path("o.json"));
    let runs: [(&[&str], &str); 25] = [
        (&["info", &input, "--relative"], "--relative"),
        (&["info", &input, "--relative", "--weld", "exact", "--resume"], "--resume"),
        (&["convert", &input, "-o", &glb, "--precision", "double"], "--precision"),
        (&["convert", &input, "-o", &glb, "--encoding", "big-endian"], "big-endian"),
        (&["convert", &input, "-o", &ply, "--relative"], "--relative"),
        (&["convert", &input, "-o", &ply, "--resume"], "--resume"),
        (&["curvature", &input, "--colormap", "magma"], "--colormap"),
        (&["curvature", &input, "--to", "ply"], "--to"),
        (&["curvature", &input, "--radius", "1"], "--radius"),
        (&["curvature", &input, "--preset", "paper"], "--preset"),
        (&["curvature", &input, "--estimator", "face", "--area", "voronoi"], "--area"),
        (&["flip", &input, "--cost", "f2", "--area", "voronoi"], "--area"),
        (&["flip", &input, "--cost", "f2", "--seed", "3"], "--seed"),
        (&["flip", &input, "--cost", "f2", "--keep-partial"], "--keep-partial"),
        (&["patch", &input, "-o", &record, "--tolerance", "1", "--encoding", "text"], "--encoding"),
        (
            &["simplify", &input, "-o", &ply, "--faces", "9", "--preset", "fast", "--seed", "2"],
            "--seed",
        ),
        (
            &[
                "simplify",
                &input,
                "-o",
                &ply,
                "--faces",
                "9",
                "--no-attributes",
                "--crease-angle",
                "9",
            ],
            "--crease-angle",
        ),
        (&["lod", &input, "-o", &ply, "--faces", "9", "--fit-rounds", "3"], "--fit-rounds"),
        (&["lod", &input, "-o", &ply, "--faces", "9", "--norm", "l1"], "--norm"),
        (
            &["simplify", &input, "-o", &ply, "--faces", "9", "--preset", "fast", "--norm", "l1"],
            "--norm",
        ),
        (&["simplify", &input, "-o", &ply, "--faces", "9", "--anneal-time", "3"], "--anneal-time"),
        (&["lod", &input, "-o", &ply, "--faces", "9", "--verify"], "--verify"),
        (
            &["lod", &input, "-o", &ply, "--faces", "9", "--replay", &record, "--preset", "fast"],
            "--preset",
        ),
        (&["distance", &input, &input, "--colormap", "magma"], "--colormap"),
        (&["distance", &input, &input, "--precision", "single"], "--precision"),
    ];
    for (arguments, option) in runs {
        let (status, message) = code(arguments);
        assert_eq!(status, 2, "{arguments:?}: {message}");
        assert!(message.contains(option), "{arguments:?}: {message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "something was written");
}

#[test]
fn the_standard_streams_take_the_place_of_files() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let bytes = std::fs::read(&input).unwrap();
    let out = folder.path().join("out.ply");
    let runs: [&[&str]; 7] = [
        &["convert"],
        &["curvature"],
        &["flip", "--cost", "f2"],
        &["simplify", "--faces", "300"],
        &["patch", "--tolerance", "2%"],
        &["lod", "--faces", "300", "--preset", "fast"],
        &["subdivide"],
    ];
    for arguments in runs {
        json(&[arguments, &[&input, "-o", text(&out)]].concat());
        let piped = fed(&[arguments, &["-", "-o", "-", "--to", "ply"]].concat(), &bytes);
        let message = String::from_utf8_lossy(&piped.stderr).into_owned();
        assert!(piped.status.success(), "{arguments:?}: {message}");
        assert!(piped.stdout == std::fs::read(&out).unwrap(), "{arguments:?}");
    }
    let piped = fed(&["info", "-", "--json"], &bytes);
    let report: Value = serde_json::from_slice(&piped.stdout).unwrap();
    assert_eq!((&report["input"], &report["faces"]), (&"-".into(), &1600.into()));
    let piped = fed(&["distance", &input, "-", "--samples", "100", "--json"], &bytes);
    let report: Value = serde_json::from_slice(&piped.stdout).unwrap();
    assert!(number(&report["max"]) < 1e-12);

    // Vertices without a header word are OFF only if the format is given.
    let bare = b"3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    assert_eq!(fed(&["info", "-"], bare).status.code(), Some(3));
    assert!(fed(&["info", "-", "--from", "off"], bare).status.success());
    for arguments in [
        &["convert", "-", "-o", "-"][..],
        &["convert", "-", "-o", "-", "--to", "ply", "--json"],
        &["convert", "-", &input, "-o", text(folder.path())],
        &["convert", "-", "-o", text(folder.path())],
        &["distance", "-", "-"],
        &["lod", &input, "-o", "-", "--to", "ply", "--faces", "9,8"],
    ] {
        let output = fed(arguments, &bytes);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        if arguments.contains(&"--json") {
            serde_json::from_slice::<Value>(&output.stdout).unwrap();
        } else {
            assert!(output.stdout.is_empty(), "{arguments:?}");
        }
    }
}

#[test]
fn numbers_alone_need_no_output() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let out = folder.path().join("out.ply");
    for arguments in
        [&["curvature"][..], &["curvature", "--estimator", "face"], &["flip", "--cost", "f1"]]
    {
        let strip = |mut report: Value| {
            for key in ["seconds", "output", "lost"] {
                report.as_object_mut().unwrap().remove(key);
            }
            report
        };
        let alone = json(&[arguments, &[&input]].concat());
        assert!(alone.get("output").is_none(), "{alone}");
        let written = json(&[arguments, &[&input, "-o", text(&out)]].concat());
        assert_eq!(strip(alone), strip(written));
    }
}

#[test]
fn old_spellings_still_work() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    let (old, new) = (path("old"), path("new"));
    let pairs: [(&[&str], &[&str]); 4] = [
        (
            &["convert", &input, &old, "--format", "stl"],
            &["convert", &input, "-o", &new, "--to", "stl"],
        ),
        (
            &["flip", &input, "-o", &old, "--format", "ply", "--cost", "f2", "--anneal", "7,3"],
            &[
                "flip",
                &input,
                "-o",
                &new,
                "--to",
                "ply",
                "--cost",
                "f2",
                "--seed",
                "7",
                "--anneal-steps",
                "3",
            ],
        ),
        (
            &["flip", &input, "-o", &old, "--format", "ply", "--cost", "f1", "--tie-seed", "5"],
            &[
                "flip",
                &input,
                "-o",
                &new,
                "--to",
                "ply",
                "--cost",
                "f1",
                "--random-ties",
                "--seed",
                "5",
            ],
        ),
        (
            &[
                "simplify", &input, "-o", &old, "--format", "ply", "--faces", "500", "--time",
                "1000",
            ],
            &[
                "simplify",
                &input,
                "-o",
                &new,
                "--to",
                "ply",
                "--faces",
                "500",
                "--time-limit",
                "1000",
            ],
        ),
    ];
    for (before, now) in pairs {
        json(before);
        json(now);
        assert!(std::fs::read(&old).unwrap() == std::fs::read(&new).unwrap(), "{before:?}");
    }
    for command in ["convert", "flip", "simplify", "lod", "patch", "curvature"] {
        let help = String::from_utf8(curvmesh(&[command, "--help"]).stdout).unwrap();
        for word in ["--format", "--tie-seed", "--anneal ", "--time "] {
            assert!(!help.contains(word), "{command} {word}");
        }
        assert!(help.contains("--to <FORMAT>") && help.contains("--relative"), "{command}");
    }
}

#[test]
fn reports_say_who_made_them_and_how() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let out = folder.path().join("out.ply");
    let arguments = ["simplify", &input, "-o", text(&out), "--max-error", "1%", "--lenient"];
    let report = json(&arguments);
    assert_eq!((&report["tool"], &report["command"]), (&"curvmesh".into(), &"simplify".into()));
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    let options = &report["options"];
    assert_eq!((&options["max-error"], &options["lenient"]), (&"1%".into(), &true.into()));
    // Default values are reported too: another version may have others.
    assert_eq!((&options["preset"], &options["seed"]), (&"default".into(), &1.into()));
    assert!(options.get("no-intersections").is_none(), "{options}");
    let report = json(&["flip", &input, "--cost", "f3"]);
    assert!(report["rejected"].is_object() && report["options"]["cost"] == "f3", "{report}");
}

#[test]
fn errors_are_objects_for_programs() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    let failure = |arguments: &[&str]| {
        let output = curvmesh(&[arguments, &["--json"]].concat());
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["error"]["exit_code"], output.status.code().unwrap(), "{report}");
        assert!(!report["error"]["message"].as_str().unwrap().is_empty());
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.starts_with("error: "), "{said}");
        report
    };
    std::fs::write(path("bad.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n").unwrap();
    let report = failure(&["info", &path("bad.off")]);
    let error = &report["error"];
    assert_eq!((&report["tool"], &report["command"]), (&"curvmesh".into(), &"info".into()));
    assert_eq!((&error["code"], &error["exit_code"]), (&"malformed".into(), &3.into()));
    assert_eq!(
        (&error["place"]["line"], &error["place"]["file"]),
        (&6.into(), &path("bad.off").into())
    );
    assert_eq!(failure(&["info", &path("none.off")])["error"]["code"], "unreadable");

    let mut soup = PolygonSoup::new();
    for i in 0..5 {
        let t = f64::from(i);
        soup.push_vertex([t, t * t, t * t * t]);
    }
    for face in [[0, 1, 2], [1, 0, 3], [0, 1, 4]] {
        soup.push_face(&face).unwrap();
    }
    write(soup, path("book.ply").as_ref());
    let report = failure(&["curvature", &path("book.ply"), "--strict"]);
    let error = &report["error"];
    assert_eq!((&error["code"], &error["exit_code"]), (&"non-manifold-edge".into(), &4.into()));
    assert_eq!(error["place"]["edge"], serde_json::json!([0, 1]));
    assert!(error["cure"].as_str().unwrap().contains("--cut-non-manifold"), "{error}");

    for usage in [
        &["info"][..],
        &["nothing"],
        &["flip", &path("book.ply"), "--cost", "f9"],
        &["convert", &path("book.ply"), "-o", &path("o.xyz")],
    ] {
        assert_eq!(failure(usage)["error"]["code"], "usage", "{usage:?}");
    }
    let report = failure(&["convert", &path("book.ply"), "-o", &path("no/folder/o.ply")]);
    assert_eq!(report["error"]["code"], "cannot-write");
}

/// Names in files may contain control sequences for the terminal.
#[test]
fn what_files_say_is_spelled_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("loud.gltf");
    let loud = r#"{"asset":{"version":"2.0"},"extensionsRequired":["\u001b[2J\u202eX"],
        "extensionsUsed":["\u001b[2J\u202eX"]}"#;
    std::fs::write(&path, loud).unwrap();
    let named = folder.path().join("a\u{1b}[2Jb\nc.off");
    std::fs::write(&named, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n").unwrap();
    let sound = folder.path().join("ok\u{1b}[2J\u{202e}.off");
    write(polyhedra::tetrahedron(), &sound);
    for path in [&path, &named, &sound] {
        for more in [&[][..], &["--json"]] {
            let output = curvmesh(&[&["info", text(path)], more].concat());
            let all = [output.stdout, output.stderr].concat();
            assert!(!all.contains(&0x1b), "{}", String::from_utf8_lossy(&all));
            assert!(!String::from_utf8(all).unwrap().contains('\u{202e}'));
        }
    }
    assert_eq!(json(&["info", text(&sound)])["input"], text(&sound));
}

#[test]
fn look_ahead_has_a_bound() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    for (depth, expected) in [("0", 2), ("7", 2), ("1000000", 2), ("2", 0)] {
        let run = ["flip", &input, "--cost", "f2", "--look-ahead", depth];
        assert_eq!(code(&run).0, expected, "{depth}");
    }
}

/// Values that the format cannot store are not reported as an error of the disk.
/// A cone whose rim jumps up and down.
#[test]
fn a_vertex_with_thousands_of_faces_is_said_to_take_long() {
    let folder = tempfile::tempdir().unwrap();
    let cone = |faces: u32| {
        let rim = |i: u32| {
            let (y, x) = (f64::from(i) * core::f64::consts::TAU / f64::from(faces)).sin_cos();
            DVec3::new(x, y, 0.3 * f64::from(i % 3))
        };
        let points: Vec<DVec3> = (0..faces).map(rim).chain([DVec3::ZERO]).collect();
        let triangles: Vec<[u32; 3]> = (0..faces).map(|i| [i, (i + 1) % faces, faces]).collect();
        let soup = PolygonSoup::from_triangles(&points, &triangles);
        let path = folder.path().join(format!("{faces}.ply"));
        write(soup.unwrap(), &path);
        path
    };
    let out = folder.path().join("out.ply");
    for (faces, is_said) in [(4000, false), (5000, true)] {
        let path = cone(faces);
        let (status, said) = code(&["distance", text(&path), text(&path), "--samples", "10"]);
        assert_eq!(status, 0, "{said}");
        let vertex = format!("vertex {faces} has {faces} faces");
        assert_eq!(said.contains(&vertex) && said.contains("--preset fast"), is_said, "{said}");
        let fast =
            ["simplify", text(&path), "-o", text(&out), "--preset", "fast", "--faces", "500"];
        assert!(!code(&fast).1.contains("has"), "{said}");
    }
}

#[test]
fn coordinates_beyond_the_format_are_refused_in_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    let mut soup = Sphere { radius: 1.0 }.icosphere(2).unwrap();
    for position in soup.positions_mut() {
        *position *= 1e60;
    }
    write(soup, path("huge.ply").as_ref());
    let (huge, glb) = (path("huge.ply"), path("out.glb"));
    for arguments in [
        &["convert", &huge, "-o", &glb][..],
        &["lod", &huge, "-o", &glb, "--faces", "100", "--preset", "fast"],
        &["subdivide", &huge, "-o", &glb],
    ] {
        let (status, message) = code(arguments);
        assert_eq!(status, 4, "{message}");
        assert!(message.contains("hold") && message.contains("vertex"), "{message}");
    }
}

#[test]
fn helps_say_what_each_preset_and_cost_is() {
    let help = |command: &str| String::from_utf8(curvmesh(&[command, "--help"]).stdout).unwrap();
    for command in ["simplify", "lod"] {
        let help = help(command);
        for preset in simplify::Preset::ALL {
            assert!(
                help.contains(&format!("{preset}:")) || help.contains(&format!("{preset},")),
                "{preset}"
            );
        }
    }
    let help = help("flip");
    assert!(
        dtri_flip::CostName::ALL.iter().all(|cost| help.contains(&format!("- {cost}: "))),
        "{help}"
    );
}

/// Repairs that leave nothing are an error, unless empty meshes are allowed.
#[test]
fn a_mesh_that_was_repaired_away_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    let (input, glb) = (torus(folder.path()), path("nothing.glb"));
    for command in ["convert", "repair"] {
        let arguments = [command, &input, "-o", &glb, "--lenient", "--weld", "1000"];
        let output = curvmesh(&arguments);
        assert_eq!(output.status.code(), Some(4), "{command}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("leave nothing") && said.contains("--allow-empty"), "{said}");
        assert!(!Path::new(&glb).exists());
        let allowed = curvmesh(&[arguments.as_slice(), &["--allow-empty"]].concat());
        assert!(allowed.status.success(), "{command}");
        std::fs::remove_file(&glb).unwrap();
    }
}
