//! The places of a document that hold indices of accessors, views of buffers, and buffers.

use super::document::list_mut;
use serde_json::{Map, Value};

/// A list of the document that other parts refer to by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    Accessor,
    View,
    Buffer,
}

impl Target {
    /// The name of the list.
    pub(super) fn list(self) -> &'static str {
        match self {
            Self::Accessor => "accessors",
            Self::View => "bufferViews",
            Self::Buffer => "buffers",
        }
    }
}

/// The extensions of a view that say where its compressed bytes are.
pub(super) const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Calls `visit` with every index of a list.
pub(super) fn each_reference(json: &mut Value, target: Target, visit: &mut dyn FnMut(&mut Value)) {
    match target {
        Target::Accessor => {
            for primitive in
                list_mut(json, "meshes").iter_mut().flat_map(|mesh| list_mut(mesh, "primitives"))
            {
                each_of_primitive(primitive, visit);
            }
            for skin in list_mut(json, "skins") {
                one(skin.get_mut("inverseBindMatrices"), visit);
            }
            for sampler in
                list_mut(json, "animations").iter_mut().flat_map(|a| list_mut(a, "samplers"))
            {
                ["input", "output"].iter().for_each(|&name| one(sampler.get_mut(name), visit));
            }
            for node in list_mut(json, "nodes") {
                let pointer = "/extensions/EXT_mesh_gpu_instancing/attributes";
                each_member(node.pointer_mut(pointer), visit);
            }
        }
        Target::View => {
            for accessor in list_mut(json, "accessors") {
                one(accessor.get_mut("bufferView"), visit);
                one(accessor.pointer_mut("/sparse/indices/bufferView"), visit);
                one(accessor.pointer_mut("/sparse/values/bufferView"), visit);
            }
            for image in list_mut(json, "images") {
                one(image.get_mut("bufferView"), visit);
            }
            for primitive in
                list_mut(json, "meshes").iter_mut().flat_map(|mesh| list_mut(mesh, "primitives"))
            {
                one(
                    primitive.pointer_mut("/extensions/KHR_draco_mesh_compression/bufferView"),
                    visit,
                );
            }
        }
        Target::Buffer => {
            for view in list_mut(json, "bufferViews") {
                each_range(view, &mut |range| one(range.get_mut("buffer"), visit));
            }
        }
    }
}

/// Calls `visit` with every object of a view that names a part of a buffer: the view itself, and its compressed form.
pub(super) fn each_range(view: &mut Value, visit: &mut dyn FnMut(&mut Map<String, Value>)) {
    if let Some(own) = view.as_object_mut() {
        visit(own);
    }
    for name in MESHOPT {
        let compressed = view.pointer_mut(&format!("/extensions/{name}"));
        if let Some(compressed) = compressed.and_then(Value::as_object_mut) {
            visit(compressed);
        }
    }
}

fn each_of_primitive(primitive: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    each_member(primitive.get_mut("attributes"), visit);
    one(primitive.get_mut("indices"), visit);
    for target in list_mut(primitive, "targets") {
        each_member(Some(target), visit);
    }
}

fn each_member(object: Option<&mut Value>, visit: &mut dyn FnMut(&mut Value)) {
    let members = object.and_then(Value::as_object_mut);
    members.into_iter().flat_map(|members| members.values_mut()).for_each(visit);
}

fn one(index: Option<&mut Value>, visit: &mut dyn FnMut(&mut Value)) {
    if let Some(index) = index {
        visit(index);
    }
}

/// The indices of a list that the document refers to, each marked.
pub(super) fn referenced(json: &mut Value, target: Target) -> Vec<bool> {
    let mut marks = vec![false; list_mut(json, target.list()).len()];
    each_reference(json, target, &mut |index| {
        let mark = index.as_u64().and_then(|index| marks.get_mut(index as usize));
        if let Some(mark) = mark {
            *mark = true;
        }
    });
    marks
}
