//! Scenes whose vertex data are rounded to integers (`KHR_mesh_quantization`).
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing)]

use crate::built_scene::{Builder, rich, tube, without};
use glam::{DMat4, DVec3};
use mesh_io::{
    Compression, Format, NewPrimitive, Quantization, QuantizedScene, ReadOptions, Scene,
    ScenePrimitive, VertexData, WriteError, WriteOptions, read_from, write_to,
};
use proptest::prelude::*;
use serde_json::{Value, json};

const NAME: &str = "KHR_mesh_quantization";

fn scene(file: &[u8]) -> Scene {
    Scene::read_from(&mut &file[..], &ReadOptions::default()).unwrap()
}

fn written(scene: &Scene) -> Vec<u8> {
    let mut bytes = Vec::new();
    scene.write_to(&mut bytes, Format::Glb).unwrap();
    bytes
}

fn quantized(scene: &Scene) -> QuantizedScene {
    let mut quantized = scene.quantized(&Quantization::default()).unwrap();
    quantized.scene = self::scene(&written(&quantized.scene));
    quantized
}

fn vector(data: &VertexData, vertex: usize) -> DVec3 {
    DVec3::from([0, 1, 2].map(|k| data.get(vertex, k) / data.one()))
}

fn find<'p>(primitive: &'p ScenePrimitive, name: &str) -> Option<&'p VertexData> {
    primitive.attributes.iter().find(|data| data.name == name)
}

/// The joints of a vertex with their weights, of sum 1.
fn influences(primitive: &ScenePrimitive, vertex: usize) -> Vec<(usize, f64)> {
    let mut all = Vec::new();
    for set in 0.. {
        let Some(weights) = find(primitive, &format!("WEIGHTS_{set}")) else { break };
        let joints = find(primitive, &format!("JOINTS_{set}")).unwrap();
        let weight = |k| weights.get(vertex, k) / weights.one();
        all.extend((0..4).map(|k| (joints.get(vertex, k) as usize, weight(k))));
    }
    let sum: f64 = all.iter().map(|(_, weight)| weight).sum();
    all.into_iter().map(|(joint, weight)| (joint, weight / sum)).collect()
}

/// The weights of each joint.
fn by_joint(influences: &[(usize, f64)], joints: usize) -> Vec<f64> {
    let mut weights = vec![0.0; joints];
    influences.iter().for_each(|(joint, weight)| weights[*joint] += weight);
    weights
}

