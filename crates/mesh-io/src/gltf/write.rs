//! Writing glTF: one mesh with a primitive per material, or points if there are no faces. All primitives share the
//! vertices. Each level of detail is a mesh and a node; the first node names the others (`MSFT_lod`).
//!
//! Neither the document nor the buffer is ever in memory as a whole. The document is written twice, the first time only
//! to determine its length.

use super::level::{Column, Component, Level};
use crate::decimal::Decimal;
use crate::error::WriteError;
use crate::format::Format;
use crate::lost::Lost;
use crate::model::{Alpha, Image, ImageData, Material, Model};
use crate::write_options::WriteReport;
use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use glam::{DVec3, Vec3};
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use serde_json::json;
use std::borrow::Cow;
use std::io::{self, Write};

const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// A model, or several of the same object from fine to coarse.
pub(crate) struct Levels<'a> {
    /// They share the materials and images of the first.
    pub(crate) models: Vec<&'a Model>,
    /// For each level, the part of the screen that the object must cover for it to be shown.
    pub(crate) coverage: &'a [f64],
}

/// Writes a document with the buffer in it.
pub(crate) fn write_json(
    writer: &mut dyn Write,
    levels: &Levels<'_>,
) -> Result<WriteReport, WriteError> {
    let plan = Plan::new(levels, Format::Gltf)?;
    plan.document(writer, |writer| {
        write!(writer, r#","uri":"data:application/octet-stream;base64,"#)?;
        let mut encoder = EncoderWriter::new(Whole(writer), &STANDARD);
        plan.buffer(&mut encoder)?;
        write!(encoder.finish()?, "\"")
    })?;
    Ok(plan.report())
}

/// Writes the header of a binary container and of its JSON chunk. Lengths are padded; without bytes of a buffer there is
/// no chunk for it.
pub(crate) fn write_glb_head(
    writer: &mut dyn Write,
    text: u64,
    buffer: u64,
) -> Result<(), WriteError> {
    let total = 20 + text + if buffer == 0 { 0 } else { 8 + buffer };
    let total = glb_size(total)?;
    writer.write_all(b"glTF")?;
    writer.write_all(&2_u32.to_le_bytes())?;
    writer.write_all(&total.to_le_bytes())?;
    writer.write_all(&glb_size(text)?.to_le_bytes())?;
    writer.write_all(b"JSON")?;
    Ok(())
}

/// Writes the header of the chunk of a buffer, whose length is padded.
pub(crate) fn write_glb_buffer_head(writer: &mut dyn Write, buffer: u64) -> Result<(), WriteError> {
    writer.write_all(&glb_size(buffer)?.to_le_bytes())?;
    writer.write_all(b"BIN\0")?;
    Ok(())
}

/// A length in a binary container, which has 32 bits.
fn glb_size(bytes: u64) -> Result<u32, WriteError> {
    u32::try_from(bytes).map_err(|_| WriteError::TooLarge {
        format: Format::Glb,
        what: "bytes",
        limit: u64::from(u32::MAX),
        found: bytes,
    })
}

/// Writes the binary container.
pub(crate) fn write_binary(
    writer: &mut dyn Write,
    levels: &Levels<'_>,
) -> Result<WriteReport, WriteError> {
    let plan = Plan::new(levels, Format::Glb)?;
    let mut length = Length(0);
    plan.document(&mut length, |_| Ok(()))?;
    let padded = length.0.next_multiple_of(4);
    let buffer = plan.buffer_length;
    write_glb_head(writer, padded, buffer)?;
    plan.document(writer, |_| Ok(()))?;
    writer.write_all(&b"   "[..(padded - length.0) as usize])?;
    if buffer > 0 {
        write_glb_buffer_head(writer, buffer)?;
        plan.buffer(writer)?;
    }
    Ok(plan.report())
}

/// Writes all bytes or fails: the base64 encoder does not support partial writes.
struct Whole<'w>(&'w mut dyn Write);

impl Write for Whole<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write_all(bytes)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// Counts the written bytes.
struct Length(u64);

