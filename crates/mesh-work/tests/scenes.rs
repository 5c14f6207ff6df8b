//! Scenes: what is drawn, and all data of vertices, before and after.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing)]

use std::collections::{BTreeSet, HashMap};
use std::ops::ControlFlow;

use crate::built_scene::{Builder, ball, parts, rich, tube, values, without};
use glam::{DQuat, DVec3};
use mesh_core::build::{Repair, Weld};
use mesh_io::{Format, Quantization, ReadOptions, Scene, read_from};
use mesh_metric::{CompareOptions, Comparison, Surface, compare};
use mesh_work::{
    AttributeRules, Attributes, Choices, LevelRecord, LevelSteps, Loaded, SceneBudget, SceneError,
    SceneLevel, SceneRules, SceneSteps, SceneTarget, SimplifiedScene, repaired_scene, scene_levels,
    simplify_scene,
};
use serde_json::{Value, json};
use simplify::{Target, simplify};

fn scene(file: &[u8]) -> Scene {
    Scene::read_from(&mut &file[..], &ReadOptions::default()).unwrap()
}

fn simplified(file: &[u8], rules: &SceneRules) -> (SimplifiedScene, Vec<u8>) {
    let made = simplify_scene(&scene(file), rules, &mut |_| ControlFlow::Continue(())).unwrap();
    let mut bytes = Vec::new();
    made.scene.write_to(&mut bytes, Format::Glb).unwrap();
    // A reader that is not ours finds no fault.
    gltf::Gltf::from_slice(&bytes).unwrap();
    (made, bytes)
}

fn to_ratio(ratio: f64) -> SceneRules {
    let target = SceneTarget { ratio: Some(ratio), ..SceneTarget::default() };
    SceneRules { target, ..SceneRules::default() }
}

/// The values of an attribute of a primitive.
struct Found {
    json: Value,
    buffers: Vec<Vec<u8>>,
}

impl Found {
    fn new(file: &[u8]) -> Self {
        let (json, binary) = parts(file);
        Self { json, buffers: vec![binary] }
    }

    fn primitive(&self, mesh: usize, primitive: usize) -> &Value {
        &self.json["meshes"][mesh]["primitives"][primitive]
    }

    fn values(&self, accessor: &Value) -> Vec<Vec<f64>> {
        values(&self.json, &self.buffers, accessor.as_u64().unwrap() as usize)
    }

    fn attribute(&self, primitive: &Value, name: &str) -> Vec<Vec<f64>> {
        self.values(&primitive["attributes"][name])
    }

    fn triangles(&self, primitive: &Value) -> Vec<[usize; 3]> {
        let corners: Vec<usize> =
            self.values(&primitive["indices"]).iter().map(|v| v[0] as usize).collect();
        corners.as_chunks::<3>().0.to_vec()
    }
}

#[test]
fn a_scene_keeps_everything_but_faces() {
    let file = rich().glb();
    let (made, out) = simplified(&file, &to_ratio(0.4));
    let (old, new) = (Found::new(&file), Found::new(&out));
    let changing = ["accessors", "bufferViews", "buffers", "meshes", "animations", "skins"];
    assert_eq!(without(&old.json, &changing), without(&new.json, &changing));
    for (pointer, names) in [
        ("/animations/0/samplers/0", &["input", "output"][..]),
        ("/skins/0", &["inverseBindMatrices"]),
    ] {
        let [a, b] = [&old, &new].map(|found| found.json.pointer(pointer).unwrap());
        assert_eq!(without(a, names), without(b, names));
        for name in names {
            assert_eq!(old.values(&a[name]), new.values(&b[name]), "{name}");
        }
    }
    for mesh in 0..3 {
        let [a, b] = [&old, &new].map(|found| &found.json["meshes"][mesh]);
        assert_eq!(without(a, &["primitives"]), without(b, &["primitives"]));
        let [a, b] = [a, b].map(|mesh| mesh["primitives"].as_array().unwrap());
        for (a, b) in a.iter().zip(b) {
            let changing = ["attributes", "indices", "targets"];
            assert_eq!(without(a, &changing), without(b, &changing));
            let names = |p: &Value| {
                p["attributes"].as_object().unwrap().keys().cloned().collect::<Vec<_>>()
            };
            assert_eq!(names(a), names(b));
        }
    }
    // The lines of the floor are as they were.
    let lines = |found: &Found| found.attribute(found.primitive(2, 2), "POSITION");
    assert_eq!(lines(&old), lines(&new));
    let drawn: usize = made.meshes.iter().map(|mesh| mesh.times * mesh.faces[1]).sum();
    let before: usize = made.meshes.iter().map(|mesh| mesh.times * mesh.faces[0]).sum();
    assert_eq!(before as u64, scene(&file).counts()[1]);
    assert_eq!(drawn as u64, made.scene.counts()[1]);
    assert!(
        drawn as f64 <= (0.4 * before as f64).ceil() && drawn as f64 > 0.38 * before as f64,
        "{drawn} of {before}"
    );
    let wheel = &made.meshes[0];
    assert!(
        wheel.times == 2
            && (wheel.scale - 3.0).abs() < 1e-12
            && wheel.name.as_deref() == Some("wheel")
    );
    assert_eq!(made.lost, []);
}

