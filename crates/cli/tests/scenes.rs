//! Scenes stay scenes, and what cannot be kept is said.
#![allow(clippy::unwrap_used, clippy::indexing_slicing)]

use std::path::Path;

use crate::built_scene::{Builder, ball, parts, rich, without};
use crate::common::{code, curvmesh, json};
use mesh_io::Format;
use serde_json::{Value, json as value};

/// A car with two wheels that share a mesh, a camera, and extras.
fn car() -> Vec<u8> {
    let mut scene = Builder::new();
    let (positions, triangles) = ball(20, 10);
    let primitive = value!({
        "attributes": { "POSITION": scene.positions(&positions) }, "indices": scene.indices(&triangles),
    });
    let wheel =
        value!({ "name": "wheel", "primitives": [primitive], "extras": { "mat": "rubber" } });
    let wheel = scene.push("meshes", wheel);
    let place =
        |name: &str, x: f64| value!({ "name": name, "mesh": wheel, "translation": [x, 0, 0] });
    let mut front = place("front", 3.0);
    front["extras"] = value!({ "part_no": "A-113" });
    let children = [front, place("back", -3.0)].map(|node| scene.push("nodes", node));
    scene.node(value!({ "name": "car", "children": children }));
    let camera = value!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } });
    let camera = scene.push("cameras", camera);
    scene.node(value!({ "name": "cam", "camera": camera }));
    scene.glb()
}

fn file(folder: &Path, name: &str, bytes: &[u8]) -> String {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().to_owned()
}

fn document(path: &str) -> Value {
    parts(&std::fs::read(path).unwrap()).0
}

const GEOMETRY: [&str; 4] = ["accessors", "bufferViews", "buffers", "meshes"];

#[test]
fn a_car_stays_a_car() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "car.glb", &car());
    let output = folder.path().join("out.glb");
    let output = output.to_str().unwrap();
    let report = json(&["convert", &input, "-o", output]);
    assert_eq!(report["lost"], value!([]));
    assert_eq!(document(&input), document(output));
    let report = json(&["simplify", &input, "-o", output, "--ratio", "0.5"]);
    assert_eq!(report["lost"], value!([]));
    assert_eq!(without(&document(&input), &GEOMETRY), without(&document(output), &GEOMETRY));
    let [old, new] = [&input, output].map(|path| document(path)["meshes"].clone());
    assert_eq!(old.as_array().unwrap().len(), new.as_array().unwrap().len());
    assert_eq!(without(&old[0], &["primitives"]), without(&new[0], &["primitives"]));
    let mesh = &report["meshes"][0];
    assert!(mesh["name"] == "wheel" && mesh["times"] == 2 && mesh["faces_in"] == 360, "{report}");
    assert!(mesh["faces_out"] == 180 && report["faces_out"] == 360, "{report}");
    assert!(mesh["max"].as_f64().unwrap() > 0.0 && mesh["rms"].as_f64().unwrap() > 0.0);
    // The merged mesh has the faces of both.
    assert_eq!(mesh_io::read(output).unwrap().soup.face_count(), 360);
    // glTF in, GLB out, and the other way round.
    let text = folder.path().join("out.gltf");
    json(&["convert", output, "-o", text.to_str().unwrap()]);
    let again = folder.path().join("again.glb");
    json(&["convert", text.to_str().unwrap(), "-o", again.to_str().unwrap()]);
    assert_eq!(document(output), document(again.to_str().unwrap()));
}

#[test]
fn options_that_need_one_mesh_make_one_and_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "car.glb", &car());
    let output = folder.path().join("out.glb");
    let output = output.to_str().unwrap();
    let start = ["simplify", &input, "-o", output, "--ratio", "0.5"];
    for more in [&["--max-edge", "10"][..], &["--no-attributes"], &["--weld", "0.0001"]] {
        let (status, said) = code(&[&start[..], more].concat());
        assert_eq!(status, 0, "{said}");
        let option = more[0];
        assert!(said.contains(&format!("{option} works on one mesh")), "{said}");
        assert!(said.contains("lost cameras (1)"), "{said}");
        assert_eq!(document(output)["nodes"].as_array().unwrap().len(), 1);
    }
    let (_, said) = code(&[&start[..], &["--one-mesh"]].concat());
    assert!(!said.contains("works on one mesh") && said.contains("lost cameras (1)"), "{said}");
    let report = json(&["convert", &input, "-o", output, "--lenient"]);
    assert!(report["lost"].as_array().unwrap().len() > 2, "{report}");
    // A budget for each mesh has no meaning without meshes.
    let ply = folder.path().join("out.ply");
    let (status, said) = code(&["simplify", &input, "-o", ply.to_str().unwrap(), "--per", "mesh"]);
    assert!(status == 2 && said.contains("--per"), "{said}");
    let (status, said) = code(&["simplify", &input, "-o", ply.to_str().unwrap(), "--poses", "2"]);
    assert!(status == 2 && said.contains("--poses"), "{said}");
}

