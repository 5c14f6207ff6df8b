//! Compresses the views of a scene (`EXT_meshopt_compression`).

use super::document::{Scene, list_mut, push_all, root_of};
use super::extensions::unknown;
use super::prune::{cut_ranges, drop_buffers, push_part};
use super::references::{Target, referenced};
use crate::error::{ReadErrorKind, WriteError};
use crate::gltf::accessor::{Bytes, Document};
use crate::gltf::schema::Root;
use crate::meshopt::filters::Filter;
use crate::meshopt::{Mode, encode};
use mesh_core::as_u32;
use serde_json::{Value, json};
use std::ops::Range;
use std::sync::Arc;

/// Every program that reads compressed files reads this extension, and version 0 of the streams.
const EXTENSION: &str = "EXT_meshopt_compression";
/// Streams and views start at multiples of this many bytes.
const ALIGNMENT: usize = 4;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const TRIANGLES: u32 = 4;

impl Scene {
    /// The scene in a smaller form, with the same values: `EXT_meshopt_compression`, which readers of the file must
    /// know.
    ///
    /// Triangles and vertices get an order that vertex caches and compression like, unless anything may depend on the
    /// order. A triangle may start with another of its corners. Images, and what does not get smaller, stay as they
    /// are.
    ///
    /// # Errors
    /// A [`WriteError`]: data compressed in another way cannot be read.
    pub fn compressed(&self) -> Result<Self, WriteError> {
        self.reordered()?.with_compressed_views()
    }

    fn with_compressed_views(&self) -> Result<Self, WriteError> {
        let document = &*self.document;
        let mut json = self.json.clone();
        let before = referenced(&mut json, Target::Buffer);
        let mut streams = Streams { bytes: Vec::new(), length: 0, gone: Vec::new() };
        streams.gone.resize(document.buffers.len(), Vec::new());
        // Compressed bytes go to the first buffer that holds any, so that a GLB file has no other one.
        let is_filled = |buffer: &Bytes| !buffer.get().is_empty();
        let target = document.buffers.iter().position(is_filled).unwrap_or_default();
        let fallback = document.buffers.len();
        let uses = uses(document).map_err(|error| WriteError::Scene(error.to_string()))?;
        for (index, (view, usage)) in
            list_mut(&mut json, "bufferViews").iter_mut().zip(uses).enumerate()
        {
            let Some((mode, stride)) = usage.form() else { continue };
            let path = format!("bufferViews[{index}]");
            let Ok((bytes, _)) = document.view(as_u32(index), &path) else { continue };
            streams.add(view, bytes, mode, stride, fallback);
        }
        if streams.bytes.is_empty() {
            return Ok(self.clone());
        }
        let mut buffers = document.buffers.clone();
        cut_ranges(&mut json, &mut buffers, streams.gone, &[]);
        let Some(buffer) = buffers.get_mut(target) else { return Ok(self.clone()) };
        let mut bytes = buffer.get().to_vec();
        bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
        let start = bytes.len();
        bytes.extend(streams.bytes);
        for view in list_mut(&mut json, "bufferViews") {
            let extension = view.pointer_mut(&format!("/extensions/{EXTENSION}"));
            if let Some(extension) =
                extension.filter(|extension| extension["buffer"] == json!(fallback))
            {
                let offset = extension["byteOffset"].as_u64().unwrap_or_default();
                extension["byteOffset"] = (start as u64 + offset).into();
                extension["buffer"] = target.into();
            }
        }
        if let Some(object) = list_mut(&mut json, "buffers").get_mut(target) {
            object["byteLength"] = bytes.len().into();
        }
        *buffer = Bytes { length: bytes.len(), all: Arc::new(bytes) };
        let mark = json!({ "byteLength": streams.length, "extensions": { EXTENSION: { "fallback": true } } });
        push_all(&mut json, "buffers", [mark]);
        buffers.push(Bytes::default());
        if unknown(&json).is_empty() {
            drop_buffers(&mut json, &mut buffers, &before);
        }
        for list in ["extensionsUsed", "extensionsRequired"] {
            let names = json.get(list).and_then(Value::as_array);
            if !names.is_some_and(|names| names.contains(&json!(EXTENSION))) {
                push_all(&mut json, list, [json!(EXTENSION)]);
            }
        }
        let root = root_of(&json).map_err(|error| WriteError::Scene(error.to_string()))?;
        Ok(self.with(json, Document { root, buffers }))
    }
}