/// The arm has data that are functions of the place: they still are.
#[test]
fn all_data_of_vertices_are_carried() {
    let file = rich().glb();
    for ratio in [0.5, 0.2] {
        let (_, out) = simplified(&file, &to_ratio(ratio));
        let found = Found::new(&out);
        let arm = found.primitive(1, 0);
        let of = |name: &str| found.attribute(arm, name);
        let positions = of("POSITION");
        let (normals, tangents) = (of("NORMAL"), of("TANGENT"));
        let (uvs, more_uvs, colors) = (of("TEXCOORD_0"), of("TEXCOORD_1"), of("COLOR_0"));
        let (joints, weights) = (of("JOINTS_0"), of("WEIGHTS_0"));
        let (heat, part) = (of("_HEAT"), of("_PART"));
        let moved = found.values(&arm["targets"][0]["POSITION"]);
        let mut parts = BTreeSet::new();
        for (v, at) in positions.iter().enumerate() {
            let [x, y, z] = [at[0], at[1], at[2]];
            // A vertex of the result can be a little beyond the rims.
            let close = |found: f64, expected: f64, tolerance: f64| {
                assert!((found - expected).abs() < tolerance, "{found} {expected} at {at:?}");
            };
            close(more_uvs[v][0], z / 8.0, 0.02);
            close(more_uvs[v][1], 0.5, 1e-6);
            close(heat[v][0], 20.0 + 5.0 * z, 0.4);
            close(colors[v][0], (z / 4.0).clamp(0.0, 1.0) * 255.0, 8.0);
            close(colors[v][1], 128.0, 0.5);
            let angle = (y.atan2(x) / std::f64::consts::TAU).rem_euclid(1.0);
            let off = (uvs[v][0] - angle).abs();
            assert!(off.min((off - 1.0).abs()) < 0.03, "{:?} at {at:?}", uvs[v]);
            // A label is one of the labels, and the right one away from their border.
            parts.insert(part[v][0] as u8);
            if (z - 2.0).abs() > 0.4 {
                assert_eq!(part[v][0], if z < 2.0 { 7.0 } else { 9.0 }, "{at:?}");
            }
            assert_eq!(weights[v].iter().sum::<f64>(), 255.0);
            let far: f64 = (0..4).filter(|&k| joints[v][k] == 1.0).map(|k| weights[v][k]).sum();
            close(far, (z / 4.0).clamp(0.0, 1.0) * 255.0, 8.0);
            close(moved[v][2], (z - 3.0).max(0.0), 0.1);
            let dot = |a: &[f64], b: &[f64]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
            close(dot(&normals[v], &normals[v]), 1.0, 1e-5);
            close(dot(&tangents[v], &tangents[v]), 1.0, 1e-5);
            close(dot(&normals[v], &tangents[v]), 0.0, 1e-5);
            assert_eq!(tangents[v][3], 1.0);
            let radius = x.hypot(y);
            close(dot(&normals[v], at) / radius, 1.0, 0.1);
        }
        assert_eq!(parts.into_iter().collect::<Vec<_>>(), [7, 9]);
    }
}

/// The halves of the floor meet in the same edges, and the border between them has no gap.
#[test]
fn borders_between_primitives_stay_closed() {
    let (_, out) = simplified(&rich().glb(), &to_ratio(0.3));
    let found = Found::new(&out);
    let mut edges: HashMap<[[u64; 3]; 2], usize> = HashMap::new();
    for half in 0..2 {
        let primitive = found.primitive(2, half);
        let positions = found.attribute(primitive, "POSITION");
        let key = |v: usize| [0, 1, 2].map(|k| positions[v][k].to_bits());
        for [a, b, c] in found.triangles(primitive) {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                let mut ends = [key(a), key(b)];
                ends.sort_unstable();
                *edges.entry(ends).or_insert(0) += 1;
            }
        }
    }
    // An edge of one face is on the rim of the floor.
    for (ends, faces) in edges {
        let [a, b] = ends.map(|end| end.map(f64::from_bits));
        let on = |k: usize, at: f64| (a[k] - at).abs() < 0.3 && (b[k] - at).abs() < 0.3;
        let is_rim = on(0, 0.0) || on(0, 10.0) || on(1, 0.0) || on(1, 10.0);
        assert!(faces == 2 || (faces == 1 && is_rim), "{a:?} {b:?} {faces}");
    }
}

