//! Scenes of random trees of nodes: instances, mirrored and scaled transforms, meshes that nothing draws.
#![allow(clippy::unwrap_used, clippy::indexing_slicing)]

use std::ops::ControlFlow;

use crate::built_scene::{Builder, ball, tube, without};
use mesh_core::build::{Repair, Weld};
use mesh_io::{Format, ReadOptions, Scene, read_from};
use mesh_metric::{CompareOptions, Surface, compare};
use mesh_work::{
    Choices, Loaded, SceneRules, SceneSteps, SceneTarget, scene_levels, simplify_scene,
};
use proptest::prelude::*;
use serde_json::{Value, json};
use simplify::{Target, simplify};

/// A node: its parent among the nodes before it, its mesh, its place, and its scale, mirrored or not.
#[derive(Clone, Debug)]
struct Node {
    parent: usize,
    mesh: Option<usize>,
    place: [f64; 3],
    scale: [f64; 3],
    turn: f64,
}

const MESHES: usize = 3;

fn nodes() -> impl Strategy<Value = Vec<Node>> {
    let scale =
        (0.4..2.5_f64, any::<bool>()).prop_map(|(s, is_mirrored)| if is_mirrored { -s } else { s });
    let place = prop::array::uniform3(-4.0..4.0_f64);
    let uneven = prop::array::uniform3(0.7..1.4_f64);
    let node =
        (0..8_usize, prop::option::weighted(0.7, 0..MESHES), place, scale, uneven, -3.0..3.0_f64);
    let node = node.prop_map(|(parent, mesh, place, scale, uneven, turn)| Node {
        parent,
        mesh,
        place,
        scale: uneven.map(|k| k * scale),
        turn,
    });
    prop::collection::vec(node, 2..8)
}

fn file(nodes: &[Node], sizes: [u32; MESHES]) -> Vec<u8> {
    let mut builder = Builder::new();
    for (place, size) in sizes.into_iter().enumerate() {
        let (positions, triangles) = if place == 1 {
            let tube = tube(size, size);
            (tube.positions, tube.triangles)
        } else {
            ball(2 * size, size)
        };
        let primitive = json!({
            "attributes": { "POSITION": builder.positions(&positions) }, "indices": builder.indices(&triangles),
        });
        builder
            .push("meshes", json!({ "primitives": [primitive], "name": format!("mesh {place}") }));
    }
    for (index, node) in nodes.iter().enumerate() {
        let Node { parent, mesh, place, scale, turn } = node;
        let (sin, cos) = (0.5 * turn).sin_cos();
        let mut object = json!({
            "name": format!("node {index}"), "translation": place, "scale": scale, "rotation": [0.0, sin, 0.0, cos],
        });
        if let Some(mesh) = mesh {
            object["mesh"] = (*mesh).into();
        }
        // Every third node is at the top.
        if index == 0 || parent % 3 == 0 {
            builder.node(object);
        } else {
            let node = builder.push("nodes", object);
            let parent = &mut builder.json["nodes"][parent % index];
            if parent.get("children").is_none() {
                parent["children"] = json!([]);
            }
            parent["children"].as_array_mut().unwrap().push(node.into());
        }
    }
    builder.glb()
}

fn bytes(scene: &Scene) -> Vec<u8> {
    let mut bytes = Vec::new();
    scene.write_to(&mut bytes, Format::Glb).unwrap();
    gltf::Gltf::from_slice(&bytes).unwrap();
    bytes
}

/// The surface that a file draws, in the coordinates of the scene.
fn drawn(file: &[u8]) -> Loaded {
    let model = read_from(&mut &file[..], &ReadOptions::default()).unwrap();
    let mut repair = Repair::strict();
    repair.weld = Weld::Exact;
    Loaded::build_with_needed_repairs(model, &repair).unwrap()
}

fn rms(a: &Loaded, b: &mesh_core::TriMesh) -> f64 {
    let options = CompareOptions { samples: 20_000, ..CompareOptions::default() };
    compare(&Surface::new(&a.mesh).unwrap(), &Surface::new(b).unwrap(), &options).rms()
}