/// Checks that everything is drawn in the same place within the rounding, and the data are within half a step.
fn check(before: &Scene, after: &QuantizedScene) {
    let rounding = after.rounding;
    let [old, new] = [before, &after.scene].map(|scene| scene.draws().unwrap());
    assert_eq!(old.len(), new.len());
    let poses =
        [(before, &old), (&after.scene, &new)].map(|(scene, draws)| scene.poses(draws).unwrap());
    for (draw, (old, new)) in old.iter().zip(&new).enumerate() {
        assert_eq!((old.mesh, old.times), (new.mesh, new.times));
        let [was, is] = [(before, old), (&after.scene, new)]
            .map(|(scene, draw)| scene.mesh(draw.mesh).unwrap().unwrap());
        assert_eq!(was.model.soup.corners(), is.model.soup.corners());
        assert_eq!(poses[0][draw].len(), poses[1][draw].len());
        for (was, is) in was.primitives.iter().zip(&is.primitives) {
            check_data(was, is);
            let [from, to] = [was, is].map(|primitive| find(primitive, "POSITION").unwrap());
            let moved = |a: DVec3, b: DVec3, more: f64| {
                // Transforms have 32 bits in the file.
                let slack = 2e-6 * (1.0 + a.length());
                assert!(a.distance(b) <= rounding + more + slack, "{a} {b} {rounding} {more}");
            };
            for vertex in 0..from.count() {
                let [a, b] = [from, to].map(|data| vector(data, vertex));
                let is_skinned = find(was, "WEIGHTS_0").is_some();
                if !is_skinned && was.targets.is_empty() {
                    for (old, new) in old.transforms.iter().zip(&new.transforms) {
                        moved(old.transform_point3(a), new.transform_point3(b), 0.0);
                    }
                    continue;
                }
                for (old_pose, new_pose) in poses[0][draw].iter().zip(&poses[1][draw]) {
                    assert_eq!(old_pose.weights, new_pose.weights);
                    let shift = |primitive: &ScenePrimitive| -> DVec3 {
                        let targets = primitive.targets.iter().zip(&old_pose.weights);
                        let of = |(target, weight): (&Vec<VertexData>, &f64)| {
                            let data = target.iter().find(|data| data.name == "POSITION");
                            data.map_or(DVec3::ZERO, |data| *weight * vector(data, vertex))
                        };
                        targets.map(of).sum()
                    };
                    let [a, b] = [a + shift(was), b + shift(is)];
                    if !is_skinned {
                        let [old, new] = [old, new].map(|draw| draw.transforms[0]);
                        moved(old.transform_point3(a), new.transform_point3(b), 0.0);
                        continue;
                    }
                    let all = [(was, old_pose), (is, new_pose)].map(|(primitive, pose)| {
                        by_joint(&influences(primitive, vertex), pose.joints.len())
                    });
                    let place = |joints: &[DMat4], weights: &[f64], at: DVec3| -> DVec3 {
                        let joints = joints.iter().zip(weights);
                        joints.map(|(joint, weight)| *weight * joint.transform_point3(at)).sum()
                    };
                    let at = |joint: &DMat4| joint.transform_point3(a);
                    let apart = old_pose.joints.iter().flat_map(|one| {
                        old_pose.joints.iter().map(move |other| at(one).distance(at(other)))
                    });
                    let apart = apart.fold(0.0, f64::max);
                    let shifted: f64 = all[0].iter().zip(&all[1]).map(|(a, b)| (a - b).abs()).sum();
                    assert!(shifted <= 8.0 / 255.0, "{shifted}");
                    let [a, b] =
                        [place(&old_pose.joints, &all[0], a), place(&new_pose.joints, &all[1], b)];
                    moved(a, b, shifted * apart);
                }
            }
        }
    }
}

fn check_data(was: &ScenePrimitive, is: &ScenePrimitive) {
    assert_eq!(was.attributes.len(), is.attributes.len());
    for (old, new) in was.attributes.iter().zip(&is.attributes) {
        assert_eq!((&old.name, old.width, old.count()), (&new.name, new.width, new.count()));
        let step = match (old.name.as_str(), new.component.bytes()) {
            ("POSITION", _) => continue,
            (name, 1) if name.starts_with("WEIGHTS") => {
                for vertex in 0..new.count() {
                    let sets = is.attributes.iter().filter(|data| data.name.starts_with("WEIGHTS"));
                    let all = sets.flat_map(|data| (0..4).map(move |k| data.get(vertex, k)));
                    assert_eq!(all.sum::<f64>(), 255.0);
                }
                continue;
            }
            (name, _) if name.starts_with("JOINTS") => continue,
            _ if old.component == new.component => 0.0,
            _ => 1.0 / new.one(),
        };
        for vertex in 0..old.count() {
            for k in 0..old.width {
                let [a, b] = [old, new].map(|data| data.get(vertex, k) / data.one());
                assert!((a - b).abs() <= 0.5 * step + 1e-7, "{} {a} {b}", old.name);
            }
        }
    }
}