/// The streams of all compressed views.
struct Streams {
    bytes: Vec<u8>,
    /// The length of the views.
    length: usize,
    /// The parts of the buffers that the views had.
    gone: Vec<Vec<Range<usize>>>,
}

impl Streams {
    /// Compresses a view, if that makes it smaller. The number of the buffer of fallbacks stands for both buffers.
    fn add(&mut self, view: &mut Value, bytes: &[u8], mode: Mode, stride: usize, fallback: usize) {
        let Some(stream) = encode(mode, stride, bytes).filter(|stream| stream.len() < bytes.len())
        else {
            return;
        };
        let Some(members) = view.as_object_mut() else { return };
        push_part(&mut self.gone, members);
        self.bytes.resize(self.bytes.len().next_multiple_of(ALIGNMENT), 0);
        let name = match mode {
            Mode::Attributes(_) => "ATTRIBUTES",
            Mode::Triangles => "TRIANGLES",
            Mode::Indices => "INDICES",
        };
        let extension = json!({
            "buffer": fallback, "byteOffset": self.bytes.len(), "byteLength": stream.len(),
            "byteStride": stride, "count": bytes.len() / stride.max(1), "mode": name,
        });
        members.insert("buffer".to_owned(), fallback.into());
        members.insert("byteOffset".to_owned(), self.length.into());
        self.bytes.extend(stream);
        self.length = (self.length + bytes.len()).next_multiple_of(ALIGNMENT);
        let extensions = members.entry("extensions").or_insert_with(|| json!({}));
        extensions[EXTENSION] = extension;
    }
}

/// What a view is used for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Usage {
    /// Nothing so far.
    Unused,
    Used {
        mode: Mode,
        stride: usize,
    },
    /// Several things, or something that is not compressed.
    Other,
}

impl Usage {
    fn form(self) -> Option<(Mode, usize)> {
        match self {
            Self::Used { mode, stride } => Some((mode, stride)),
            _ => None,
        }
    }

    fn add(&mut self, mode: Mode, stride: usize) {
        *self = match *self {
            Self::Unused => Self::Used { mode, stride },
            Self::Used { mode: before, stride: same } if same == stride && before == mode => return,
            // Lists of triangles are indices too.
            Self::Used { mode: before, stride: same }
                if same == stride && before.is_index() && mode.is_index() =>
            {
                Self::Used { mode: Mode::Indices, stride }
            }
            _ => Self::Other,
        };
    }
}

