//! Writing glTF: one mesh, a primitive per material, all of them sharing the vertices. Levels of
//! detail are a mesh and a node each, the first node naming the others (`MSFT_lod`).

use crate::write::{Cutter, as_bytes};
use crate::{Alpha, Format, ImageData, Model, WriteError, WriteReport};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use serde_json::{Map, Value, json};
use std::collections::HashMap;
use std::io::Write;

const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

pub(crate) fn write_json(writer: &mut dyn Write, model: &Model) -> Result<WriteReport, WriteError> {
    write_levels_json(writer, &Levels::one(model))
}

pub(crate) fn write_levels_json(
    writer: &mut dyn Write,
    levels: &Levels<'_>,
) -> Result<WriteReport, WriteError> {
    let (mut document, binary, report) = build(levels, Format::Gltf)?;
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&binary));
    document["buffers"] = json!([{ "byteLength": binary.len(), "uri": uri }]);
    if binary.is_empty() {
        remove_buffers(&mut document);
    }
    serde_json::to_writer_pretty(writer, &document).map_err(std::io::Error::from)?;
    Ok(report)
}

pub(crate) fn write_binary(
    writer: &mut dyn Write,
    model: &Model,
) -> Result<WriteReport, WriteError> {
    write_levels_binary(writer, &Levels::one(model))
}

pub(crate) fn write_levels_binary(
    writer: &mut dyn Write,
    levels: &Levels<'_>,
) -> Result<WriteReport, WriteError> {
    let (mut document, mut binary, report) = build(levels, Format::Glb)?;
    document["buffers"] = json!([{ "byteLength": binary.len() }]);
    if binary.is_empty() {
        remove_buffers(&mut document);
    }
    let mut json = serde_json::to_vec(&document).map_err(std::io::Error::from)?;
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let binary_chunk = if binary.is_empty() { 0 } else { 8 + binary.len() };
    let total = 20 + json.len() + binary_chunk;
    let size = |bytes: usize| {
        u32::try_from(bytes).map_err(|_| WriteError::TooLarge {
            format: Format::Glb,
            what: "bytes",
            limit: u64::from(u32::MAX),
            found: bytes as u64,
        })
    };
    writer.write_all(b"glTF")?;
    writer.write_all(&2_u32.to_le_bytes())?;
    writer.write_all(&size(total)?.to_le_bytes())?;
    writer.write_all(&size(json.len())?.to_le_bytes())?;
    writer.write_all(b"JSON")?;
    writer.write_all(&json)?;
    if !binary.is_empty() {
        writer.write_all(&size(binary.len())?.to_le_bytes())?;
        writer.write_all(b"BIN\0")?;
        writer.write_all(&binary)?;
    }
    Ok(report)
}

/// A model, or several of the same object from fine to coarse.
pub(crate) struct Levels<'a> {
    /// They share the materials and images of the first.
    pub(crate) models: Vec<&'a Model>,
    /// For each the part of the screen that the object must cover for it to be shown.
    pub(crate) coverage: Vec<f64>,
}

impl<'a> Levels<'a> {
    fn one(model: &'a Model) -> Self {
        Self { models: vec![model], coverage: Vec::new() }
    }
}

/// An empty mesh has no data; glTF allows no empty arrays.
fn remove_buffers(document: &mut Value) {
    if let Some(document) = document.as_object_mut() {
        document.remove("buffers");
    }
}

/// The vertices of glTF: a vertex of the model for every combination of texture coordinate and
/// normal at it. The first combination keeps the number of the vertex, so that a mesh without
/// seams keeps its numbering.
struct Wedges {
    /// The vertex of the model and the corner that gives the attributes, if any.
    sources: Vec<(u32, Option<u32>)>,
    /// For every corner of the model.
    of_corner: Vec<u32>,
}

impl Wedges {
    fn new(model: &Model) -> Self {
        let vertices = model.soup.vertex_count();
        let mut sources: Vec<_> = (0..vertices as u32).map(|vertex| (vertex, None)).collect();
        if model.corner_uvs.is_none() && model.corner_normals.is_none() {
            return Self { sources, of_corner: model.soup.corners().to_vec() };
        }
        let key = |corner: usize| {
            let uv = model.corner_uvs.as_ref().map(|uvs| uvs[corner].map(f32::to_bits));
            let normal = model.corner_normals.as_ref().map(|all| all[corner].map(f32::to_bits));
            (uv, normal)
        };
        let mut extra = HashMap::<_, u32, foldhash::fast::RandomState>::default();
        let mut of_corner = Vec::with_capacity(model.soup.corners().len());
        for (corner, &vertex) in model.soup.corners().iter().enumerate() {
            let first = *sources[vertex as usize].1.get_or_insert(corner as u32);
            let wedge = if key(first as usize) == key(corner) {
                vertex
            } else {
                let next = sources.len() as u32;
                let wedge = *extra.entry((vertex, key(corner))).or_insert(next);
                if wedge == next {
                    sources.push((vertex, Some(corner as u32)));
                }
                wedge
            };
            of_corner.push(wedge);
        }
        Self { sources, of_corner }
    }
}

