//! Which extensions hold indices into the parts of a document that can change.

use serde_json::Value;
use std::collections::BTreeSet;

/// Extensions that hold no indices of accessors, views or buffers besides the [known
/// places](super::references), and none of vertices or triangles.
const KNOWN: [&str; 21] = [
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_texture_basisu",
    "KHR_lights_punctual",
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
    "KHR_xmp_json_ld",
    "KHR_xmp",
    "KHR_node_visibility",
    "KHR_node_selectability",
    "KHR_node_hoverability",
    "KHR_animation_pointer",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "EXT_texture_avif",
    "EXT_lights_image_based",
    "EXT_mesh_features",
    "EXT_instance_features",
    "MSFT_lod",
    "MSFT_texture_dds",
];

/// Extensions that hold indices of views, and none of vertices or triangles.
const WITHOUT_VERTICES: [&str; 1] = ["EXT_structural_metadata"];

/// Whether an extension stays true when the triangles and vertices of a mesh change.
pub(super) fn is_known(name: &str) -> bool {
    name.starts_with("KHR_materials_") || KNOWN.contains(&name)
}

/// Whether a value holds a whole number, which can be an index. The data of programs (`extras`) are none of the format.
fn has_index(value: &Value) -> bool {
    match value {
        Value::Number(number) => number.is_u64(),
        Value::Array(items) => items.iter().any(has_index),
        Value::Object(members) => {
            members.iter().any(|(name, member)| name != "extras" && has_index(member))
        }
        _ => false,
    }
}

/// The names of unknown extensions with whole numbers anywhere in the document. What these refer to must keep its
/// index.
pub(super) fn unknown(json: &Value) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    each_extension(json, &mut |name, value| {
        if !is_known(name) && has_index(value) {
            names.insert(name.to_owned());
        }
    });
    names
}

/// Whether an extension occurs anywhere in the document.
pub(super) fn occurs(json: &Value, wanted: &str) -> bool {
    let mut found = false;
    each_extension(json, &mut |name, _| found |= name == wanted);
    found
}

/// Removes the unknown extensions with whole numbers from an object of the document, and returns their names.
pub(super) fn remove_unknown(object: &mut Value) -> Vec<String> {
    let Some(extensions) = object.get_mut("extensions").and_then(Value::as_object_mut) else {
        return Vec::new();
    };
    let mut removed = Vec::new();
    extensions.retain(|name, value| {
        let is_harmless = is_known(name) || WITHOUT_VERTICES.contains(&name.as_str());
        let stays = is_harmless || !has_index(value);
        if !stays {
            removed.push(name.clone());
        }
        stays
    });
    removed
}

/// Calls `visit` with the name and the content of every extension, also of extensions inside others. The data of
/// programs (`extras`) have none.
fn each_extension(value: &Value, visit: &mut dyn FnMut(&str, &Value)) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| each_extension(item, visit)),
        Value::Object(members) => {
            for (name, member) in members.iter().filter(|(name, _)| *name != "extras") {
                if let ("extensions", Some(extensions)) = (name.as_str(), member.as_object()) {
                    extensions.iter().for_each(|(name, content)| visit(name, content));
                }
                each_extension(member, visit);
            }
        }
        _ => {}
    }
}
