//! Content of a document that a model cannot hold.

use super::schema::{Node, Root};
use crate::notes::Notes;
use crate::text::quote;

const NO_SCENE: &str = "a model is one mesh in world coordinates, without a scene around it";
const REST_POSE: &str = "the mesh is read in its rest pose";

/// Extensions that are read, or whose content is reported separately.
const READ: [&str; 10] = [
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_lights_punctual",
    "KHR_materials_pbrSpecularGlossiness",
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_texture_basisu",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_draco_mesh_compression",
];

/// Notes everything in the document that the model cannot hold.
pub(super) fn note(root: &Root, notes: &mut Notes) {
    let lights = root.extensions.lights.as_ref().map_or(0, |lights| lights.lights.len());
    notes.lose_some("animations", root.animations.len() as u64, REST_POSE);
    notes.lose_some("skins", root.skins.len() as u64, REST_POSE);
    notes.lose_some("cameras", root.cameras.len() as u64, NO_SCENE);
    notes.lose_some("lights", lights as u64, NO_SCENE);
    let is_moved = |node: &&Node| {
        !node.children.is_empty()
            || node.matrix.is_some()
            || node.translation.is_some()
            || node.rotation.is_some()
            || node.scale.is_some()
    };
    if root.nodes.iter().any(|node| is_moved(&node)) {
        notes.lose_some("node hierarchy and transforms", root.nodes.len() as u64, NO_SCENE);
    }
    let names = root.nodes.iter().filter(|node| node.mesh.is_none() && node.name.is_some());
    notes.lose_some("names of nodes without a mesh", names.count() as u64, NO_SCENE);
    let scenes = root.scenes.len().saturating_sub(1) as u64;
    notes.lose_some("scenes besides the one that is read", scenes, "a model is one scene");
    drawn(root, notes);
    extras(root, notes);
    attributes(root, notes);
    notes.lose_some("texture samplers", root.samplers.len() as u64, "textures repeat");
    for name in root.extensions_used.iter().filter(|name| !READ.contains(&name.as_ref())) {
        let what = format!("extension {}", quote(name.as_bytes()));
        notes.lose_some(what, 1, "it is not read; the mesh is read without it");
    }
}

/// Meshes that no node draws, and that several nodes draw.
fn drawn(root: &Root, notes: &mut Notes) {
    let mut times = vec![0_u64; root.meshes.len()];
    for mesh in root.nodes.iter().filter_map(|node| node.mesh) {
        if let Some(times) = times.get_mut(mesh as usize) {
            *times += 1;
        }
    }
    let unused = times.iter().filter(|&&times| times == 0).count() as u64;
    notes.lose_some("meshes that no node draws", unused, NO_SCENE);
    let shared = times.iter().filter(|&&times| times > 1).count() as u64;
    notes.lose_some("meshes that nodes share", shared, "each node gets a copy");
}

fn extras(root: &Root, notes: &mut Notes) {
    let of_nodes = root.nodes.iter().map(|node| node.extras);
    let of_meshes = root.meshes.iter().map(|mesh| mesh.extras);
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let of_primitives = primitives.map(|primitive| primitive.extras);
    let of_materials = root.materials.iter().map(|material| material.extras);
    let of_scenes = root.scenes.iter().map(|scene| scene.extras);
    let all = of_nodes.chain(of_meshes).chain(of_primitives).chain(of_materials).chain(of_scenes);
    let count = all.chain([root.extras]).filter(|&there| there).count() as u64;
    notes.lose_some("extras", count, "a model has no place for data of programs");
}

/// Attributes of vertices that are not read, each with the number of its primitives.
fn attributes(root: &Root, notes: &mut Notes) {
    let mut counts = std::collections::BTreeMap::<&str, u64>::new();
    let mut targets = 0;
    for primitive in root.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        targets += u64::from(!primitive.targets.is_empty());
        for (name, accessor) in primitive.attributes.iter() {
            let is_read = match name {
                "POSITION" | "NORMAL" | "COLOR_0" => true,
                _ if name.starts_with("TEXCOORD_") => true,
                _ if name.starts_with('_') => {
                    let accessor = root.accessors.get(accessor as usize);
                    accessor.is_none_or(|accessor| accessor.shape.is_scalar())
                }
                _ => false,
            };
            if !is_read {
                *counts.entry(name).or_insert(0) += 1;
            }
        }
    }
    notes.lose_some("morph targets", targets, REST_POSE);
    for (name, count) in counts {
        let (what, why) = match name {
            "TANGENT" => ("tangents", "renderers make them from normals and texture coordinates"),
            _ if name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_") => {
                ("joints and weights of skins", REST_POSE)
            }
            _ if name.starts_with("COLOR_") => ("further sets of colours", "a model has one set"),
            _ => {
                let what = format!("attribute {} of primitives", quote(name.as_bytes()));
                notes.lose_some(what, count, "only numbers with one component are read");
                continue;
            }
        };
        notes.lose_some(what, count, why);
    }
}