impl Write for Length {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The structure of the output. The buffer has a view for every column of every level, one for all indices of the
/// level, and one for every embedded image. Every column and every primitive has an accessor.
struct Plan<'m> {
    /// The levels with faces, or a level of points.
    levels: Vec<Level<'m>>,
    coverage: Vec<f64>,
    offset: DVec3,
    materials: &'m [Material],
    /// The images with content or a name that materials may use.
    images: Vec<&'m Image>,
    /// For every image of the model, its index in `images`.
    image_places: Vec<Option<usize>>,
    buffer_length: u64,
}

impl<'m> Plan<'m> {
    fn new(levels: &Levels<'m>, format: Format) -> Result<Self, WriteError> {
        let is_empty = |level: usize| {
            let soup = &levels.models[level].soup;
            let are_points = levels.models.len() == 1 && soup.vertex_count() > 0;
            soup.face_count() == 0 && !are_points
        };
        let kept: Vec<usize> = (0..levels.models.len()).filter(|&level| !is_empty(level)).collect();
        let models: Vec<&Model> = kept.iter().map(|&level| levels.models[level]).collect();
        let offset = models.first().map_or(DVec3::ZERO, |model| offset(model.soup.positions()));
        let (materials, all_images) = models
            .first()
            .map_or((&[][..], &[][..]), |model| (&model.materials[..], &model.images[..]));
        let mut images = Vec::new();
        let mut place = |image: &'m Image| {
            let is_there = match &image.data {
                ImageData::Bytes(bytes) => !bytes.is_empty(),
                ImageData::Uri(name) => !name.is_empty(),
            };
            is_there.then(|| {
                images.push(image);
                images.len() - 1
            })
        };
        let image_places = all_images.iter().map(&mut place).collect();
        let level = |model: &&'m Model| Level::new(model, offset, format);
        let mut plan = Self {
            levels: models.iter().map(level).collect::<Result<_, _>>()?,
            coverage: kept
                .iter()
                .filter_map(|&level| levels.coverage.get(level).copied())
                .collect(),
            offset,
            materials,
            images,
            image_places,
            buffer_length: 0,
        };
        plan.buffer_length = plan.views().last().map_or(0, |view| padded(view.start + view.length));
        Ok(plan)
    }

    fn report(&self) -> WriteReport {
        let mut lost: Vec<Lost> = Vec::new();
        for one in self.levels.iter().flat_map(|level| &level.lost) {
            if !lost.contains(one) {
                lost.push(one.clone());
            }
        }
        let rounding = self.levels.iter().map(|level| level.rounding).fold(0.0, f64::max);
        WriteReport { rounding, lost, ..WriteReport::default() }
    }

    /// The parts of the buffer, each aligned to four bytes.
    fn views(&self) -> impl Iterator<Item = View<'_, 'm>> {
        let embedded = self.images.iter().filter_map(|image| match &image.data {
            ImageData::Bytes(bytes) => Some(Content::Image(bytes)),
            ImageData::Uri(_) => None,
        });
        let mut end = 0;
        self.levels.iter().flat_map(contents).chain(embedded).map(move |content| {
            let start = padded(end);
            let length = content.length();
            end = start + length;
            View { start, length, content }
        })
    }

    fn buffer(&self, writer: &mut dyn Write) -> io::Result<()> {
        for view in self.views() {
            view.content.write(writer)?;
            let padding = padded(view.length) - view.length;
            writer.write_all(&[0; 3][..padding as usize])?;
        }
        Ok(())
    }

    /// Writes the document; `buffer` adds to the members of the buffer.
    fn document(
        &self,
        writer: &mut dyn Write,
        buffer: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let generator = concat!("mesh-io ", env!("CARGO_PKG_VERSION"));
        let asset = json!({ "version": "2.0", "generator": generator });
        write!(writer, "{{\"asset\":{asset},\n\"scene\":0,\n")?;
        if self.levels.is_empty() {
            // An empty mesh has no data, glTF allows no empty arrays, and some readers reject a scene without nodes.
            return writeln!(writer, "\"scenes\":[{{\"nodes\":[0]}}],\n\"nodes\":[{{}}]}}");
        }
        writeln!(writer, "\"scenes\":[{{\"nodes\":[0]}}],")?;
        if self.levels.len() > 1 {
            writeln!(writer, "\"extensionsUsed\":[\"MSFT_lod\"],")?;
        }
        list(writer, "nodes", 0..self.levels.len(), |writer, level| self.node(writer, level))?;
        let mut accessor = 0;
        list(writer, "meshes", &self.levels, |writer, level| {
            mesh(writer, level, self.materials.len(), &mut accessor)
        })?;
        if !self.materials.is_empty() {
            list(writer, "materials", self.materials, |writer, one| {
                write!(writer, "{}", material(one, &self.image_places))
            })?;
        }
        if !self.images.is_empty() {
            list(writer, "textures", 0..self.images.len(), |writer, image| {
                write!(writer, r#"{{"source":{image}}}"#)
            })?;
            let embedded = |image: &&&Image| matches!(image.data, ImageData::Bytes(_));
            let mut view = self.views().count() - self.images.iter().filter(embedded).count();
            list(writer, "images", &self.images, |writer, image| {
                write!(writer, "{}", describe_image(image, &mut view))
            })?;
        }
        list(writer, "bufferViews", self.views(), |writer, view| view.describe(writer))?;
        self.accessors(writer)?;
        write!(writer, "\"buffers\":[{{\"byteLength\":{}", self.buffer_length)?;
        buffer(writer)?;
        writeln!(writer, "}}]}}")
    }

    fn node(&self, writer: &mut dyn Write, level: usize) -> io::Result<()> {
        let mut node = json!({ "mesh": level });
        if self.offset != DVec3::ZERO {
            node["translation"] = json!(self.offset.to_array());
        }
        if level == 0 && self.levels.len() > 1 {
            let others: Vec<usize> = (1..self.levels.len()).collect();
            node["extensions"] = json!({ "MSFT_lod": { "ids": others } });
            node["extras"] = json!({ "MSFT_screencoverage": self.coverage });
        }
        write!(writer, "{node}")
    }

    fn accessors(&self, writer: &mut dyn Write) -> io::Result<()> {
        let mut view = 0;
        let accessors = self.levels.iter().flat_map(|level| {
            let first = view;
            let indices = first + level.columns.len();
            view = indices + usize::from(!level.primitives.is_empty());
            let columns = level.columns.iter().enumerate();
            let columns = columns.map(move |(place, &(_, column))| Accessor::Column {
                level,
                column,
                view: first + place,
            });
            let primitives = level.primitives.iter().map(move |primitive| Accessor::Indices {
                view: indices,
                start: 4 * primitive.range.start,
                count: primitive.range.len(),
            });
            columns.chain(primitives)
        });
        list(writer, "accessors", accessors, |writer, accessor| accessor.describe(writer))
    }
}