#[test]
fn errors_are_proved_in_units_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "rich.glb", &rich().glb());
    let output = folder.path().join("out.glb");
    let output = output.to_str().unwrap();
    let limits = ["--max-error", "0.05", "--verify"];
    let report = json(&[&["simplify", &input, "-o", output][..], &limits].concat());
    let meshes = report["meshes"].as_array().unwrap();
    assert_eq!(meshes.len(), 3);
    for mesh in meshes {
        let upper = mesh["error"]["upper"].as_f64().unwrap();
        assert!(upper <= 0.05 && mesh["max"].as_f64().unwrap() <= upper, "{mesh}");
        assert!(mesh["faces_out"].as_u64() < mesh["faces_in"].as_u64(), "{mesh}");
    }
    assert!((meshes[0]["scale"].as_f64().unwrap() - 3.0).abs() < 1e-12);
}

#[test]
fn errors_of_a_mesh_that_deforms_are_those_of_its_poses() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "rich.glb", &rich().glb());
    let output = folder.path().join("out.glb");
    let output = output.to_str().unwrap();
    let start = ["simplify", &input, "-o", output, "--ratio", "0.3"];
    let report = json(&start);
    let [wheel, arm] = [0, 1].map(|mesh| &report["meshes"][mesh]);
    assert!(wheel.get("poses").is_none(), "{wheel}");
    // The morph target alone, and the turned joint.
    assert!(arm["poses"]["count"].as_u64().unwrap() >= 2, "{arm}");
    assert!(arm["poses"]["max"].as_f64() >= arm["poses"]["rms"].as_f64(), "{arm}");
    let one = json(&[&start[..], &["--poses", "1"]].concat());
    assert_eq!(one["meshes"][1]["poses"]["count"], 1);
    let none = json(&[&start[..], &["--poses", "0"]].concat());
    assert!(none["meshes"][1].get("poses").is_none());
    let said = String::from_utf8(curvmesh(&start).stdout).unwrap();
    assert!(said.contains("other poses"), "{said}");
    // An error limit holds in the poses too.
    let limits = ["simplify", &input, "-o", output, "--max-error", "0.05"];
    let arm = json(&limits)["meshes"][1].clone();
    assert!(arm["poses"]["max"].as_f64().unwrap() <= 0.05, "{arm}");
    assert!(arm["faces_out"].as_u64() < arm["faces_in"].as_u64(), "{arm}");
}

#[test]
fn repairs_keep_a_scene_unless_they_need_one_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "rich.glb", &rich().glb());
    let output = folder.path().join("out.glb");
    let output = output.to_str().unwrap();
    let report = json(&["repair", &input, "-o", output]);
    assert_eq!(report["lost"], value!([]));
    assert_eq!(document(&input), document(output));
    assert!(report["faces_out"].as_u64() > Some(2000), "{report}");
    assert!(report["written"]["watertight"] == false, "{report}");
    for more in [&["--fill-holes", "all"][..], &["--for", "printing"]] {
        let (status, said) = code(&[&["repair", &input, "-o", output][..], more].concat());
        assert_eq!(status, 0, "{said}");
        assert!(said.contains(&format!("{} works on one mesh", more[0])), "{said}");
        assert_eq!(document(output)["nodes"].as_array().unwrap().len(), 1);
    }
}

#[test]
fn nodes_have_meshes_of_their_own_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "rich.glb", &rich().glb());
    let output = folder.path().join("out.glb");
    let output = output.to_str().unwrap();
    let start = ["simplify", &input, "-o", output, "--max-error", "0.02", "--per"];
    let [mesh, node] = ["mesh", "node"].map(|per| {
        let report = json(&[&start[..], &[per]].concat());
        (
            report["meshes"].as_array().unwrap().len(),
            document(output)["meshes"].as_array().unwrap().len(),
        )
    });
    assert_eq!((mesh, node), ((3, 3), (4, 4)));
}