/// A scene of one mesh and one node gives the bits that the mesh gives.
#[test]
fn a_single_mesh_is_the_mesh() {
    let mut builder = Builder::new();
    let tube = tube(40, 30);
    let attributes = json!({
        "POSITION": builder.positions(&tube.positions), "NORMAL": builder.floats(&tube.normals),
        "TEXCOORD_0": builder.floats(&tube.uvs),
    });
    let primitive =
        json!({ "attributes": attributes, "indices": builder.indices(&tube.triangles) });
    builder.push("meshes", json!({ "primitives": [primitive] }));
    builder.node(json!({ "mesh": 0, "name": "tube" }));
    let file = builder.glb();
    let model = read_from(&mut &file[..], &ReadOptions::default()).unwrap();
    let mut repair = Repair::strict();
    repair.weld = Weld::Exact;
    let loaded = Loaded::build_with_needed_repairs(model, &repair).unwrap();
    let attributes = Attributes::find(loaded.source(), &AttributeRules::default()).unwrap();
    for ratio in [0.5, 0.13, 0.02] {
        let target = Target { ratio: Some(ratio), ..Target::default() };
        let mut options = Choices::default().options(&loaded.mesh, target);
        let merged = attributes.merge_charts(&loaded.mesh, &options.target);
        let attributes = merged.as_ref().unwrap_or(&attributes);
        attributes.constrain(&loaded.mesh, &mut options);
        let result = simplify(&loaded.mesh, &options).unwrap();
        let expected = attributes.carry(loaded.source(), &result.mesh, &result.vertex_map).unwrap();
        let mut bytes = Vec::new();
        mesh_io::write_to(&mut bytes, &expected, Format::Glb, &Default::default()).unwrap();
        let (_, out) = simplified(&file, &to_ratio(ratio));
        let [expected, found] = [&bytes, &out].map(|file| Found::new(file));
        let [a, b] = [&expected, &found].map(|found| found.primitive(0, 0));
        assert_eq!(expected.attribute(a, "POSITION"), found.attribute(b, "POSITION"));
        assert_eq!(expected.triangles(a), found.triangles(b));
        assert_eq!(expected.attribute(a, "NORMAL"), found.attribute(b, "NORMAL"));
    }
}

/// Balls at three scales, one of them drawn by instances.
fn balls() -> Vec<u8> {
    let mut builder = Builder::new();
    for scale in [1.0, 10.0, 100.0] {
        let (positions, triangles) = ball(48, 24);
        let primitive = json!({
            "attributes": { "POSITION": builder.positions(&positions) }, "indices": builder.indices(&triangles),
        });
        let mesh = builder.push("meshes", json!({ "primitives": [primitive] }));
        builder.node(json!({ "mesh": mesh, "name": format!("ball {scale}"), "scale": [scale, scale, scale] }));
    }
    let places = builder.floats(&[[5.0, 0.0, 0.0], [-5.0, 0.0, 0.0], [0.0, 5.0, 0.0]]);
    builder.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    builder.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    builder.glb()
}

#[test]
fn faces_go_where_the_error_of_the_scene_is_largest() {
    let file = balls();
    let (made, _) = simplified(&file, &to_ratio(0.2));
    let faces: Vec<usize> = made.meshes.iter().map(|mesh| mesh.faces[1]).collect();
    assert_eq!(made.meshes.iter().map(|mesh| mesh.times).collect::<Vec<_>>(), [3, 1, 1]);
    assert!(faces[0] < faces[1] && faces[1] < faces[2], "{faces:?}");
    // The squared distance over all balls is smaller than with an equal share for each mesh.
    let squared = |made: &SimplifiedScene| -> f64 {
        made.meshes.iter().map(|m| m.times as f64 * (m.scale * m.rms).powi(2)).sum()
    };
    let rules = SceneRules { budget: SceneBudget::Mesh, ..to_ratio(0.2) };
    let (each, _) = simplified(&file, &rules);
    for mesh in &each.meshes {
        assert_eq!(mesh.faces[1], mesh.faces[0].div_ceil(5), "{mesh:?}");
    }
    assert!(squared(&made) < 0.1 * squared(&each), "{} {}", squared(&made), squared(&each));
    let drawn: usize = made.meshes.iter().map(|mesh| mesh.times * mesh.faces[1]).sum();
    assert!(5 * drawn <= made.meshes.iter().map(|m| m.times * m.faces[0]).sum(), "{drawn}");
}

#[test]
fn an_error_limit_is_in_units_of_the_scene() {
    let target = SceneTarget { max_error: Some("0.05".parse().unwrap()), ..SceneTarget::default() };
    let choices = Choices { verify: true, ..Choices::default() };
    let rules = SceneRules { target, choices, ..SceneRules::default() };
    let (made, _) = simplified(&balls(), &rules);
    let faces: Vec<usize> = made.meshes.iter().map(|mesh| mesh.faces[1]).collect();
    assert!(faces[0] < faces[1] && faces[1] < faces[2], "{faces:?}");
    for mesh in &made.meshes {
        let upper = mesh.bound.unwrap().upper.unwrap();
        assert!(upper <= 0.05 && mesh.max <= upper, "{upper} {}", mesh.max);
    }
    // Relative lengths are shares of the diagonal of the scene, which the largest ball spans.
    let share = SceneTarget { max_error: Some("0.1%".parse().unwrap()), ..SceneTarget::default() };
    let (relative, _) = simplified(&balls(), &SceneRules { target: share, ..rules });
    let limit = 0.001 * 200.0 * 3.0_f64.sqrt();
    for mesh in &relative.meshes {
        assert!(mesh.max <= 1.001 * limit, "{} {limit}", mesh.max);
    }
    assert!(relative.meshes[2].max > 0.5 * limit);
}