/// A random scene: meshes of one or two primitives, some with skins, targets, colours, or several sets of coordinates,
/// drawn by nodes of all kinds.
fn random(seed: u64) -> Builder {
    let mut state = seed;
    let mut below = move |count: u32| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % u64::from(count)) as u32
    };
    let mut scene = Builder::new();
    let joints: Vec<usize> = (0..2)
        .map(|i| scene.node(json!({ "translation": [0.5 * f64::from(i), 0, f64::from(i)] })))
        .collect();
    let skin = scene.push("skins", json!({ "joints": joints }));
    let (times, moves) = (
        scene.floats(&[[0.0], [1.0], [3.0]]),
        scene.floats(&[[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [0.0, 5.0, 0.0]]),
    );
    let mut channels =
        vec![json!({ "sampler": 0, "target": { "node": joints[1], "path": "translation" } })];
    let mut samplers = vec![json!({ "input": times, "output": moves })];
    for _ in 0..=below(4) {
        let (has_skin, targets) = (below(3) == 0, below(3));
        let size = 10.0_f32.powi(below(5) as i32 - 2);
        let offset = [0, 1, 2].map(|_| (below(2000) as f32 - 1000.0) * 0.01 * size);
        let far = if below(4) == 0 { 3.0 } else { 1.0 };
        let mut primitives = Vec::new();
        for _ in 0..=below(2) {
            let tube = tube(4 + below(5), 2 + below(4));
            let place = |p: &[f32; 3]| [0, 1, 2].map(|k| size * p[k] + offset[k]);
            let positions: Vec<[f32; 3]> = tube.positions.iter().map(place).collect();
            let uvs: Vec<[f32; 2]> =
                tube.uvs.iter().map(|uv| uv.map(|u| far * u - 0.25 * (far - 1.0))).collect();
            let mut attributes = json!({
                "POSITION": scene.positions(&positions), "NORMAL": scene.floats(&tube.normals),
                "TEXCOORD_0": scene.floats(&uvs),
            });
            let count = positions.len();
            if below(2) == 0 {
                let colors: Vec<[f32; 3]> =
                    (0..count).map(|_| [0, 1, 2].map(|_| below(1001) as f32 / 1000.0)).collect();
                attributes["COLOR_0"] = scene.floats(&colors).into();
            }
            if has_skin {
                let weights: Vec<[f32; 4]> = (0..count)
                    .map(|_| {
                        let part = below(1001) as f32 / 1000.0;
                        [part, 1.0 - part, 0.0, 0.0]
                    })
                    .collect();
                attributes["JOINTS_0"] = scene.bytes(&vec![[0, 1, 0, 0]; count], false).into();
                attributes["WEIGHTS_0"] = scene.floats(&weights).into();
            }
            let mut primitive =
                json!({ "attributes": attributes, "indices": scene.indices(&tube.triangles) });
            let all: Vec<Value> = (0..targets)
                .map(|_| {
                    let mut moved = Vec::new();
                    for vertex in 0..count as u32 {
                        let change = [0, 1, 2].map(|_| (below(2001) as f32 - 1000.0) * 0.005);
                        if below(3) == 0 {
                            moved.push((vertex, change.map(|number| size * number)));
                        }
                    }
                    if moved.is_empty() {
                        return json!({});
                    }
                    json!({ "POSITION": scene.sparse(count, &moved) })
                })
                .collect();
            if targets > 0 && all.iter().all(|target| !target.as_object().unwrap().is_empty()) {
                primitive["targets"] = all.into();
            }
            primitives.push(primitive);
        }
        let count = |primitive: &Value| primitive["targets"].as_array().map_or(0, Vec::len);
        if primitives.iter().any(|p| count(p) != count(&primitives[0])) {
            primitives.truncate(1);
        }
        let targets = count(&primitives[0]);
        let mesh = scene.push("meshes", json!({ "name": "some", "primitives": primitives }));
        for _ in 0..=below(2) {
            let numbers = [0, 1, 2].map(|_| f64::from(below(100)) - 50.0);
            let mut node = match below(3) {
                0 => json!({ "mesh": mesh }),
                1 => {
                    json!({ "mesh": mesh, "translation": numbers, "rotation": [0, 0.6, 0, 0.8], "scale": [1, 2, 0.5] })
                }
                _ => {
                    json!({ "mesh": mesh, "matrix": [0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, numbers[0], numbers[1], numbers[2], 1] })
                }
            };
            if has_skin {
                node["skin"] = skin.into();
            }
            if below(3) == 0 {
                node["children"] = json!([scene.push(
                    "nodes",
                    json!({ "name": "below", "mesh": mesh, "translation": [1, 1, 1] })
                )]);
                if has_skin {
                    scene.json["nodes"].as_array_mut().unwrap().last_mut().unwrap()["skin"] =
                        skin.into();
                }
            }
            let is_free = node.get("matrix").is_none();
            let node = scene.node(node);
            if is_free && below(3) == 0 {
                channels.push(
                    json!({ "sampler": 0, "target": { "node": node, "path": "translation" } }),
                );
            }
            if targets > 0 && below(2) == 0 {
                let weights: Vec<[f32; 1]> =
                    (0..3 * targets).map(|_| [below(11) as f32 * 0.1]).collect();
                let output = scene.floats(&weights);
                samplers.push(json!({ "input": times, "output": output }));
                channels.push(json!({ "sampler": samplers.len() - 1, "target": { "node": node, "path": "weights" } }));
            }
        }
    }
    scene.push("animations", json!({ "channels": channels, "samplers": samplers }));
    scene
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn rounded_scenes_are_drawn_in_the_same_place(seed: u64) {
        let before = scene(&random(seed).glb());
        let after = quantized(&before);
        check(&before, &after);
        // Morph targets with several weights add their rounding; the bound has each with a part of one.
        let bounds = before.quantization_bounds(&Quantization::default()).unwrap();
        prop_assert!(after.rounding <= bounds.into_iter().fold(0.0, f64::max));
        // Nothing is left to round.
        let again = after.scene.quantized(&Quantization::default()).unwrap();
        prop_assert_eq!(again.rounding, 0.0);
        prop_assert_eq!(again.scene.json(), after.scene.json());
    }
}