/// What each view is used for.
fn uses(document: &Document) -> Result<Vec<Usage>, ReadErrorKind> {
    let root = &document.root;
    let mut uses = vec![Usage::Unused; root.buffer_views.len()];
    let mut is_index = vec![None; root.accessors.len()];
    for primitive in root.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let slot = primitive.indices.and_then(|index| is_index.get_mut(index as usize));
        if let Some(slot) = slot {
            let is_list = primitive.mode == TRIANGLES;
            *slot = Some(slot.unwrap_or(true) && is_list);
        }
    }
    let add = |uses: &mut Vec<Usage>, view: u32, form: Option<(Mode, usize)>| {
        let Some(usage) = uses.get_mut(view as usize) else { return };
        match form {
            Some((mode, stride)) => usage.add(mode, stride),
            None => *usage = Usage::Other,
        }
    };
    let values = Mode::Attributes(Filter::None);
    for (index, (accessor, is_list)) in root.accessors.iter().zip(is_index).enumerate() {
        let path = format!("accessors[{index}]");
        let size = document.value_size(accessor, &path)?;
        let form = |view: u32, offset: u64| {
            let stride = stride_of(root, view, size)?;
            match is_list {
                None => Some((values, stride)),
                Some(_) if accessor.component_type == UNSIGNED_BYTE => None,
                Some(is_list) => {
                    let triangle = 3 * size as u64;
                    let is_whole =
                        (offset.is_multiple_of(triangle)) && accessor.count.is_multiple_of(3);
                    let length = root.buffer_views.get(view as usize).map_or(1, |v| v.byte_length);
                    let is_list = is_list && is_whole && length.is_multiple_of(triangle);
                    Some((if is_list { Mode::Triangles } else { Mode::Indices }, size))
                }
            }
        };
        if let Some(view) = accessor.buffer_view {
            add(&mut uses, view, form(view, accessor.byte_offset));
        }
        if let Some(sparse) = &accessor.sparse {
            let indices = match sparse.indices.component_type {
                UNSIGNED_BYTE => None,
                UNSIGNED_SHORT => Some((Mode::Indices, 2)),
                _ => Some((Mode::Indices, 4)),
            };
            add(&mut uses, sparse.indices.buffer_view, indices);
            let view = sparse.values.buffer_view;
            add(&mut uses, view, stride_of(root, view, size).map(|stride| (values, stride)));
        }
    }
    for view in root.images.iter().filter_map(|image| image.buffer_view) {
        add(&mut uses, view, None);
    }
    for (view, usage) in root.buffer_views.iter().zip(&mut uses) {
        if view.extensions.compressed().is_some() {
            *usage = Usage::Other;
        }
    }
    Ok(uses)
}