/// The rounding of a result that will be written as integers is within the error limit, and part of all errors.
#[test]
fn rounding_counts_for_an_error_limit() {
    let target = SceneTarget { max_error: Some("0.05".parse().unwrap()), ..SceneTarget::default() };
    let choices = Choices { verify: true, ..Choices::default() };
    let quantization = Quantization { positions: 13, ..Quantization::default() };
    let plain = SceneRules { target, choices, ..SceneRules::default() };
    let rules = SceneRules { quantization: Some(quantization), ..plain.clone() };
    let [(plain, _), (made, _)] = [plain, rules.clone()].map(|rules| simplified(&balls(), &rules));
    let quantized = made.scene.quantized(&quantization).unwrap();
    for (mesh, plain) in made.meshes.iter().zip(&plain.meshes) {
        let upper = mesh.bound.unwrap().upper.unwrap();
        // Instances of the first mesh are drawn, so its positions stay as they are.
        assert!((mesh.rounding > 0.0) == (mesh.times == 1) && plain.rounding == 0.0);
        assert!(upper <= 0.05 && mesh.max <= upper && mesh.rounding < mesh.rms, "{mesh:?}");
        assert!(mesh.faces[1] >= plain.faces[1]);
    }
    let most = made.meshes.iter().map(|mesh| mesh.rounding).fold(0.0, f64::max);
    assert!(quantized.rounding <= most && quantized.rounding > 0.5 * most);
    let coarse = Quantization { positions: 8, ..quantization };
    let rules = SceneRules { quantization: Some(coarse), ..rules };
    let refused = simplify_scene(&scene(&balls()), &rules, &mut |_| ControlFlow::Continue(()));
    assert!(matches!(refused, Err(SceneError::Rounding { .. })), "{refused:?}");
}

/// A straight tube with a skin of two joints. An animation bends it at z = 2.
fn elbow() -> Vec<u8> {
    let mut scene = Builder::new();
    let tube = tube(24, 60);
    let far = |z: f32| ((z - 1.5).clamp(0.0, 1.0) * 255.0).round() as u8;
    let weights: Vec<[u8; 4]> =
        tube.positions.iter().map(|p| [255 - far(p[2]), far(p[2]), 0, 0]).collect();
    let joints = vec![[0_u8, 1, 0, 0]; weights.len()];
    let primitive = json!({
        "attributes": {
            "POSITION": scene.positions(&tube.positions), "JOINTS_0": scene.bytes(&joints, false),
            "WEIGHTS_0": scene.bytes(&weights, true),
        },
        "indices": scene.indices(&tube.triangles),
    });
    let mesh = scene.push("meshes", json!({ "primitives": [primitive] }));
    let tip = scene.push("nodes", json!({ "translation": [0, 0, 2] }));
    let base = scene.node(json!({ "children": [tip] }));
    let mut inverse = [[0.0_f32; 16]; 2];
    for (matrix, z) in inverse.iter_mut().zip([0.0, -2.0]) {
        (0..4).for_each(|k| matrix[5 * k] = 1.0);
        matrix[14] = z;
    }
    let bytes: Vec<u8> = inverse.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    let inverse = scene.accessor("MAT4", 5126, 2, &bytes);
    let skin =
        scene.push("skins", json!({ "joints": [base, tip], "inverseBindMatrices": inverse }));
    scene.node(json!({ "mesh": mesh, "skin": skin }));
    let times = scene.floats(&[[0.0], [1.0], [2.0]]);
    let turn = |angle: f32| [(0.5 * angle).sin(), 0.0, 0.0, (0.5 * angle).cos()];
    let turns = scene.floats(&[turn(0.0), turn(BEND[0]), turn(BEND[1])]);
    let channel = json!({ "sampler": 0, "target": { "node": tip, "path": "rotation" } });
    scene.push(
        "animations",
        json!({ "channels": [channel], "samplers": [{ "input": times, "output": turns }] }),
    );
    scene.glb()
}

/// The angles of the key frames.
const BEND: [f32; 2] = [0.8, 1.8];

/// The triangles of an elbow in a file, bent by an angle.
fn bent(file: &[u8], angle: f64) -> Surface {
    let found = Found::new(file);
    let primitive = found.primitive(0, 0);
    let [at, joints, weights] =
        ["POSITION", "JOINTS_0", "WEIGHTS_0"].map(|name| found.attribute(primitive, name));
    let turn = DQuat::from_rotation_x(angle);
    let moved = |v: usize| {
        let p = DVec3::from_slice(&at[v]);
        let far: f64 = (0..4).filter(|&k| joints[v][k] == 1.0).map(|k| weights[v][k]).sum();
        let elbow = DVec3::new(0.0, 0.0, 2.0);
        p.lerp(turn * (p - elbow) + elbow, far / 255.0)
    };
    let positions: Vec<DVec3> = (0..at.len()).map(moved).collect();
    let triangles: Vec<[u32; 3]> =
        found.triangles(primitive).iter().map(|t| t.map(|v| u32::try_from(v).unwrap())).collect();
    Surface::from_triangles(&positions, &triangles).unwrap()
}