/// What is changed beside the data of vertices: nodes and skins undo the grids, and nothing else.
#[test]
fn nodes_and_skins_undo_the_grids() {
    let before = scene(&rich().glb());
    let after = quantized(&before);
    check(&before, &after);
    assert_eq!(after.stayed, Vec::<String>::new());
    let [old, new] = [&before, &after.scene].map(Scene::json);
    // The numbers of accessors in animations and skins can change.
    let changing =
        ["accessors", "bufferViews", "buffers", "nodes", "skins", "animations", "extensionsUsed"];
    assert_eq!(
        without(old, &changing),
        without(new, &[&changing[..], &["extensionsRequired"]].concat())
    );
    assert_eq!(new["extensionsRequired"], json!([NAME]));
    for (old, new) in old["nodes"].as_array().unwrap().iter().zip(new["nodes"].as_array().unwrap())
    {
        let place = ["translation", "scale"];
        assert_eq!(without(old, &place), without(new, &place));
    }
    let inverse = |json: &Value| json["skins"][0]["inverseBindMatrices"].clone();
    assert_ne!(inverse(old), inverse(new));
    // A reader that ignores skins finds the mesh in its place.
    let drawn = |scene: &Scene| {
        let mut bytes = Vec::new();
        scene.write_to(&mut bytes, Format::Glb).unwrap();
        let model = read_from(&mut &bytes[..], &ReadOptions::default()).unwrap();
        model.soup.positions().to_vec()
    };
    let pairs = drawn(&before).into_iter().zip(drawn(&after.scene));
    let apart = pairs.map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
    assert!(apart > 0.0 && apart <= 2.0 * after.rounding, "{apart} {}", after.rounding);
    let kinds = |attributes: &Value| -> Vec<(String, u64, bool)> {
        let attributes = attributes.as_object().unwrap().iter();
        let kind = |(name, accessor): (&String, &Value)| {
            let accessor = &new["accessors"][accessor.as_u64().unwrap() as usize];
            let normalized = accessor["normalized"].as_bool().unwrap_or(false);
            (name.clone(), accessor["componentType"].as_u64().unwrap(), normalized)
        };
        attributes.map(kind).collect()
    };
    let arm = &new["meshes"][1]["primitives"][0];
    let expected = [
        ("COLOR_0", 5121, true),
        ("JOINTS_0", 5121, false),
        ("NORMAL", 5120, true),
        ("POSITION", 5123, false),
        ("TANGENT", 5120, true),
        ("TEXCOORD_0", 5123, true),
        ("TEXCOORD_1", 5123, true),
        ("WEIGHTS_0", 5121, true),
        ("_HEAT", 5126, false),
        ("_PART", 5121, false),
    ];
    let expected = expected.map(|(name, kind, normalized)| (name.to_owned(), kind, normalized));
    assert_eq!(kinds(&arm["attributes"]), expected);
    assert_eq!(kinds(&arm["targets"][0]), [("POSITION".to_owned(), 5122, false)]);
    // The target was sparse, and is.
    let target = arm["targets"][0]["POSITION"].as_u64().unwrap() as usize;
    assert!(new["accessors"][target].get("sparse").is_some());
}