/// A part of the buffer.
struct View<'p, 'm> {
    start: u64,
    length: u64,
    content: Content<'p, 'm>,
}

impl View<'_, '_> {
    fn describe(&self, writer: &mut dyn Write) -> io::Result<()> {
        let Self { start, length, content } = self;
        write!(writer, r#"{{"buffer":0,"byteOffset":{start},"byteLength":{length}"#)?;
        match content {
            // Numbers shorter than four bytes are padded.
            Content::Column(_, Column::Scalar(_, component)) if *component != Component::F32 => {
                write!(writer, r#","byteStride":4,"target":{ARRAY_BUFFER}}}"#)
            }
            Content::Column(..) => write!(writer, r#","target":{ARRAY_BUFFER}}}"#),
            Content::Indices(_) => write!(writer, r#","target":{ELEMENT_ARRAY_BUFFER}}}"#),
            Content::Image(_) => write!(writer, "}}"),
        }
    }
}

enum Content<'p, 'm> {
    Column(&'p Level<'m>, Column),
    Indices(&'p Level<'m>),
    Image(&'p [u8]),
}

impl Content<'_, '_> {
    fn length(&self) -> u64 {
        match self {
            Self::Column(level, column) => (level.vertex_count() * column.size()) as u64,
            Self::Indices(level) => 4 * level.indices.len() as u64,
            Self::Image(bytes) => bytes.len() as u64,
        }
    }

    fn write(&self, writer: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Column(level, column) => level.write(*column, writer),
            Self::Indices(level) => level.write_indices(writer),
            Self::Image(bytes) => writer.write_all(bytes),
        }
    }
}

/// The parts of the buffer that belong to a level.
fn contents<'p, 'm>(level: &'p Level<'m>) -> impl Iterator<Item = Content<'p, 'm>> {
    let columns = level.columns.iter().map(move |&(_, column)| Content::Column(level, column));
    columns.chain((!level.primitives.is_empty()).then_some(Content::Indices(level)))
}

enum Accessor<'p, 'm> {
    Column { level: &'p Level<'m>, column: Column, view: usize },
    Indices { view: usize, start: usize, count: usize },
}

impl Accessor<'_, '_> {
    fn describe(&self, writer: &mut dyn Write) -> io::Result<()> {
        match *self {
            Self::Column { level, column, view } => {
                let component = match column {
                    Column::ByteColor => UNSIGNED_BYTE,
                    Column::Scalar(_, component) => component.code(),
                    _ => FLOAT,
                };
                let (count, shape) = (level.vertex_count(), column.shape());
                write!(
                    writer,
                    r#"{{"bufferView":{view},"componentType":{component},"count":{count},"type":"{shape}""#
                )?;
                match column {
                    Column::Position => {
                        let [low, high] = level.bounds.map(triple);
                        write!(writer, r#","min":{low},"max":{high}}}"#)
                    }
                    Column::ByteColor => write!(writer, r#","normalized":true}}"#),
                    _ => write!(writer, "}}"),
                }
            }
            Self::Indices { view, start, count } => write!(
                writer,
                r#"{{"bufferView":{view},"byteOffset":{start},"componentType":{UNSIGNED_INT},"count":{count},"type":"SCALAR"}}"#
            ),
        }
    }
}

/// Three numbers in all their digits, because some programs compare them with the buffer in 64 bits.
fn triple(values: Vec3) -> String {
    let [x, y, z] = values.as_dvec3().to_array().map(Decimal);
    format!("[{x},{y},{z}]")
}

/// A list member of the document, with one item per line.
fn list<T>(
    writer: &mut dyn Write,
    name: &str,
    items: impl IntoIterator<Item = T>,
    mut write: impl FnMut(&mut dyn Write, T) -> io::Result<()>,
) -> io::Result<()> {
    write!(writer, "\"{name}\":[")?;
    for (place, item) in items.into_iter().enumerate() {
        writer.write_all(if place == 0 { b"\n" } else { b",\n" })?;
        write(writer, item)?;
    }
    writeln!(writer, "],")
}

/// The mesh of a level. Its accessors start at `accessor`, which is advanced to the next level.
fn mesh(
    writer: &mut dyn Write,
    level: &Level<'_>,
    materials: usize,
    accessor: &mut usize,
) -> io::Result<()> {
    let columns = level.columns.iter().zip(*accessor..);
    let attributes: serde_json::Map<_, _> =
        columns.map(|((name, _), accessor)| (name.clone(), json!(accessor))).collect();
    let attributes = serde_json::Value::Object(attributes).to_string();
    *accessor += level.columns.len();
    write!(writer, r#"{{"primitives":["#)?;
    if level.primitives.is_empty() {
        write!(writer, r#"{{"attributes":{attributes},"mode":0}}"#)?;
    }
    for (place, primitive) in level.primitives.iter().enumerate() {
        writer.write_all(if place == 0 { b"\n" } else { b",\n" })?;
        write!(writer, r#"{{"attributes":{attributes},"indices":{accessor}"#)?;
        // All levels use the materials of the first level.
        if (primitive.material as usize) < materials {
            write!(writer, r#","material":{}"#, primitive.material)?;
        }
        write!(writer, "}}")?;
        *accessor += 1;
    }
    write!(writer, "]}}")
}

fn padded(length: u64) -> u64 {
    length.next_multiple_of(4)
}

/// The offset of the positions before rounding to 32 bits: zero if rounding is exact or an offset gains little;
/// otherwise the centre of the mesh, rounded to 32 bits.
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
    // Integers are read equally by every program.
    let rounded = center.round().as_vec3().as_dvec3();
    if (rounded - center).abs().max_element() <= extent.max(1.0) { rounded } else { DVec3::ZERO }
}

fn material(material: &Material, image_places: &[Option<usize>]) -> serde_json::Value {
    // Outside these bounds a document is invalid.
    let share = |value: f32, otherwise: f32| {
        if value.is_finite() { value.clamp(0.0, 1.0) } else { otherwise }
    };
    let mut pbr = json!({
        "baseColorFactor": material.base_color.map(|value| share(value, 1.0)),
        "metallicFactor": share(material.metallic, 0.0),
        "roughnessFactor": share(material.roughness, 1.0),
    });
    let place = material.base_color_image.and_then(|image| image_places.get(image as usize));
    if let Some(Some(texture)) = place {
        pbr["baseColorTexture"] = json!({ "index": texture });
    }
    let mut value = json!({
        "pbrMetallicRoughness": pbr,
        "emissiveFactor": material.emissive.map(|value| share(value, 0.0)),
        "doubleSided": material.double_sided,
    });
    if !material.name.is_empty() {
        value["name"] = json!(material.name);
    }
    match material.alpha {
        Alpha::Opaque => {}
        Alpha::Mask(cutoff) => {
            value["alphaMode"] = json!("MASK");
            value["alphaCutoff"] = json!(if cutoff.is_finite() { cutoff.max(0.0) } else { 0.5 });
        }
        Alpha::Blend => value["alphaMode"] = json!("BLEND"),
    }
    value
}

/// An image. If it is embedded, its bytes are in the buffer view `view`, which is then advanced.
fn describe_image(image: &Image, view: &mut usize) -> serde_json::Value {
    let mut value = json!({});
    if !image.name.is_empty() {
        value["name"] = json!(image.name);
    }
    match &image.data {
        ImageData::Uri(name) => {
            value["uri"] = json!(uri(name));
            if !image.media_type.is_empty() {
                value["mimeType"] = json!(image.media_type);
            }
        }
        ImageData::Bytes(_) => {
            // A view needs a media type.
            let known = Some(image.media_type()).filter(|kind| !kind.is_empty());
            value["mimeType"] = json!(known.unwrap_or("application/octet-stream"));
            value["bufferView"] = json!(view);
            *view += 1;
        }
    }
    value
}

/// The name of a file as a URI, with reserved characters percent-encoded.
fn uri(name: &str) -> Cow<'_, str> {
    const PLAIN: &AsciiSet =
        &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/');
    let is_scheme = |scheme: &str| {
        !scheme.is_empty()
            && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b))
    };
    let has_scheme = name.split_once("://").is_some_and(|(scheme, _)| is_scheme(scheme));
    if has_scheme || name.starts_with("data:") {
        return Cow::Borrowed(name);
    }
    // Material libraries from Windows use this separator.
    utf8_percent_encode(&name.replace('\\', "/"), PLAIN).to_string().into()
}

#[cfg(test)]
mod tests {
    use super::uri;

    #[test]
    fn names_of_files_become_uris() {
        for (name, expected) in [
            ("skin.png", "skin.png"),
            ("my skin#1 100%.png", "my%20skin%231%20100%25.png"),
            ("maps\\skin.png", "maps/skin.png"),
            ("a:b.png", "a%3Ab.png"),
            ("höhe.png", "h%C3%B6he.png"),
            ("https://example.org/a%20b.png", "https://example.org/a%20b.png"),
        ] {
            assert_eq!(uri(name), expected);
        }
    }
}