#[test]
fn a_folder_of_scenes_stays_one() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = folder.path().join("scenes");
    std::fs::create_dir(&scenes).unwrap();
    file(&scenes, "car.glb", &car());
    file(&scenes, "rich.glb", &rich().glb());
    let out = folder.path().join("small");
    let (status, said) = code(&[
        "simplify",
        scenes.to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
        "--ratio",
        "0.3",
    ]);
    assert_eq!(status, 0, "{said}");
    for name in ["car.glb", "rich.glb"] {
        let [old, new] = [&scenes, &out].map(|f| document(f.join(name).to_str().unwrap()));
        let changing = [&GEOMETRY[..], &["animations", "skins"]].concat();
        assert_eq!(without(&old, &changing), without(&new, &changing));
    }
}

#[test]
fn positions_that_are_not_finite_are_not_written() {
    let mut scene = Builder::new();
    let positions = scene.floats(&[[0.0, 0.0, 0.0], [f32::INFINITY, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let primitive = value!({ "attributes": { "POSITION": positions } });
    let mesh = scene.push("meshes", value!({ "primitives": [primitive] }));
    scene.node(value!({ "mesh": mesh }));
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "infinite.glb", &scene.glb());
    let output = folder.path().join("out.glb");
    for command in ["convert", "simplify"] {
        let (status, said) = code(&[command, &input, "-o", output.to_str().unwrap()]);
        assert!(matches!(status, 3 | 4) && said.contains("inf"), "{status} {said}");
        assert!(!output.exists());
    }
}

#[test]
fn a_scene_of_lines_is_no_surface() {
    let mut scene = Builder::new();
    let positions = scene.positions(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let primitive = value!({ "attributes": { "POSITION": positions }, "mode": 3 });
    let mesh = scene.push("meshes", value!({ "primitives": [primitive] }));
    scene.node(value!({ "mesh": mesh }));
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "lines.glb", &scene.glb());
    let output = folder.path().join("out.glb");
    let output = output.to_str().unwrap();
    for command in ["simplify", "lod"] {
        let (status, said) = code(&[command, &input, "-o", output]);
        assert!(status == 4 && said.contains("points or lines and no faces"), "{status} {said}");
        assert_eq!(code(&[command, &input, "-o", output, "--allow-empty"]).0, 0);
    }
    json(&["convert", &input, "-o", output]);
    assert_eq!(document(&input), document(output));
}

/// The second set of texture coordinates, for a light map.
#[test]
fn a_light_map_stays() {
    let mut scene = Builder::new();
    let (mut positions, mut uvs, mut triangles) = (vec![], vec![], vec![]);
    for i in 0..=12_u32 {
        for j in 0..=12_u32 {
            let [x, y] = [i, j].map(|k| k as f32 / 12.0);
            positions.push([x, y, 0.0]);
            uvs.push([0.5 * x, 0.25 + 0.5 * y]);
            if i < 12 && j < 12 {
                let at = |i: u32, j: u32| 13 * i + j;
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    let attributes = value!({
        "POSITION": scene.positions(&positions), "TEXCOORD_0": scene.floats(&uvs), "TEXCOORD_1": scene.floats(&uvs),
    });
    let primitive = value!({ "attributes": attributes, "indices": scene.indices(&triangles) });
    let mesh = scene.push("meshes", value!({ "primitives": [primitive] }));
    scene.node(value!({ "mesh": mesh, "name": "floor" }));
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "floor.glb", &scene.glb());
    let output = folder.path().join("out.glb");
    let path = output.to_str().unwrap();
    json(&["simplify", &input, "-o", path, "--ratio", "0.2"]);
    let model = mesh_io::read(&output).unwrap();
    assert_eq!(model.more_corner_uvs.len(), 1);
    for (uv, &vertex) in model.more_corner_uvs[0].iter().zip(model.soup.corners()) {
        let at = model.soup.positions()[vertex as usize];
        // The model has its origin at the lower left.
        let off = (f64::from(uv[0]) - 0.5 * at.x)
            .abs()
            .max((1.0 - f64::from(uv[1]) - 0.25 - 0.5 * at.y).abs());
        assert!(off < 1e-6, "{uv:?} {at}");
    }
    assert_eq!(document(path)["nodes"][0]["name"], "floor");
    assert_eq!(Format::detect(&std::fs::read(&output).unwrap(), None, None), Some(Format::Glb));
}

#[test]
fn a_scene_is_shown_as_a_tree() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "car.glb", &car());
    let report = json(&["info", &input]);
    assert_eq!(report["scene"]["parts"], value!({ "meshes": 1, "cameras": 1, "scenes": 1 }));
    let nodes = report["scene"]["nodes"].as_array().unwrap();
    let found =
        nodes.iter().map(|node| (node["name"].as_str().unwrap(), node["depth"].as_u64().unwrap()));
    assert_eq!(found.collect::<Vec<_>>(), [("car", 0), ("front", 1), ("back", 1), ("cam", 0)]);
    assert_eq!(nodes[1]["mesh"], value!({ "mesh": 0, "name": "wheel", "faces": 360 }));
    let text = String::from_utf8(curvmesh(&["info", &input]).stdout).unwrap();
    assert!(text.contains("\n      front: mesh wheel, 360 faces (extras)\n"), "{text}");
}

#[test]
fn levels_of_a_scene_are_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "car.glb", &car());
    let out = folder.path().join("levels");
    let start = ["lod", &input, "--levels", "0.5,0.2", "-o"];
    let report = json(&[&start[..], &[out.to_str().unwrap()]].concat());
    assert_eq!(report["lost"], value!([]));
    let levels = report["levels"].as_array().unwrap();
    assert_eq!(levels.len(), 2);
    for (level, faces) in levels.iter().zip([360, 144]) {
        let path = level["output"].as_str().unwrap();
        assert!(level["faces"] == faces && level["meshes"][0]["times"] == 2, "{level}");
        let number = if faces == 360 { 1 } else { 2 };
        assert_eq!(Path::new(path), out.join(format!("car-{number}.glb")));
        assert_eq!(without(&document(&input), &GEOMETRY), without(&document(path), &GEOMETRY));
        assert_eq!(mesh_io::read(path).unwrap().soup.face_count(), faces);
    }
    // One file for all levels: the nodes have alternatives, which share their meshes.
    let one = folder.path().join("all.glb");
    let one = one.to_str().unwrap();
    json(&[&start[..], &[one]].concat());
    let found = document(one);
    assert_eq!(found["meshes"].as_array().unwrap().len(), 3);
    assert_eq!(found["nodes"].as_array().unwrap().len(), 4 + 2 * 2);
    assert_eq!(found["nodes"][0]["extensions"]["MSFT_lod"]["ids"].as_array().unwrap().len(), 2);
    assert_eq!(found["nodes"][0]["extras"]["part_no"], "A-113");
    // Merged as asked, or because an option needs it.
    let (_, said) = code(&[&start[..], &[one, "--one-mesh"]].concat());
    assert!(said.contains("lost cameras (1)") && !said.contains("works on one mesh"), "{said}");
    let record = folder.path().join("car.lod");
    let (status, said) = code(&[&start[..], &[one, "--record", record.to_str().unwrap()]].concat());
    assert!(status == 0 && said.contains("--record works on one mesh"), "{said}");
    let ply = folder.path().join("plain");
    let plain = ["--to", "ply", "--per", "mesh"];
    let (status, said) = code(&[&start[..], &[ply.to_str().unwrap()], &plain].concat());
    assert!(status == 2 && said.contains("--per"), "{said}");
}