/// Straight, the elbow is a tube like the rest, and its edges cost nothing. Bent, it needs them.
#[test]
fn an_elbow_keeps_the_faces_that_its_poses_need() {
    let file = elbow();
    let sampling = CompareOptions { samples: 20_000, ..CompareOptions::default() };
    let errors = |bytes: &[u8], angle: f32| {
        let [input, result] = [&file, bytes].map(|file| bent(file, f64::from(angle)));
        compare(&input, &result, &sampling)
    };
    for ratio in [0.3, 0.1] {
        let rest_only = SceneRules { poses: 0, ..to_ratio(ratio) };
        let (plain, without) = simplified(&file, &rest_only);
        let (posed, with) = simplified(&file, &to_ratio(ratio));
        assert_eq!(plain.meshes[0].faces, posed.meshes[0].faces);
        assert_eq!(plain.meshes[0].deformed, None);
        let found = posed.meshes[0].deformed.unwrap();
        // Both key frames; the first one, and the nodes as they are, are the mesh as it is.
        assert_eq!(found.poses, 2);
        let bends = BEND.map(|angle| errors(&with, angle));
        let largest = bends.iter().map(Comparison::hausdorff).fold(0.0, f64::max);
        assert!((found.max / largest - 1.0).abs() < 0.1, "{found:?} {largest}");
        for (error, angle) in bends.iter().zip(BEND) {
            let other = errors(&without, angle);
            assert!(
                error.rms() < 0.7 * other.rms(),
                "{ratio} {angle}: {} {}",
                error.rms(),
                other.rms()
            );
        }
    }
    // More poses than there are change nothing.
    let many = SceneRules { poses: 100, ..to_ratio(0.3) };
    assert!(simplified(&file, &many).1 == simplified(&file, &to_ratio(0.3)).1);
}

#[test]
fn poses_make_no_difference_to_a_mesh_that_does_not_deform() {
    let file = balls();
    let without = SceneRules { poses: 0, ..to_ratio(0.2) };
    let (made, bytes) = simplified(&file, &to_ratio(0.2));
    assert!(bytes == simplified(&file, &without).1);
    assert!(made.meshes.iter().all(|mesh| mesh.deformed.is_none()));
}

/// A face that is there twice goes; the skin, the animation, the other meshes and everything else stay.
#[test]
fn repairs_leave_a_scene_whole() {
    let mut builder = rich();
    let clean = scene(&rich().glb());
    let made = repaired_scene(&clean, &Repair::lenient()).unwrap();
    assert_eq!(made.scene.json(), clean.json());
    let tube = tube(24, 24);
    let twice: Vec<[u32; 3]> = tube.triangles.iter().chain(&tube.triangles[..5]).copied().collect();
    builder.json["meshes"][1]["primitives"][0]["indices"] = builder.indices(&twice).into();
    let input = scene(&builder.glb());
    let made = repaired_scene(&input, &Repair::lenient()).unwrap();
    assert_eq!(
        made.repairs.iter().map(|report| report.dropped_duplicates.count()).collect::<Vec<_>>(),
        [0, 5, 0]
    );
    assert_eq!(made.lost, []);
    let geometry = ["accessors", "bufferViews", "buffers", "meshes"];
    let [before, after] = [&input, &made.scene].map(Scene::json);
    for member in
        before.as_object().unwrap().keys().filter(|name| !geometry.contains(&name.as_str()))
    {
        if member == "animations" || member == "skins" {
            assert_eq!(
                before[member].as_array().unwrap().len(),
                after[member].as_array().unwrap().len()
            );
        } else {
            assert_eq!(before[member], after[member], "{member}");
        }
    }
    let mut bytes = Vec::new();
    made.scene.write_to(&mut bytes, Format::Glb).unwrap();
    let [found, original] = [&bytes, &rich().glb()].map(|file| Found::new(file));
    let [a, b] = [&found, &original].map(|found| found.primitive(1, 0));
    assert_eq!(found.triangles(a).len(), original.triangles(b).len());
    // Every vertex is one of the input, with all of its data.
    let names = a["attributes"].as_object().unwrap();
    assert_eq!(
        names.keys().collect::<Vec<_>>(),
        b["attributes"].as_object().unwrap().keys().collect::<Vec<_>>()
    );
    let corners = |found: &Found, primitive: &Value| -> Vec<Vec<Vec<f64>>> {
        let columns: Vec<_> = names
            .keys()
            .filter(|name| *name != "TANGENT")
            .map(|name| found.attribute(primitive, name))
            .collect();
        let all = found.triangles(primitive).into_iter().flatten();
        all.map(|v| columns.iter().map(|column| column[v].clone()).collect()).collect()
    };
    assert_eq!(corners(&found, a), corners(&original, b));
}

/// One ball, drawn at the scales 1, 10 and 1 again.
fn one_ball() -> Builder {
    let mut builder = Builder::new();
    let (positions, triangles) = ball(48, 24);
    let primitive = json!({
        "attributes": { "POSITION": builder.positions(&positions) }, "indices": builder.indices(&triangles),
    });
    let mesh = builder.push("meshes", json!({ "primitives": [primitive], "name": "ball" }));
    for scale in [1.0, 10.0, 1.0] {
        builder.node(json!({ "mesh": mesh, "scale": [scale, scale, scale] }));
    }
    builder
}

