//! Replaces the vertices and triangles of meshes.

use super::document::{Scene, list_mut, push_all, root_of};
use super::extensions::{occurs, remove_unknown, unknown};
use super::prune::{Referenced, prune};
use super::vertex_data::VertexData;
use crate::error::WriteError;
use crate::gltf::accessor::{Bytes, Document};
use crate::gltf::plan::path_of;
use crate::lost::Lost;
use crate::text::quote;
use mesh_core::as_u32;
use serde_json::{Map, Value, json};
use std::collections::HashMap;
use std::sync::Arc;

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const TRIANGLES: u32 = 4;

/// New vertices and triangles for primitives of a mesh.
#[derive(Clone, Debug, Default)]
pub struct NewMesh {
    /// The mesh.
    pub mesh: usize,
    /// The primitives that change. Others stay as they are.
    pub primitives: Vec<NewPrimitive>,
}

/// New vertices and triangles of a primitive.
#[derive(Clone, Debug, Default)]
pub struct NewPrimitive {
    /// The index in the mesh.
    pub index: usize,
    /// The attributes of the vertices, with the same number of values each. `POSITION` is one of them.
    pub attributes: Vec<VertexData>,
    /// The morph targets, as many as the other primitives of the mesh have.
    pub targets: Vec<Vec<VertexData>>,
    /// The vertices of each triangle. A primitive without triangles is removed from its mesh.
    pub triangles: Vec<[u32; 3]>,
}

impl Scene {
    /// The scene with other vertices and triangles; everything else is as it was. Accessors, views and bytes that only
    /// the old vertices used are dropped, unless the document has unknown extensions that may refer to them.
    ///
    /// Also returns what is lost: unknown extensions of the changed meshes that hold whole numbers, which may be
    /// indices of vertices.
    ///
    /// # Errors
    /// There is no such mesh or primitive, the new data do not fit each other, a mesh would be left without primitives,
    /// or the document requires an extension that would be lost.
    pub fn replaced(&self, meshes: &[NewMesh]) -> Result<(Self, Vec<Lost>), WriteError> {
        let mut json = self.json.clone();
        let mut edit = Edit::new(self);
        for new in meshes {
            edit.mesh(&mut json, new)?;
        }
        edit.finish(self, json)
    }

    /// Refuses the loss of an extension without which the document must not be read.
    fn check_required(&self, lost: &[(Lost, String)]) -> Result<(), WriteError> {
        let required = &self.root().extensions_required;
        let is_required = |name: &String| required.iter().any(|other| other.as_ref() == name);
        match lost.iter().find(|(_, name)| is_required(name)) {
            Some((lost, _)) => Err(WriteError::Scene(format!(
                "{}: the document requires it, and it may refer to vertices that change; export the file without it",
                lost.what
            ))),
            None => Ok(()),
        }
    }
}

/// New parts of a document.
pub(super) struct Edit {
    /// The index of the new buffer.
    buffer: usize,
    /// The number of views of the document.
    views: usize,
    /// All accessors, old and new.
    accessors: Vec<Value>,
    new_views: Vec<Value>,
    bytes: Vec<u8>,
    /// Lost extensions, with their names.
    lost: Vec<(Lost, String)>,
}

impl Edit {
    pub(super) fn new(scene: &Scene) -> Self {
        let list = |name: &str| scene.json.get(name).and_then(Value::as_array);
        Self {
            buffer: scene.document.buffers.len(),
            views: list("bufferViews").map_or(0, Vec::len),
            accessors: list("accessors").cloned().unwrap_or_default(),
            new_views: Vec::new(),
            bytes: Vec::new(),
            lost: Vec::new(),
        }
    }

    /// The scene with the changed document and the new parts, and what is lost.
    pub(super) fn finish(
        self,
        scene: &Scene,
        mut json: Value,
    ) -> Result<(Scene, Vec<Lost>), WriteError> {
        let Self { accessors, new_views, bytes, lost, .. } = self;
        scene.check_required(&lost)?;
        let before = Referenced::of(&mut scene.json.clone());
        let mut buffers = scene.document.buffers.clone();
        if !bytes.is_empty() {
            push_all(&mut json, "buffers", [json!({ "byteLength": bytes.len() })]);
            push_all(&mut json, "bufferViews", new_views);
            if let Some(document) = json.as_object_mut() {
                document.insert("accessors".to_owned(), accessors.into());
            }
            buffers.push(Bytes { length: bytes.len(), all: Arc::new(bytes) });
        }
        if unknown(&json).is_empty() {
            prune(&mut json, &mut buffers, &before);
        }
        drop_unused_names(&mut json, &scene.json);
        let root = root_of(&json).map_err(|error| WriteError::Scene(error.to_string()))?;
        let lost = lost.into_iter().map(|(lost, _)| lost).collect();
        Ok((scene.with(json, Document { root, buffers }), lost))
    }