/// The tree shows what a mesh has no place for, so nothing is lost.
#[test]
fn a_scene_that_is_shown_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "rich.glb", &rich().glb());
    let output = curvmesh(&["info", &input]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && !said.contains("lost"), "{said}");
    let report = json(&["info", &input]);
    assert!(report["lost"].as_array().is_none_or(Vec::is_empty), "{report}");
    assert_eq!(report["scene"]["parts"]["skins"], 1);
}

/// Every command that writes glTF can round its data: the same faces in fewer bytes, fewer still if compressed, and the
/// rounding is reported and counts for the error limit.
#[test]
fn outputs_are_quantized() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "rich.glb", &rich().glb());
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let size = |path: &str| std::fs::metadata(path).unwrap().len();
    let cases: [&[&str]; 5] = [
        &["convert"],
        &["repair"],
        &["simplify", "--ratio", "0.5"],
        &["lod", "--levels", "0.5,0.25"],
        &["simplify", "--ratio", "0.5", "--one-mesh"],
    ];
    for (case, command) in cases.into_iter().enumerate() {
        let [plain, rounded, small] =
            ["plain", "rounded", "small"].map(|name| path(&format!("{name}{case}.glb")));
        json(&[command, &[&input, "-o", &plain]].concat());
        let report = json(&[command, &[&input, "-o", &rounded, "--quantize"]].concat());
        assert!(report["rounding"].as_f64().unwrap() > 0.0, "{report}");
        assert!(report.get("stayed").is_none(), "{report}");
        let both = [&input, "-o", &small, "--quantize=12", "--compress", "meshopt"];
        json(&[command, &both].concat());
        let sizes = [&plain, &rounded, &small].map(|path| size(path));
        assert!(sizes.is_sorted_by(|a, b| a > b), "{command:?}: {sizes:?}");
        let required = document(&rounded)["extensionsRequired"].clone();
        assert!(required.as_array().unwrap().contains(&value!("KHR_mesh_quantization")));
        let [plain, rounded, small] = [&plain, &rounded, &small].map(|path| json(&["info", path]));
        for name in ["faces", "euler_characteristic"] {
            assert_eq!(plain[name], rounded[name], "{command:?} {name}");
            assert_eq!(plain[name], small[name], "{command:?} {name}");
        }
    }
    let limited = |more: &[&str]| {
        let out = path("limited.glb");
        json(&[&["simplify", &input, "-o", &out, "--max-error", "0.01"], more].concat())
    };
    let [plain, rounded] = [limited(&[]), limited(&["--quantize=12"])];
    let faces = |report: &Value| report["faces_out"].as_u64().unwrap();
    assert!(faces(&rounded) >= faces(&plain));
    for mesh in rounded["meshes"].as_array().unwrap() {
        assert!(mesh["rounding"].as_f64().unwrap() > 0.0, "{mesh}");
        assert!(mesh["max"].as_f64().unwrap() >= mesh["rounding"].as_f64().unwrap());
    }
    assert!(plain["meshes"][0].get("rounding").is_none());
    let out = path("fine.glb");
    let (refused, message) =
        code(&["simplify", &input, "-o", &out, "--max-error", "0.0001", "--quantize=8"]);
    assert!(refused == 4 && message.contains("rounding"), "{refused} {message}");
    let ply = path("out.ply");
    let (refused, message) = code(&["convert", &input, "-o", &ply, "--quantize"]);
    assert_eq!(refused, 2);
    assert!(message.contains("--quantize") && message.contains("glTF"), "{message}");
}