fn drawn_meshes(scene: &Scene) -> Vec<usize> {
    scene.nodes().filter_map(|node| node.mesh).collect()
}

#[test]
fn nodes_have_meshes_of_their_own_where_their_results_differ() {
    let mut builder = one_ball();
    let file = builder.clone().glb();
    let per = |budget: SceneBudget, target: SceneTarget| SceneRules {
        target,
        budget,
        ..SceneRules::default()
    };
    let limit = SceneTarget { max_error: Some("0.02".parse().unwrap()), ..SceneTarget::default() };
    let (made, _) = simplified(&file, &per(SceneBudget::Mesh, limit));
    assert_eq!(drawn_meshes(&made.scene), [0, 0, 0]);
    let large = made.meshes[0].faces[1];
    let (made, _) = simplified(&file, &per(SceneBudget::Node, limit));
    assert_eq!(drawn_meshes(&made.scene), [0, 1, 0]);
    assert_eq!(made.scene.mesh_name(1), Some("ball"));
    let [small, other] = &made.meshes[..] else { panic!("{:?}", made.meshes) };
    assert_eq!((small.times, other.times, other.faces[1]), (2, 1, large));
    assert!(2 * small.faces[1] < large && small.max <= 0.02 && other.max <= 0.02, "{small:?}");
    // A share of the faces is the same for all nodes.
    let (made, bytes) = simplified(&file, &per(SceneBudget::Node, to_ratio(0.3).target));
    assert_eq!(drawn_meshes(&made.scene), [0, 0, 0]);
    assert!(simplified(&file, &per(SceneBudget::Mesh, to_ratio(0.3).target)).1 == bytes);
    // Instances of a node count.
    let places = builder.floats(&[[5.0, 0.0, 0.0], [-5.0, 0.0, 0.0], [0.0, 5.0, 0.0]]);
    builder.json["nodes"][2]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    builder.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    let file = builder.clone().glb();
    let faces = SceneTarget { faces: Some(900), ..SceneTarget::default() };
    let (made, _) = simplified(&file, &per(SceneBudget::Node, faces));
    assert_eq!(drawn_meshes(&made.scene), [0, 0, 1]);
    let found: Vec<_> = made.meshes.iter().map(|mesh| (mesh.times, mesh.faces[1])).collect();
    assert_eq!(found, [(2, 900), (3, 300)]);
    // Levels of detail are those of the nodes.
    let steps = SceneSteps { errors: vec!["0.02".parse().unwrap()], ..SceneSteps::default() };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let rules = per(SceneBudget::Node, SceneTarget::default());
    let made = scene_levels(&scene(&file), &steps, &rules, go_on).unwrap();
    let faces: Vec<_> = made.levels[0].meshes.iter().map(|mesh| mesh.faces[1]).collect();
    assert!(matches!(faces[..], [small, large] if 2 * small < large), "{faces:?}");
    assert_eq!(made.together().unwrap().0.mesh_count(), 4);
    // A path into a mesh cannot name its copy.
    builder.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing", "KHR_animation_pointer"]);
    builder.json["nodes"][0]["extensions"] = json!({ "KHR_animation_pointer": {} });
    let error =
        simplify_scene(&scene(&builder.clone().glb()), &per(SceneBudget::Node, limit), go_on);
    let error = error.unwrap_err().to_string();
    assert!(error.contains("KHR_animation_pointer") && error.contains("same result"), "{error}");
}

/// The same bits, whatever the number of threads.
#[test]
fn the_division_of_faces_does_not_depend_on_chance() {
    let file = rich().glb();
    let (_, first) = simplified(&file, &to_ratio(0.25));
    let (_, second) = simplified(&file, &to_ratio(0.25));
    assert!(first == second);
}