    pub(super) fn mesh(&mut self, json: &mut Value, new: &NewMesh) -> Result<(), WriteError> {
        let index = new.mesh;
        let mesh = list_mut(json, "meshes").get_mut(index);
        let mesh = mesh.ok_or_else(|| WriteError::Scene(format!("there is no mesh {index}")))?;
        for primitive in &new.primitives {
            let path = path_of(as_u32(index), primitive.index);
            let object = list_mut(mesh, "primitives").get_mut(primitive.index);
            let object = object.ok_or_else(|| WriteError::Scene(format!("there is no {path}")))?;
            if !primitive.triangles.is_empty() {
                self.primitive(object, primitive, &path)?;
            }
        }
        let removed = |place: usize| {
            new.primitives.iter().any(|p| p.index == place && p.triangles.is_empty())
        };
        if let Some(primitives) = mesh.get_mut("primitives").and_then(Value::as_array_mut) {
            let mut place = 0;
            primitives.retain(|_| {
                place += 1;
                !removed(place - 1)
            });
            if primitives.is_empty() {
                let message =
                    format!("meshes[{index}] would have no primitive left; keep a triangle");
                return Err(WriteError::Scene(message));
            }
        }
        self.lose(mesh, &format!("meshes[{index}]"));
        Ok(())
    }

    fn primitive(
        &mut self,
        object: &mut Value,
        new: &NewPrimitive,
        path: &str,
    ) -> Result<(), WriteError> {
        let count = check(new, path)?;
        let old = object.get("attributes").cloned().unwrap_or_default();
        let attributes = self.accessors_of(&new.attributes, &old, false);
        let old_targets = list_mut(object, "targets").to_vec();
        let mut old_targets = old_targets.into_iter();
        let target = |target: &Vec<VertexData>| {
            Value::from(self.accessors_of(target, &old_targets.next().unwrap_or_default(), true))
        };
        let targets: Vec<Value> = new.targets.iter().map(target).collect();
        let indices = self.indices(&new.triangles, count);
        let Some(members) = object.as_object_mut() else { return Ok(()) };
        members.insert("attributes".to_owned(), attributes.into());
        members.insert("indices".to_owned(), indices.into());
        if targets.is_empty() {
            members.remove("targets");
        } else {
            members.insert("targets".to_owned(), targets.into());
        }
        if members.contains_key("mode") {
            members.insert("mode".to_owned(), TRIANGLES.into());
        }
        if let Some(extensions) = members.get_mut("extensions").and_then(Value::as_object_mut) {
            extensions.remove("KHR_draco_mesh_compression");
        }
        self.lose(object, path);
        Ok(())
    }

    /// Removes what may refer to vertices that change.
    fn lose(&mut self, object: &mut Value, path: &str) {
        for name in remove_unknown(object) {
            let what = format!("{path}: extension {}", quote(name.as_bytes()));
            let why = "it holds whole numbers, which may be indices of vertices that change";
            self.lost.push((Lost::new(what, why), name));
        }
        // An object of extensions must not be empty.
        if let Some(members) = object.as_object_mut()
            && members.get("extensions").and_then(Value::as_object).is_some_and(Map::is_empty)
        {
            members.remove("extensions");
        }
    }

    /// New accessors for attributes, with the names and the data of programs of the old ones. Changes of a morph target
    /// that are mostly zero are written as the others only.
    fn accessors_of(
        &mut self,
        all: &[VertexData],
        old: &Value,
        are_changes: bool,
    ) -> Map<String, Value> {
        let accessor = |data: &VertexData| {
            let old = old.get(&data.name).and_then(Value::as_u64);
            let old = old.and_then(|index| self.accessors.get(index as usize)).cloned();
            (data.name.clone(), self.attribute(data, old.as_ref(), are_changes).into())
        };
        all.iter().map(accessor).collect()
    }