/// Accumulates the buffer with its views and accessors.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    fn view(&mut self, bytes: impl IntoIterator<Item = u8>, target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        let mut view =
            json!({ "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, view: usize, count: usize, component: u32, kind: &str) -> usize {
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind,
        }));
        self.accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, values: &[[f32; N]], kind: &str) -> usize {
        let bytes = values.as_flattened().iter().flat_map(|value| value.to_le_bytes());
        let view = self.view(bytes, Some(ARRAY_BUFFER));
        self.accessor(view, values.len(), FLOAT, kind)
    }
}

/// The error for a coordinate that 32 bits cannot hold, if there is one.
fn check_coordinates(model: &Model, format: Format) -> Result<(), WriteError> {
    for (vertex, position) in model.soup.positions().iter().enumerate() {
        if let Some(value) =
            position.to_array().into_iter().find(|value| !(*value as f32).is_finite())
        {
            return Err(WriteError::NotFinite { format, vertex, value });
        }
    }
    Ok(())
}

fn build(levels: &Levels<'_>, format: Format) -> Result<(Value, Vec<u8>, WriteReport), WriteError> {
    let models: Vec<&Model> =
        levels.models.iter().copied().filter(|model| model.soup.face_count() > 0).collect();
    levels.models.iter().try_for_each(|model| check_coordinates(model, format))?;
    let mut buffer = Buffer::default();
    let mut document = json!({
        "asset": { "version": "2.0", "generator": concat!("mesh-io ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
    });
    let mut report = WriteReport::default();
    let Some(&model) = models.first() else {
        document["scenes"] = json!([{ "nodes": [] }]);
        return Ok((document, buffer.bytes, report));
    };
    let offset = offset(model.soup.positions());
    let (mut meshes, mut nodes) = (Vec::new(), Vec::new());
    for (level, model) in models.iter().enumerate() {
        let wedges = Wedges::new(model);
        let attributes = attributes(model, &wedges, offset, &mut buffer, &mut report);
        meshes.push(json!({ "primitives": primitives(model, &wedges, &attributes, &mut buffer) }));
        let mut node = json!({ "mesh": level });
        if offset != DVec3::ZERO {
            node["translation"] = json!(offset.to_array());
        }
        nodes.push(node);
    }
    if nodes.len() > 1 {
        let others: Vec<usize> = (1..nodes.len()).collect();
        nodes[0]["extensions"] = json!({ "MSFT_lod": { "ids": others } });
        nodes[0]["extras"] = json!({ "MSFT_screencoverage": levels.coverage });
        document["extensionsUsed"] = json!(["MSFT_lod"]);
    }
    document["meshes"] = Value::Array(meshes);
    document["nodes"] = Value::Array(nodes);
    document["scenes"] = json!([{ "nodes": [0] }]);
    if !model.materials.is_empty() {
        document["materials"] = model.materials.iter().map(material).collect();
    }
    if !model.images.is_empty() {
        document["images"] = images(model, &mut buffer);
        document["textures"] = (0..model.images.len()).map(|i| json!({ "source": i })).collect();
    }
    document["bufferViews"] = Value::Array(buffer.views);
    document["accessors"] = Value::Array(buffer.accessors);
    Ok((document, buffer.bytes, report))
}

/// What to subtract from the positions before rounding them to 32 bits: nothing when that is
/// exact already or gains little, else the middle of the mesh, rounded so that 32 bits hold it.
fn offset(positions: &[DVec3]) -> DVec3 {
    let exact = |p: &DVec3| p.as_vec3().as_dvec3() == *p;
    if positions.iter().all(exact) {
        return DVec3::ZERO;
    }
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let (center, extent) = ((low + high) / 2.0, (high - low).max_element());
    if center.abs().max_element() < 8.0 * extent {
        return DVec3::ZERO;
    }
    // Whole numbers read the same in every program.
    let rounded = center.round().as_vec3().as_dvec3();
    if (rounded - center).abs().max_element() <= extent.max(1.0) { rounded } else { DVec3::ZERO }
}

fn attributes(
    model: &Model,
    wedges: &Wedges,
    offset: DVec3,
    buffer: &mut Buffer,
    report: &mut WriteReport,
) -> Value {
    let mut attributes = Map::new();
    let mut add = |name: &str, accessor: usize| attributes.insert(name.to_owned(), json!(accessor));
    let source = |vertex: u32| vertex as usize;
    let positions: Vec<[f32; 3]> = wedges
        .sources
        .iter()
        .map(|&(vertex, _)| {
            let exact = model.soup.positions()[source(vertex)];
            let stored = (exact - offset).as_vec3();
            let error = (stored.as_dvec3() + offset - exact).abs().max_element();
            report.rounding = report.rounding.max(error);
            stored.to_array()
        })
        .collect();
    let extreme = |pick: fn(f32, f32) -> f32| {
        let mut all = positions[0];
        for position in &positions {
            for (value, &other) in all.iter_mut().zip(position) {
                *value = pick(*value, other);
            }
        }
        json!(all)
    };
    let accessor = buffer.floats(&positions, "VEC3");
    buffer.accessors[accessor]["min"] = extreme(f32::min);
    buffer.accessors[accessor]["max"] = extreme(f32::max);
    add("POSITION", accessor);
    let no_normal = |normal: [f32; 3]| if normal[0].is_nan() { [0.0, 0.0, 1.0] } else { normal };
    let by_corner = |corner: Option<u32>| corner.map(|corner| corner as usize);
    let normals: Option<Vec<[f32; 3]>> = match (&model.corner_normals, &model.vertex_normals) {
        (Some(all), _) => Some(
            wedges
                .sources
                .iter()
                .map(|&(_, c)| no_normal(by_corner(c).map_or([f32::NAN; 3], |c| all[c])))
                .collect(),
        ),
        (None, Some(all)) => {
            Some(wedges.sources.iter().map(|&(v, _)| no_normal(all[source(v)])).collect())
        }
        (None, None) => None,
    };
    if let Some(normals) = normals {
        add("NORMAL", buffer.floats(&normals, "VEC3"));
    }
    if let Some(all) = &model.corner_uvs {
        let uv =
            |c: usize| if all[c][0].is_nan() { [0.0; 2] } else { [all[c][0], 1.0 - all[c][1]] };
        let uvs: Vec<_> =
            wedges.sources.iter().map(|&(_, c)| by_corner(c).map_or([0.0; 2], uv)).collect();
        add("TEXCOORD_0", buffer.floats(&uvs, "VEC2"));
    }
    if let Some(all) = &model.vertex_colors {
        let colors: Vec<_> = wedges.sources.iter().map(|&(v, _)| all[source(v)]).collect();
        let accessor = match as_bytes(&colors) {
            Some(bytes) => {
                let view = buffer.view(bytes.into_iter().flatten(), Some(ARRAY_BUFFER));
                let accessor = buffer.accessor(view, colors.len(), UNSIGNED_BYTE, "VEC4");
                buffer.accessors[accessor]["normalized"] = json!(true);
                accessor
            }
            None => buffer.floats(&colors, "VEC4"),
        };
        add("COLOR_0", accessor);
    }
    for scalars in &model.vertex_scalars {
        let values: Vec<_> =
            wedges.sources.iter().map(|&(v, _)| [scalars.values[source(v)] as f32]).collect();
        let accessor = buffer.floats(&values, "SCALAR");
        add(&format!("_{}", scalars.name.to_uppercase()), accessor);
    }
    Value::Object(attributes)
}

fn primitives(
    model: &Model,
    wedges: &Wedges,
    attributes: &Value,
    buffer: &mut Buffer,
) -> Vec<Value> {
    let mut by_material: Vec<(u32, Vec<u32>)> = Vec::new();
    let mut places = HashMap::new();
    let mut cutter = Cutter::default();
    for face in 0..model.soup.face_count() {
        let material = model.face_materials.as_ref().map_or(Model::NONE, |all| all[face]);
        let place = *places.entry(material).or_insert_with(|| {
            by_material.push((material, Vec::new()));
            by_material.len() - 1
        });
        let corners = &wedges.of_corner[model.soup.corner_range(face)];
        let triangles = cutter.cut(&model.soup, face).as_flattened();
        by_material[place].1.extend(triangles.iter().map(|&corner| corners[corner as usize]));
    }
    by_material
        .into_iter()
        .map(|(material, indices)| {
            let bytes = indices.iter().flat_map(|index| index.to_le_bytes());
            let view = buffer.view(bytes, Some(ELEMENT_ARRAY_BUFFER));
            let accessor = buffer.accessor(view, indices.len(), UNSIGNED_INT, "SCALAR");
            let mut primitive = json!({ "attributes": attributes, "indices": accessor });
            if material != Model::NONE {
                primitive["material"] = json!(material);
            }
            primitive
        })
        .collect()
}

fn material(material: &crate::Material) -> Value {
    let mut pbr = json!({
        "baseColorFactor": material.base_color,
        "metallicFactor": material.metallic,
        "roughnessFactor": material.roughness,
    });
    if let Some(image) = material.base_color_image {
        pbr["baseColorTexture"] = json!({ "index": image });
    }
    let mut value = json!({
        "name": material.name,
        "pbrMetallicRoughness": pbr,
        "emissiveFactor": material.emissive,
        "doubleSided": material.double_sided,
    });
    match material.alpha {
        Alpha::Opaque => {}
        Alpha::Mask(cutoff) => {
            value["alphaMode"] = json!("MASK");
            value["alphaCutoff"] = json!(cutoff);
        }
        Alpha::Blend => value["alphaMode"] = json!("BLEND"),
    }
    value
}

fn images(model: &Model, buffer: &mut Buffer) -> Value {
    let mut image = |image: &crate::Image| {
        let mut value = json!({ "name": image.name });
        if !image.media_type.is_empty() {
            value["mimeType"] = json!(image.media_type);
        }
        match &image.data {
            ImageData::Uri(uri) => value["uri"] = json!(uri),
            ImageData::Bytes(bytes) => {
                value["bufferView"] = json!(buffer.view(bytes.iter().copied(), None));
            }
        }
        value
    };
    model.images.iter().map(&mut image).collect()
}