/// A node that is animated, a joint, or above others keeps its transform, and its weights are still animated.
#[test]
fn nodes_that_others_depend_on_draw_from_below() {
    let mut builder = Builder::new();
    let tube = tube(8, 4);
    let moved: Vec<(u32, [f32; 3])> = (0..9).map(|i| (i, [0.5, 0.0, 1.0])).collect();
    let primitive = json!({
        "attributes": { "POSITION": builder.positions(&tube.positions) },
        "indices": builder.indices(&tube.triangles),
        "targets": [{ "POSITION": builder.sparse(tube.positions.len(), &moved) }],
    });
    let mesh = builder.push("meshes", json!({ "primitives": [primitive] }));
    let place = json!([1, 2, 3]);
    let nodes = [
        json!({ "name": "free", "mesh": mesh, "translation": place, "weights": [0.5], "extras": { "id": 1 } }),
        json!({ "name": "moving", "mesh": mesh, "translation": place, "weights": [0.25] }),
        json!({ "name": "eye", "mesh": mesh, "translation": place, "camera": 0 }),
        json!({ "name": "lamp", "mesh": mesh, "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
    ];
    let nodes = nodes.map(|node| builder.node(node));
    builder.push(
        "cameras",
        json!({ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }),
    );
    builder.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    builder.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    let times = builder.floats(&[[0.0], [1.0]]);
    let places = builder.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    let weights = builder.floats(&[[0.0], [1.0]]);
    builder.push("animations", json!({
        "samplers": [{ "input": times, "output": places }, { "input": times, "output": weights }],
        "channels": [
            { "sampler": 0, "target": { "node": nodes[1], "path": "translation" } },
            { "sampler": 1, "target": { "node": nodes[1], "path": "weights" } },
            { "sampler": 1, "target": { "node": nodes[0], "path": "weights" } },
        ],
    }));
    let before = scene(&builder.glb());
    let after = quantized(&before);
    check(&before, &after);
    let json = after.scene.json();
    assert_eq!(json["nodes"].as_array().unwrap().len(), 7);
    assert!(json["nodes"][0]["mesh"] == 0 && json["nodes"][0]["weights"] == json!([0.5]));
    for (node, below) in [(1, 4), (2, 5), (3, 6)] {
        let (node, child) = (&json["nodes"][node], &json["nodes"][below]);
        assert!(node.get("mesh").is_none() && node.get("weights").is_none());
        assert_eq!(node["children"], json!([below]));
        assert_eq!(child["mesh"], 0);
    }
    assert_eq!(json["nodes"][1]["translation"], place);
    assert_eq!(json["nodes"][4]["weights"], json!([0.25]));
    let targets: Vec<&Value> =
        (0..3).map(|i| &json["animations"][0]["channels"][i]["target"]["node"]).collect();
    assert_eq!(targets, [1, 4, 0]);
}

/// Two halves of a tube that meet at a ring, drawn by two nodes in the same place, and one drawn elsewhere.
#[test]
fn borders_between_meshes_in_the_same_place_stay_closed() {
    let whole = tube(12, 8);
    let mut builder = Builder::new();
    let mut ring = Vec::new();
    for half in 0..2_usize {
        let rings = whole.positions[half * 4 * 13..(half * 4 + 5) * 13].to_vec();
        // Halves of other extents: each alone would have a grid of its own.
        let rings: Vec<[f32; 3]> =
            rings.iter().map(|p| [p[0] * 0.37 + 0.1, p[1] * 0.37, p[2]]).collect();
        ring.push(if half == 0 { rings[4 * 13..].to_vec() } else { rings[..13].to_vec() });
        let triangles: Vec<[u32; 3]> =
            whole.triangles.iter().filter(|t| t.iter().all(|&v| v < 5 * 13)).copied().collect();
        let rings: Vec<[f32; 3]> =
            rings.into_iter().chain((half == 1).then_some([7.7, 0.0, 9.1])).collect();
        let primitive = json!({ "attributes": { "POSITION": builder.positions(&rings) }, "indices": builder.indices(&triangles) });
        builder.push("meshes", json!({ "primitives": [primitive] }));
    }
    assert_eq!(ring[0], ring[1]);
    for mesh in [0, 1] {
        builder.node(
            json!({ "mesh": mesh, "translation": [0.3, 0.7, 0.1], "rotation": [0, 0.6, 0, 0.8] }),
        );
    }
    let before = scene(&builder.glb());
    let after = quantized(&before);
    check(&before, &after);
    let meshes = [0, 1].map(|mesh| after.scene.mesh(mesh).unwrap().unwrap());
    let at = |mesh: usize, vertex: usize| {
        find(&meshes[mesh].primitives[0], "POSITION").unwrap().value(vertex).to_vec()
    };
    (0..13).for_each(|i| assert_eq!(at(0, 4 * 13 + i), at(1, i)));
    let nodes = after.scene.json()["nodes"].as_array().unwrap();
    assert!(
        nodes[0]["scale"] == nodes[1]["scale"]
            && nodes[0]["translation"] == nodes[1]["translation"]
    );
}

/// Positions in a buffer, some of which are replaced: the integers are those of the result.
#[test]
fn replaced_positions_are_rounded() {
    let mut builder = Builder::new();
    let tube = tube(8, 4);
    let accessor = builder.positions(&tube.positions);
    let moved =
        builder.sparse(tube.positions.len(), &[(3, [9.0, 8.0, -7.0]), (11, [0.5, 0.5, 0.5])]);
    let sparse = builder.json["accessors"][moved]["sparse"].clone();
    builder.json["accessors"][accessor]["sparse"] = sparse;
    let primitive = json!({ "attributes": { "POSITION": accessor }, "indices": builder.indices(&tube.triangles) });
    builder.push("meshes", json!({ "primitives": [primitive] }));
    builder.node(json!({ "mesh": 0 }));
    let before = scene(&builder.glb());
    let after = quantized(&before);
    check(&before, &after);
    assert!(after.rounding > 0.0 && after.scene.json()["accessors"][0].get("sparse").is_none());
    assert_eq!(after.scene.json()["accessors"][0]["max"][2], 65535);
}

/// What cannot be rounded stays, and is named.
#[test]
fn what_stays_is_named() {
    let with = |edit: &dyn Fn(&mut Builder)| {
        let mut builder = Builder::new();
        let tube = tube(8, 4);
        let far: Vec<[f32; 2]> = tube.uvs.iter().map(|uv| uv.map(|u| 5.0 * u)).collect();
        let bright: Vec<[f32; 3]> = tube.uvs.iter().map(|uv| [uv[0], 2.0, uv[1]]).collect();
        let primitive = json!({
            "attributes": {
                "POSITION": builder.positions(&tube.positions), "TEXCOORD_0": builder.floats(&tube.uvs),
                "TEXCOORD_1": builder.floats(&far), "COLOR_0": builder.floats(&bright),
            },
            "indices": builder.indices(&tube.triangles),
        });
        builder.push("meshes", json!({ "name": "pipe", "primitives": [primitive] }));
        builder.node(json!({ "mesh": 0 }));
        edit(&mut builder);
        let before = scene(&builder.glb());
        let after = quantized(&before);
        check(&before, &after);
        (after.stayed.join("; "), after.rounding, after.scene)
    };
    let (stayed, rounding, found) = with(&|_| {});
    assert!(stayed.contains("mesh 0 \"pipe\": texture coordinates stay"), "{stayed}");
    assert!(stayed.contains("colours stay") && !stayed.contains("positions"), "{stayed}");
    assert!(rounding > 0.0 && found.json().to_string().contains(NAME));
    let thick = |builder: &mut Builder| {
        let volume = json!({ "KHR_materials_volume": { "thicknessFactor": 0.5 } });
        builder.push("materials", json!({ "extensions": volume }));
        builder.json["extensionsUsed"] = json!(["KHR_materials_volume"]);
        builder.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    };
    let instances = |builder: &mut Builder| {
        let places = builder.floats(&[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
        builder.json["nodes"][0]["extensions"] =
            json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
        builder.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    };
    let normals = |builder: &mut Builder| {
        // The positions of a ball around the origin are its normals too.
        let attributes = &mut builder.json["meshes"][0]["primitives"][0]["attributes"];
        attributes["NORMAL"] = attributes["POSITION"].clone();
    };
    type Edit<'a> = &'a dyn Fn(&mut Builder);
    let cases: [(Edit<'_>, &str); 3] =
        [(&thick, "thickness"), (&instances, "instances"), (&normals, "other data")];
    for (edit, why) in cases {
        let (stayed, rounding, found) = with(edit);
        assert!(stayed.contains("positions stay as they are") && stayed.contains(why), "{stayed}");
        // Coordinates of the first set are integers of the format without extensions.
        assert!(rounding == 0.0 && !found.json().to_string().contains(NAME));
    }
    let (stayed, rounding, _) = with(&|builder| {
        builder.json["meshes"][0]["extensions"] = json!({ "ACME_outline": { "accessor": 0 } });
        builder.json["extensionsUsed"] = json!(["ACME_outline"]);
    });
    assert!(stayed.contains("all data stay as they are: extension \"ACME_outline\""), "{stayed}");
    assert_eq!(rounding, 0.0);
}

#[test]
fn models_are_rounded_where_they_are_written_as_gltf() {
    let tube = tube(24, 12);
    let points: Vec<DVec3> = tube.positions.iter().map(|p| DVec3::from(p.map(f64::from))).collect();
    let soup = mesh_core::PolygonSoup::from_triangles(&points, &tube.triangles).unwrap();
    let mut sizes = Vec::new();
    for compression in [Compression::None, Compression::Meshopt] {
        for bits in [None, Some(16), Some(10)] {
            let quantization = bits.map(Quantization::with_bits);
            let options = WriteOptions { compression, quantization, ..WriteOptions::default() };
            let mut file = Vec::new();
            let report = write_to(&mut file, &soup, Format::Glb, &options).unwrap();
            sizes.push(file.len());
            let model = read_from(&mut &file[..], &ReadOptions::default()).unwrap();
            assert_eq!(model.soup.face_count(), soup.face_count());
            // The length of the tube is 4.
            let most = bits.map_or(0.0, |bits| 4.0 / f64::from((1 << bits) - 1) * 0.87);
            assert!(report.rounding <= most && (report.rounding > 0.0) == bits.is_some());
            for place in model.soup.positions() {
                let near =
                    points.iter().map(|point| point.distance(*place)).fold(f64::INFINITY, f64::min);
                assert!(near <= report.rounding + 1e-6, "{near}");
            }
        }
    }
    assert!(sizes[1] < sizes[0] && sizes[4] < sizes[3] && sizes[5] < sizes[4], "{sizes:?}");
    let options = |bits| WriteOptions {
        quantization: Some(Quantization::with_bits(bits)),
        ..WriteOptions::default()
    };
    let refused = write_to(&mut Vec::new(), &soup, Format::Ply, &options(16)).unwrap_err();
    assert!(matches!(refused, WriteError::NoQuantization(Format::Ply)), "{refused}");
    let refused = write_to(&mut Vec::new(), &soup, Format::Glb, &options(17)).unwrap_err();
    assert!(matches!(refused, WriteError::Bits { bits: 17, least: 8, .. }), "{refused}");
}

/// Weights that are rounded before they are written are the same as those that are rounded then.
#[test]
fn weights_are_rounded_alike() {
    let before = (0..)
        .map(|seed| scene(&random(seed).glb()))
        .find(|scene| {
            scene
                .mesh(0)
                .unwrap()
                .is_some_and(|mesh| find(&mesh.primitives[0], "WEIGHTS_0").is_some())
        })
        .unwrap();
    let [old, new] = [&before, &quantized(&before).scene]
        .map(|scene| scene.mesh(0).unwrap().unwrap().primitives.remove(0));
    let (attributes, targets) = (old.attributes, old.targets);
    let mut primitive = NewPrimitive { attributes, targets, ..NewPrimitive::default() };
    primitive.round_weights();
    let names = ["JOINTS_0", "WEIGHTS_0"];
    let rounded = primitive.attributes.iter().filter(|data| names.contains(&data.name.as_str()));
    let rounded: Vec<&VertexData> = rounded.collect();
    let expected: Vec<&VertexData> = names.iter().map(|name| find(&new, name).unwrap()).collect();
    assert_eq!(rounded, expected);
}