/// Levels of a scene of one mesh are the levels of the mesh, with the same distances.
#[test]
fn levels_of_a_single_mesh_are_those_of_the_mesh() {
    let mut builder = Builder::new();
    let tube = tube(40, 30);
    let attributes = json!({
        "POSITION": builder.positions(&tube.positions), "TEXCOORD_0": builder.floats(&tube.uvs),
    });
    let primitive =
        json!({ "attributes": attributes, "indices": builder.indices(&tube.triangles) });
    builder.push("meshes", json!({ "primitives": [primitive] }));
    builder.node(json!({ "mesh": 0, "name": "tube" }));
    let file = builder.glb();
    let model = read_from(&mut &file[..], &ReadOptions::default()).unwrap();
    let mut repair = Repair::strict();
    repair.weld = Weld::Exact;
    let loaded = Loaded::build_with_needed_repairs(model, &repair).unwrap();
    let attributes = Attributes::find(loaded.source(), &AttributeRules::default()).unwrap();
    let choices = Choices::default();
    for (ratios, faces) in [(vec![0.5, 0.1], vec![]), (vec![], vec![900, 77])] {
        let steps = LevelSteps { ratios, faces, ..LevelSteps::default() };
        let mut options = choices.options(&loaded.mesh, steps.limits()).for_levels();
        attributes.constrain(&loaded.mesh, &mut options);
        let log = simplify(&loaded.mesh, &options).unwrap().log;
        let record = LevelRecord { log, ..LevelRecord::default() };
        let expected =
            steps.levels(&record, loaded.source(), &attributes, choices.check()).unwrap();
        let LevelSteps { ratios, faces, .. } = steps;
        let steps = SceneSteps { ratios, faces, ..SceneSteps::default() };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let made = scene_levels(&scene(&file), &steps, &SceneRules::default(), go_on).unwrap();
        assert_eq!(made.levels.len(), expected.len());
        for (level, expected) in made.levels.iter().zip(&expected) {
            let mut bytes = Vec::new();
            mesh_io::write_to(&mut bytes, &expected.model, Format::Glb, &Default::default())
                .unwrap();
            let mut out = Vec::new();
            level.scene.write_to(&mut out, Format::Glb).unwrap();
            let [a, b] = [&bytes, &out].map(|file| Found::new(file));
            let [p, q] = [&a, &b].map(|found| found.primitive(0, 0));
            assert_eq!(a.attribute(p, "POSITION"), b.attribute(q, "POSITION"));
            assert_eq!(a.triangles(p), b.triangles(q));
            assert_eq!(level.max, expected.distance.hausdorff());
            assert!((level.rms - expected.distance.rms()).abs() <= 1e-12 * level.rms);
        }
    }
}

#[test]
fn levels_carry_all_data_and_animations_drive_all_of_them() {
    let file = rich().glb();
    let steps = SceneSteps { ratios: vec![0.5, 0.2], ..SceneSteps::default() };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let made = scene_levels(&scene(&file), &steps, &SceneRules::default(), go_on).unwrap();
    let names = |scene: &Scene, mesh: usize| {
        let attributes = &scene.json()["meshes"][mesh]["primitives"][0]["attributes"];
        attributes.as_object().unwrap().keys().cloned().collect::<BTreeSet<_>>()
    };
    let input = scene(&file);
    for level in &made.levels {
        assert_eq!(names(&level.scene, 1), names(&input, 1));
        assert!(level.max > 0.0 && level.rms > 0.0 && level.rms < level.max);
    }
    let mut wide = made.coverage.clone();
    wide.dedup();
    assert_eq!((wide.len(), wide[2]), (3, 0.0));
    // An animation of weights is one of all levels.
    let mut builder = rich();
    let arm = builder.json["nodes"].as_array().unwrap().iter().position(|n| n["name"] == "arm");
    let target = json!({ "node": arm.unwrap(), "path": "weights" });
    let animation = &mut builder.json["animations"][0];
    animation["channels"].as_array_mut().unwrap().push(json!({ "sampler": 0, "target": target }));
    let input = scene(&builder.glb());
    let made = scene_levels(&input, &steps, &SceneRules::default(), go_on).unwrap();
    let (together, lost) = made.together().unwrap();
    assert_eq!(lost, []);
    let json = together.json();
    let channels = json["animations"][0]["channels"].as_array().unwrap();
    let driven = channels.iter().filter(|channel| channel["target"]["path"] == "weights");
    let driven: Vec<&Value> =
        driven.map(|c| &json["nodes"][c["target"]["node"].as_u64().unwrap() as usize]).collect();
    assert_eq!(driven.len(), 3);
    for node in driven {
        let mesh = &json["meshes"][node["mesh"].as_u64().unwrap() as usize];
        assert!(mesh["name"] == "arm" && node["skin"] == 0 && node["weights"] == json!([0.25]));
    }
    assert!(json["extensionsUsed"].as_array().unwrap().contains(&"MSFT_lod".into()));
    // A scene with levels gets no others.
    let again = scene_levels(&together, &steps, &SceneRules::default(), go_on).unwrap();
    let error = again.together().unwrap_err().to_string();
    assert!(error.contains("MSFT_lod") && error.contains("file of its own"), "{error}");
}