    /// Appends values to the buffer, and returns their accessor.
    fn attribute(&mut self, data: &VertexData, old: Option<&Value>, are_changes: bool) -> usize {
        let is_other = |&vertex: &usize| data.value(vertex).iter().any(|&byte| byte != 0);
        let count = data.count();
        let others: Vec<usize> = (0..count).filter(is_other).collect();
        let mut accessor =
            json!({ "componentType": data.code(), "count": count, "type": data.shape() });
        let padded = data.size().next_multiple_of(4);
        if are_changes
            && !others.is_empty()
            && others.len() * (data.size() + 4) < count * padded / 2
        {
            accessor["sparse"] = self.sparse(data, &others);
        } else {
            let start = self.bytes.len();
            for vertex in 0..count {
                self.bytes.extend_from_slice(data.value(vertex));
                self.bytes.resize(self.bytes.len() + padded - data.size(), 0);
            }
            let stride = (padded != data.size()).then_some(padded);
            accessor["bufferView"] = self.view(start, Some(ARRAY_BUFFER), stride).into();
        }
        if data.normalized {
            accessor["normalized"] = true.into();
        }
        let has_bounds =
            old.is_some_and(|old| old.get("min").is_some() || old.get("max").is_some());
        if let Some([least, most]) = data.bounds()
            && (has_bounds || data.name == "POSITION")
        {
            accessor["min"] = numbers(&least, data);
            accessor["max"] = numbers(&most, data);
        }
        for name in ["name", "extras"] {
            if let Some(value) = old.and_then(|old| old.get(name)) {
                accessor[name] = value.clone();
            }
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Appends the values of some vertices, and returns their description.
    fn sparse(&mut self, data: &VertexData, vertices: &[usize]) -> Value {
        let start = self.bytes.len();
        for &vertex in vertices {
            self.bytes.extend(as_u32(vertex).to_le_bytes());
        }
        let indices = self.view(start, None, None);
        let start = self.bytes.len();
        for &vertex in vertices {
            self.bytes.extend_from_slice(data.value(vertex));
        }
        let values = self.view(start, None, None);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        json!({
            "count": vertices.len(), "indices": { "bufferView": indices, "componentType": UNSIGNED_INT },
            "values": { "bufferView": values },
        })
    }

    fn indices(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        let (start, corners) = (self.bytes.len(), triangles.as_flattened());
        // The largest number of each type has another meaning.
        let is_short = vertices <= usize::from(u16::MAX);
        for &corner in corners {
            match u16::try_from(corner) {
                Ok(corner) if is_short => self.bytes.extend(corner.to_le_bytes()),
                _ => self.bytes.extend(corner.to_le_bytes()),
            }
        }
        let view = self.view(start, Some(ELEMENT_ARRAY_BUFFER), None);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let kind = if is_short { UNSIGNED_SHORT } else { UNSIGNED_INT };
        self.accessors.push(json!({
            "bufferView": view, "componentType": kind, "count": corners.len(), "type": "SCALAR",
        }));
        self.accessors.len() - 1
    }

    /// A view of the buffer from `start` to its end.
    fn view(&mut self, start: usize, target: Option<u32>, stride: Option<usize>) -> usize {
        let length = self.bytes.len() - start;
        let mut view = json!({ "buffer": self.buffer, "byteOffset": start, "byteLength": length });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        if let Some(stride) = stride {
            view["byteStride"] = stride.into();
        }
        self.new_views.push(view);
        self.views + self.new_views.len() - 1
    }
}

/// Checks that the data fit each other, and returns the number of vertices.
fn check(new: &NewPrimitive, path: &str) -> Result<usize, WriteError> {
    let error = |message: String| Err(WriteError::Scene(format!("{path}: {message}")));
    let Some(positions) = new.attributes.iter().find(|data| data.name == "POSITION") else {
        return error("the new vertices have no positions".to_owned());
    };
    let count = positions.count();
    for data in new.attributes.iter().chain(new.targets.iter().flatten()) {
        if data.count() != count || data.bytes.len() != count * data.size() {
            let (name, found) = (&data.name, data.count());
            return error(format!("{name} has {found} values for {count} vertices"));
        }
    }
    match new.triangles.as_flattened().iter().find(|&&vertex| vertex as usize >= count) {
        Some(vertex) => error(format!("a triangle has vertex {vertex}, but there are {count}")),
        None => Ok(count),
    }
}

/// Numbers as the type of the data: integers without a fraction.
fn numbers(values: &[f64], data: &VertexData) -> Value {
    let number = |&value: &f64| {
        if data.component.is_integer() { Value::from(value as i64) } else { Value::from(value) }
    };
    values.iter().map(number).collect()
}

/// Removes the names of extensions that occurred before and do not any more.
pub(super) fn drop_unused_names(json: &mut Value, before: &Value) {
    let mut names: HashMap<String, bool> = HashMap::new();
    for list in ["extensionsUsed", "extensionsRequired"] {
        let mut stays = |name: &Value| {
            let Some(name) = name.as_str() else { return true };
            let gone = || occurs(before, name) && !occurs(json, name);
            !*names.entry(name.to_owned()).or_insert_with(gone)
        };
        let Some(all) = json.get(list).and_then(Value::as_array) else { continue };
        let kept: Vec<Value> = all.iter().filter(|name| stays(name)).cloned().collect();
        let Some(document) = json.as_object_mut() else { return };
        if kept.is_empty() {
            document.remove(list);
        } else {
            document.insert(list.to_owned(), kept.into());
        }
    }
}