/// Every command that writes glTF can compress it: the same faces in fewer bytes, whether the scene stays whole or not.
#[test]
fn outputs_are_compressed() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "rich.glb", &rich().glb());
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let size = |path: &str| std::fs::metadata(path).unwrap().len();
    let cases: [&[&str]; 4] = [
        &["convert"],
        &["simplify", "--ratio", "0.5"],
        &["lod", "--levels", "0.5,0.25"],
        &["simplify", "--ratio", "0.5", "--one-mesh"],
    ];
    for (case, command) in cases.into_iter().enumerate() {
        let [plain, small] = ["plain", "small"].map(|name| path(&format!("{name}{case}.glb")));
        json(&[command, &[&input, "-o", &plain]].concat());
        json(&[command, &[&input, "-o", &small, "--compress", "meshopt"]].concat());
        assert!(size(&small) < size(&plain), "{command:?}: {} {}", size(&small), size(&plain));
        let required = document(&small)["extensionsRequired"].clone();
        assert!(required.as_array().unwrap().contains(&value!("EXT_meshopt_compression")));
        let [plain, small] = [&plain, &small].map(|path| json(&["info", path]));
        for name in ["vertices", "faces", "edges", "euler_characteristic"] {
            assert_eq!(plain[name], small[name], "{command:?} {name}");
        }
    }
    let ply = path("out.ply");
    let (refused, message) = code(&["convert", &input, "-o", &ply, "--compress", "meshopt"]);
    assert_eq!(refused, 2);
    assert!(message.contains("--compress") && message.contains("glTF"), "{message}");
}