/// A scene of wavy squares of which each cell is a chart of its own, one square for each scale.
fn charted_squares(scales: &[u32]) -> Vec<u8> {
    let mut builder = Builder::new();
    let (mut positions, mut uvs, mut triangles) = (vec![], vec![], vec![]);
    let height = |i: u32, j: u32| 0.3 * (i as f32 * 0.7).sin() * (j as f32 * 0.9).cos();
    for i in 0..16 {
        for j in 0..16 {
            let first = positions.len() as u32;
            for [a, b] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
                positions.push([(i + a) as f32, (j + b) as f32, height(i + a, j + b)]);
                let cell = [2 * i + a, 2 * j + b].map(|k| k as f32 / 32.0);
                uvs.push(cell);
            }
            triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    for scale in scales {
        let attributes = json!({
            "POSITION": builder.positions(&positions), "TEXCOORD_0": builder.floats(&uvs),
        });
        let primitive = json!({ "attributes": attributes, "indices": builder.indices(&triangles) });
        let mesh = builder.push("meshes", json!({ "primitives": [primitive] }));
        builder.node(json!({ "mesh": mesh, "scale": [scale, scale, scale] }));
    }
    builder.glb()
}

/// The smallest charts are those of the smaller one of two squares.
#[test]
fn the_smallest_charts_of_all_meshes_are_merged_first() {
    let (made, _) = simplified(&charted_squares(&[1, 10]), &to_ratio(0.5));
    let charts: Vec<[usize; 2]> = made.meshes.iter().filter_map(|mesh| mesh.charts).collect();
    assert!(charts.len() == 2 && charts.iter().all(|charts| charts[0] == 256), "{charts:?}");
    assert!(charts[0][1] < charts[1][1], "{charts:?}");
}

/// Levels have room for as few faces as a simplified scene, and a number that no level reaches is named.
#[test]
fn charts_of_levels_are_merged_for_the_coarsest() {
    for scales in [&[1][..], &[1, 10]] {
        let scene =
            Scene::read_from(&mut &*charted_squares(scales), &ReadOptions::default()).unwrap();
        let steps = SceneSteps { ratios: vec![0.5, 0.1], ..SceneSteps::default() };
        let levels = |rules: &SceneRules| {
            let go_on = &mut |_: &_| ControlFlow::Continue(());
            scene_levels(&scene, &steps, rules, go_on).unwrap()
        };
        let drawn =
            |level: &SceneLevel| level.meshes.iter().map(|mesh| mesh.faces[1]).sum::<usize>();
        let wanted: usize = (0.1 * 512.0 * scales.len() as f64).ceil() as usize;
        let merged = levels(&SceneRules::default());
        assert!(merged.missed_faces.is_empty(), "{:?}", merged.missed_faces);
        assert!(drawn(&merged.levels[1]) <= wanted);
        assert!(merged.levels[1].meshes.iter().all(|mesh| mesh.charts.is_some_and(|[a, b]| b < a)));
        let kept = levels(&SceneRules { keep_seams: true, ..SceneRules::default() });
        assert!(kept.missed_faces.contains(&wanted), "{:?}", kept.missed_faces);
        assert!(drawn(&kept.levels[1]) > wanted && kept.levels[1].meshes[0].charts.is_none());
    }
}

/// Programs ignore tangents without normals, so they are not made, and named as lost.
#[test]
fn tangents_without_normals_are_named() {
    let (positions, triangles) = ball(24, 12);
    let normals: Vec<[f32; 3]> =
        positions.iter().map(|&p| glam::Vec3::from(p).normalize_or_zero().into()).collect();
    let tangents = vec![[1.0, 0.0, 0.0, 1.0]; positions.len()];
    for has_normals in [true, false] {
        let mut builder = Builder::new();
        let mut attributes = json!({
            "POSITION": builder.positions(&positions),
            "TANGENT": builder.floats(&tangents),
        });
        if has_normals {
            attributes["NORMAL"] = builder.floats(&normals).into();
        }
        let indices = builder.indices(&triangles);
        let primitive = json!({ "attributes": attributes, "indices": indices });
        builder.push("meshes", json!({ "primitives": [primitive] }));
        builder.node(json!({ "mesh": 0 }));
        let glb = builder.glb();
        let (made, _) = simplified(&glb, &to_ratio(0.5));
        let is_named = |lost: &[mesh_io::Lost]| lost.iter().any(|l| l.what.contains("tangents"));
        assert_eq!(is_named(&made.losses()), !has_normals);
    }
}

/// A ball that is drawn flat, as exporters write it: each triangle has three vertices of its own, whose normals are
/// about the normal of the face. With smooth normals it is not flat.
#[test]
fn normals_near_those_of_the_faces_are_flat() {
    let (positions, triangles) = ball(24, 12);
    let corners: Vec<[f32; 3]> =
        triangles.iter().flatten().map(|&v| positions[v as usize]).collect();
    let indices: Vec<[u32; 3]> =
        (0..triangles.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let radial = |p: [f32; 3]| glam::Vec3::from(p).normalize();
    let flat = |at: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| glam::Vec3::from(corners[at - at % 3 + k]));
        // Each corner leans a little towards its own smooth normal.
        (b - a).cross(c - a).normalize().lerp(radial(corners[at]), 0.1)
    };
    let smooth = |at: usize| radial(corners[at]);
    for (normal, is_flat) in [(&flat as &dyn Fn(usize) -> glam::Vec3, true), (&smooth, false)] {
        let normals: Vec<[f32; 3]> =
            (0..corners.len()).map(|at| normal(at).normalize().into()).collect();
        let mut builder = Builder::new();
        let primitive = json!({
            "attributes": { "POSITION": builder.positions(&corners), "NORMAL": builder.floats(&normals) },
            "indices": builder.indices(&indices),
        });
        builder.push("meshes", json!({ "primitives": [primitive] }));
        builder.node(json!({ "mesh": 0 }));
        let (made, _) = simplified(&builder.glb(), &to_ratio(0.5));
        assert_eq!(made.meshes[0].is_flat_shaded, is_flat);
    }
}