/// The bytes from one value of a view to the next.
fn stride_of(root: &Root, view: u32, size: usize) -> Option<usize> {
    let view = root.buffer_views.get(view as usize)?;
    Some(view.byte_stride.map_or(size, |stride| stride as usize))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReadOptions;
    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;

    /// Parts of every kind: interleaved vertices, a list with short indices of one byte, lines, an animation, a sparse
    /// morph target, an image, and values that nothing refers to.
    fn scene() -> Scene {
        let (mut bytes, mut views) = (Vec::new(), Vec::new());
        let mut view = |values: Vec<u8>, stride: Option<usize>| {
            bytes.resize(bytes.len() / 4 * 4 + 4, 0);
            let mut view =
                json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": values.len() });
            if let Some(stride) = stride {
                view["byteStride"] = stride.into();
            }
            bytes.extend(values);
            views.push(view);
            views.len() - 1
        };
        let floats = |count: usize, width: usize| -> Vec<u8> {
            let value = |i: usize| (i / width) as f32 * 0.25 + (i % width) as f32;
            (0..count * width).flat_map(|i| value(i).to_le_bytes()).collect()
        };
        let shorts =
            |values: &[u16]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let vertices = view(floats(60, 6), Some(24));
        let fan: Vec<u8> = (1..59).flat_map(|i| [0, i, i + 1]).collect();
        let list = view(fan, None);
        let lines = view(shorts(&(0..60).collect::<Vec<u16>>()), None);
        let (times, moves) = (view(floats(80, 1), None), view(floats(80, 3), None));
        let sparse = view(shorts(&(3..33).collect::<Vec<u16>>()), None);
        let deltas = view(floats(30, 3), None);
        let image = view(vec![7; 200], None);
        let unused = view(floats(50, 2), None);
        let accessor = |view: usize, offset: usize, kind: u32, count: usize, shape: &str| json!({ "bufferView": view, "byteOffset": offset, "componentType": kind, "count": count, "type": shape });
        let target = json!({
            "componentType": 5126, "count": 60, "type": "VEC3", "sparse": {
                "count": 30, "indices": { "bufferView": sparse, "componentType": 5123 }, "values": { "bufferView": deltas },
            },
        });
        let attributes = json!({ "POSITION": 0, "NORMAL": 1 });
        let data = STANDARD.encode(&bytes);
        let document = json!({
            "asset": { "version": "2.0" }, "nodes": [{ "mesh": 0 }], "bufferViews": views,
            "buffers": [{ "byteLength": bytes.len(), "uri": format!("data:;base64,{data}") }],
            "accessors": [
                accessor(vertices, 0, 5126, 60, "VEC3"), accessor(vertices, 12, 5126, 60, "VEC3"),
                accessor(list, 0, 5121, 174, "SCALAR"), accessor(lines, 0, 5123, 60, "SCALAR"),
                accessor(times, 0, 5126, 80, "SCALAR"), accessor(moves, 0, 5126, 80, "VEC3"), target,
                accessor(unused, 0, 5126, 50, "VEC2"),
            ],
            "images": [{ "bufferView": image, "mimeType": "image/png" }],
            "meshes": [{ "primitives": [
                { "attributes": attributes, "indices": 2, "targets": [{ "POSITION": 6 }] },
                { "attributes": attributes, "indices": 3, "mode": 1 },
            ] }],
            "animations": [{ "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
                "samplers": [{ "input": 4, "output": 5 }] }],
        });
        Scene::read_from(&mut document.to_string().as_bytes(), &ReadOptions::default()).unwrap()
    }

    fn values(scene: &Scene) -> Vec<Vec<u8>> {
        let count = scene.document.root.accessors.len();
        let values = |index| scene.document.values(index, "", 1..=16).unwrap().packed().unwrap();
        (0..as_u32(count)).map(values).collect()
    }

    /// Lines forbid another order, so that all values stay where they are.
    #[test]
    fn values_of_all_kinds_stay() {
        let plain = scene();
        let small = plain.compressed().unwrap();
        let mut file = Vec::new();
        small.write_to(&mut file, crate::Format::Glb).unwrap();
        let again = Scene::read_from(&mut &file[..], &ReadOptions::default()).unwrap();
        for scene in [&small, &again] {
            assert_eq!(values(scene), values(&plain));
            assert_eq!(scene.json()["accessors"], plain.json()["accessors"]);
        }
        let is_compressed = |view: &Value| view.get("extensions").is_some();
        let views = again.json()["bufferViews"].as_array().unwrap();
        let found: Vec<bool> = views.iter().map(is_compressed).collect();
        // Indices of one byte and the image stay.
        assert_eq!(found, [true, false, true, true, true, true, true, false, true]);
        let image = again.document.view(7, "").unwrap().0.to_vec();
        assert_eq!(image, vec![7; 200]);
        let [small, plain] = [&again, &plain].map(|scene| scene.document.buffers[0].length);
        assert!(small * 2 < plain, "{small} {plain}");
    }

    /// Without the lines, triangles and vertices get another order, and indices of one byte become longer.
    #[test]
    fn lists_get_another_order() {
        let plain = scene();
        let mut json = plain.json().clone();
        json["meshes"][0]["primitives"].as_array_mut().unwrap().truncate(1);
        json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("targets");
        let document =
            Document { root: root_of(&json).unwrap(), buffers: plain.document.buffers.clone() };
        let plain = plain.with(json, document);
        let small = plain.compressed().unwrap();
        assert_eq!(small.json()["accessors"][2]["componentType"], 5123);
        let triangles = |scene: &Scene| {
            let positions = scene.document.values(0, "", 3..=3).unwrap().to_vec::<3>(0.0).unwrap();
            let indices = scene.document.indices(2, "").unwrap();
            let mut all: Vec<Vec<[u32; 3]>> = indices
                .chunks_exact(3)
                .map(|triangle| {
                    let mut corners: Vec<[u32; 3]> =
                        triangle.iter().map(|&v| positions[v as usize].map(f32::to_bits)).collect();
                    let least = (0..3).min_by_key(|&i| corners[i]).unwrap();
                    corners.rotate_left(least);
                    corners
                })
                .collect();
            all.sort();
            all
        };
        assert_eq!(triangles(&small), triangles(&plain));
        let order = small.document.indices(2, "").unwrap();
        let mut next = 0;
        for vertex in order {
            assert!(vertex <= next, "vertices are in the order of their use");
            next = next.max(vertex + 1);
        }
    }
}
