//! Levels of detail of a scene in one document (`MSFT_lod`).

use super::document::{Scene, list_mut, push};
use super::extensions::occurs;
use super::replace::{Edit, NewMesh};
use crate::error::WriteError;
use crate::lost::Lost;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// The members of a node that belong to the mesh that it draws.
const OF_MESH: [&str; 3] = ["mesh", "skin", "weights"];
/// The members of a node that place it.
const OF_PLACE: [&str; 4] = ["matrix", "translation", "rotation", "scale"];
const INSTANCING: &str = "EXT_mesh_gpu_instancing";

impl Scene {
    /// The scene with coarser levels of its meshes, as alternatives of the nodes that draw them (`MSFT_lod`). `levels`
    /// are the new meshes of each level, from fine to coarse. `coverage` is, for each mesh, the part of the screen that
    /// it must cover for the original and each level to be shown.
    ///
    /// Where a node has children, a camera, an animation or other extensions, a new node below it draws the mesh, so
    /// that these stay whatever level is shown. Also returns what the levels lose, as [`Scene::replaced`].
    ///
    /// # Errors
    /// As [`Scene::replaced`]; the scene has levels already, or animations point into nodes.
    pub fn with_levels(
        &self,
        levels: &[Vec<NewMesh>],
        coverage: &BTreeMap<usize, Vec<f64>>,
    ) -> Result<(Self, Vec<Lost>), WriteError> {
        for (name, why) in [
            ("MSFT_lod", "the scene has levels already"),
            ("KHR_animation_pointer", "animations point into nodes that get levels"),
        ] {
            if occurs(&self.json, name) {
                let cure = "write each level to a file of its own";
                return Err(WriteError::Scene(format!("extension {name}: {why}; {cure}")));
            }
        }
        let mut edit = Edit::new(self);
        let mut json = self.json.clone();
        let mut copies: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for new in levels.iter().flatten() {
            let original = list_mut(&mut json, "meshes").get(new.mesh).cloned();
            let Some(original) = original else {
                return Err(WriteError::Scene(format!("there is no mesh {}", new.mesh)));
            };
            let copy = push(&mut json, "meshes", original);
            edit.mesh(&mut json, &NewMesh { mesh: copy, primitives: new.primitives.clone() })?;
            copies.entry(new.mesh).or_default().push(copy);
        }
        let animated = animated(&mut json);
        let count = list_mut(&mut json, "nodes").len();
        let mut followers: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for node in 0..count {
            let mesh = list_mut(&mut json, "nodes").get(node).and_then(|node| node.get("mesh"));
            let mesh = mesh.and_then(Value::as_u64).map(|mesh| mesh as usize);
            let Some(copies) = mesh.and_then(|mesh| copies.get(&mesh)) else { continue };
            let shown = mesh.and_then(|mesh| coverage.get(&mesh)).cloned().unwrap_or_default();
            let is_animated = animated.get(node).copied().unwrap_or(false);
            let drawing = add_levels(&mut json, node, is_animated, copies, &shown);
            followers.insert(node, drawing);
        }
        follow_weights(&mut json, &followers);
        let used = json.as_object_mut().map(|document| {
            document.entry("extensionsUsed").or_insert_with(|| Value::Array(Vec::new()))
        });
        if let (Some(used), false) = (used.and_then(Value::as_array_mut), followers.is_empty()) {
            used.push("MSFT_lod".into());
        }
        edit.finish(self, json)
    }
}

/// Whether an animation moves each node.
fn animated(json: &mut Value) -> Vec<bool> {
    let mut is_animated = vec![false; list_mut(json, "nodes").len()];
    for animation in list_mut(json, "animations") {
        for channel in list_mut(animation, "channels") {
            let node = channel.pointer("/target/node").and_then(Value::as_u64);
            if let Some(slot) = node.and_then(|node| is_animated.get_mut(node as usize)) {
                *slot = true;
            }
        }
    }
    is_animated
}

/// Adds the levels of the mesh of a node, and returns the nodes that draw them and the original.
fn add_levels(
    json: &mut Value,
    node: usize,
    is_animated: bool,
    copies: &[usize],
    coverage: &[f64],
) -> Vec<usize> {
    let Some(object) = list_mut(json, "nodes").get_mut(node).and_then(Value::as_object_mut) else {
        return Vec::new();
    };
    let instances = object.get("extensions").and_then(|all| all.get(INSTANCING)).cloned();
    let extensions = object.get("extensions").and_then(Value::as_object).map_or(0, Map::len);
    let is_plain = !is_animated
        && !object.contains_key("children")
        && !object.contains_key("camera")
        && extensions == usize::from(instances.is_some())
        && object.get("extras").is_none_or(Value::is_object);
    let mut level = Map::new();
    let kept: &[&str] = if is_plain { &OF_PLACE } else { &[] };
    for name in OF_MESH.iter().chain(kept).chain(&["name"]) {
        if let Some(value) = object.get(*name) {
            level.insert((*name).to_owned(), value.clone());
        }
    }
    if let Some(instances) = &instances {
        level.insert("extensions".to_owned(), json!({ INSTANCING: instances }));
    }
    if !is_plain {
        OF_MESH.iter().for_each(|name| drop(object.remove(*name)));
        if let Some(all) = object.get_mut("extensions").and_then(Value::as_object_mut) {
            all.remove(INSTANCING);
            if all.is_empty() {
                object.remove("extensions");
            }
        }
    }
    let ids: Vec<usize> = copies
        .iter()
        .map(|&mesh| {
            let mut level = level.clone();
            level.insert("mesh".to_owned(), mesh.into());
            push(json, "nodes", level.into())
        })
        .collect();
    let top = if is_plain { node } else { push(json, "nodes", level.into()) };
    let nodes = list_mut(json, "nodes");
    if let Some(drawing) = nodes.get_mut(top) {
        drawing["extensions"]["MSFT_lod"] = json!({ "ids": ids });
        drawing["extras"]["MSFT_screencoverage"] = json!(coverage);
    }
    if let (Some(object), false) = (nodes.get_mut(node).and_then(Value::as_object_mut), is_plain) {
        let children = object.entry("children").or_insert_with(|| Value::Array(Vec::new()));
        if let Some(children) = children.as_array_mut() {
            // Before the others, so that meshes are drawn in the same order.
            children.insert(0, top.into());
        }
    }
    let mut all = vec![top];
    all.extend(ids);
    all
}

/// Animations of the weights of morph targets are those of all levels.
fn follow_weights(json: &mut Value, followers: &BTreeMap<usize, Vec<usize>>) {
    for animation in list_mut(json, "animations") {
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else {
            continue;
        };
        let old = std::mem::take(channels);
        for channel in old {
            let path = channel.pointer("/target/path").and_then(Value::as_str);
            let node = channel.pointer("/target/node").and_then(Value::as_u64);
            let drawing = node.and_then(|node| followers.get(&(node as usize)));
            match drawing.filter(|_| path == Some("weights")) {
                Some(drawing) => channels.extend(drawing.iter().map(|&node| {
                    let mut channel = channel.clone();
                    channel["target"]["node"] = node.into();
                    channel
                })),
                None => channels.push(channel),
            }
        }
    }
}