fn kept(json: &Value) -> serde_json::Map<String, Value> {
    without(json, &["accessors", "bufferViews", "buffers", "meshes"])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    /// The scene keeps its nodes and its number of faces. Where no mesh is drawn at two scales, it is about as close
    /// to the input as the merged mesh.
    #[test]
    fn a_scene_is_as_close_as_the_merged_mesh(
        nodes in nodes(),
        sizes in prop::array::uniform3(8..28_u32),
        ratio in 0.1..0.5_f64,
    ) {
        prop_assume!(nodes.iter().any(|node| node.mesh.is_some()));
        let input = file(&nodes, sizes);
        let scene = Scene::read_from(&mut &input[..], &ReadOptions::default()).unwrap();
        let target = SceneTarget { ratio: Some(ratio), ..SceneTarget::default() };
        let rules = SceneRules { target, ..SceneRules::default() };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let made = simplify_scene(&scene, &rules, go_on).unwrap();
        prop_assert_eq!(kept(scene.json()), kept(made.scene.json()));
        let [before, after] = [0, 1].map(|i| -> usize {
            made.meshes.iter().map(|mesh| mesh.times * mesh.faces[i]).sum()
        });
        let budget = (ratio * before as f64).ceil();
        // The last collapse removes two faces of every instance.
        let most_times = made.meshes.iter().map(|mesh| mesh.times).max().unwrap();
        let least: usize = made.meshes.iter().map(|mesh| 4 * mesh.times).sum();
        // The share of a single mesh is rounded.
        prop_assert!(after as f64 <= (budget + most_times as f64).max(least as f64), "{after} of {before}");
        prop_assert!((after + 3 * most_times + 2 * made.meshes.len()) as f64 >= budget, "{after} of {before}");
        prop_assume!(made.meshes.iter().all(|mesh| mesh.times <= 1));
        let out = bytes(&made.scene);
        let (original, ours) = (drawn(&input), drawn(&out));
        // Ten faces can be a third of the error where the curve of error over faces is steep, so the merged mesh has
        // a tenth fewer. Planes have errors of rounding.
        let faces = ours.mesh.topology().face_count();
        let target = Target { faces: Some(faces - faces / 10 - 4), ..Target::default() };
        let merged =
            simplify(&original.mesh, &Choices::default().options(&original.mesh, target)).unwrap();
        let [found, expected] = [rms(&original, &ours.mesh), rms(&original, &merged.mesh)];
        prop_assert!(found <= 1.3 * expected + 1e-9, "{found} instead of {expected}");
    }

    /// Every level keeps the nodes; the levels are nested in size; all levels in one document are the levels apart.
    #[test]
    fn levels_keep_the_scene(nodes in nodes(), sizes in prop::array::uniform3(6..16_u32)) {
        prop_assume!(nodes.iter().any(|node| node.mesh.is_some()));
        let input = file(&nodes, sizes);
        let scene = Scene::read_from(&mut &input[..], &ReadOptions::default()).unwrap();
        let steps = SceneSteps { ratios: vec![0.5, 0.25], ..SceneSteps::default() };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let made = scene_levels(&scene, &steps, &SceneRules::default(), go_on).unwrap();
        let mut last = scene.counts()[1];
        let total = last as f64;
        for (level, ratio) in made.levels.iter().zip(steps.ratios) {
            prop_assert_eq!(kept(scene.json()), kept(level.scene.json()));
            let faces = level.scene.counts()[1];
            prop_assert!(faces <= last && faces as f64 <= (ratio * total).ceil(), "{faces} of {total}");
            last = faces;
            // The distance is that between the surfaces as they are drawn, up to scales that differ by axis.
            let found = rms(&drawn(&input), &drawn(&bytes(&level.scene)).mesh);
            prop_assert!(found <= 2.0 * level.rms + 1e-9, "{found} {}", level.rms);
        }
        let (together, _) = made.together().unwrap();
        let json = together.json();
        let meshes = scene.mesh_count();
        prop_assert_eq!(together.mesh_count(), 3 * meshes);
        for node in 0..nodes.len() {
            let [old, new] = [scene.json(), json].map(|json| &json["nodes"][node]);
            let ids = new.pointer("/extensions/MSFT_lod/ids");
            let Some(mesh) = old.get("mesh").and_then(Value::as_u64) else {
                prop_assert!(ids.is_none() && old == new);
                continue;
            };
            // A node with children has the levels in a node below it.
            let top = if old.get("children").is_some() {
                &json["nodes"][new["children"][0].as_u64().unwrap() as usize]
            } else {
                new
            };
            prop_assert_eq!(&top["mesh"], &old["mesh"]);
            let ids = top["extensions"]["MSFT_lod"]["ids"].as_array().unwrap();
            prop_assert_eq!(top["extras"]["MSFT_screencoverage"].as_array().unwrap().len(), 3);
            for (level, id) in ids.iter().enumerate() {
                let other = &json["nodes"][id.as_u64().unwrap() as usize];
                let place = other["mesh"].as_u64().unwrap() as usize;
                prop_assert_eq!(
                    together.mesh_counts(place),
                    made.levels[level].scene.mesh_counts(mesh as usize)
                );
                for name in ["translation", "rotation", "scale"] {
                    prop_assert_eq!(&other[name], &top[name]);
                }
            }
        }
        // What is drawn is the input.
        let (found, expected) = (drawn(&bytes(&together)), drawn(&input));
        prop_assert_eq!(found.mesh.positions(), expected.mesh.positions());
    }
}
