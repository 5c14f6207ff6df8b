//! Writing a scene.

use super::document::{Scene, list_mut, push_all};
use super::extensions::unknown;
use super::references::{MESHOPT, each_range};
use crate::atomic;
use crate::error::WriteError;
use crate::format::Format;
use crate::gltf::container::data_uri;
use crate::gltf::write::{write_glb_buffer_head, write_glb_head};
use crate::lost::Lost;
use crate::picture_format::PictureFormat;
use crate::write::{Staged, check_is_none_of, format_of};
use crate::write_options::{Compression, WriteOptions, WriteReport};
use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use serde_json::{Map, Value, json};
use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

/// Buffers are joined at multiples of this many bytes.
const ALIGNMENT: usize = 8;

impl Scene {
    /// Writes the scene to a glTF or GLB file, whole or not at all. The buffers become one, which is embedded.
    ///
    /// # Errors
    /// A [`WriteError`]; nothing has been written then.
    pub fn write(
        &self,
        path: impl AsRef<Path>,
        options: &WriteOptions,
    ) -> Result<WriteReport, WriteError> {
        self.stage(path, options)?.commit()
    }

    /// Does everything that [`Scene::write`] does except the last step, [`Staged::commit`].
    ///
    /// # Errors
    /// As [`Scene::write`].
    pub fn stage(
        &self,
        path: impl AsRef<Path>,
        options: &WriteOptions,
    ) -> Result<Staged, WriteError> {
        let path = path.as_ref();
        let format = format_of(path, options)?;
        check_is_none_of(path, self.file_pictures().iter().map(String::as_str), "picture")?;
        let (file, report) =
            atomic::prepare(path, |writer| self.write_with(writer, format, options))?;
        Ok(Staged::new(file, report))
    }

    /// Writes the scene to a stream, with the data rounded and compressed as the options ask for.
    ///
    /// # Errors
    /// As [`Scene::write`]; part of the output may have been written only if the stream itself fails.
    pub fn write_with(
        &self,
        writer: &mut dyn Write,
        format: Format,
        options: &WriteOptions,
    ) -> Result<WriteReport, WriteError> {
        let (mut rounding, mut stayed) = (0.0, Vec::new());
        let mut scene = Cow::Borrowed(self);
        if let Some(quantization) = &options.quantization {
            let quantized = self.quantized(quantization)?;
            (rounding, stayed) = (quantized.rounding, quantized.stayed);
            scene = Cow::Owned(quantized.scene);
        }
        if options.compression == Compression::Meshopt {
            scene = Cow::Owned(scene.compressed()?);
        }
        Ok(WriteReport { rounding, stayed, ..scene.write_to(writer, format)? })
    }

    /// Writes the scene to a stream as it is.
    ///
    /// # Errors
    /// As [`Scene::write`]; part of the output may have been written only if the stream itself fails.
    pub fn write_to(
        &self,
        writer: &mut dyn Write,
        format: Format,
    ) -> Result<WriteReport, WriteError> {
        if !matches!(format, Format::Gltf | Format::Glb) {
            return Err(WriteError::NoScene(format));
        }
        self.check_finite(format)?;
        let mut lost = Vec::new();
        let (mut json, mut buffers) = self.joined(&mut lost);
        match format {
            Format::Gltf => {
                embed(&mut json, &buffers, 0)?;
                serde_json::to_writer(&mut *writer, &json).map_err(std::io::Error::from)?;
            }
            _ => {
                if has_data_images(&json) {
                    images_to_views(&mut json, &mut buffers);
                }
                let has_binary = buffers.first().is_some_and(|buffer| !buffer.is_empty());
                embed(&mut json, &buffers, usize::from(has_binary))?;
                let binary = buffers.first().filter(|_| has_binary).map(Cow::as_ref);
                write_binary(writer, &json, binary.unwrap_or_default())?;
            }
        }
        writer.flush()?;
        Ok(WriteReport { lost, ..WriteReport::default() })
    }

    /// Rejects positions that are not finite, which glTF does not allow.
    fn check_finite(&self, format: Format) -> Result<(), WriteError> {
        let primitives = self.root().meshes.iter().flat_map(|mesh| &mesh.primitives);
        let positions = primitives.filter_map(|primitive| primitive.attributes.get("POSITION"));
        let mut positions: Vec<u32> = positions.collect();
        positions.sort_unstable();
        positions.dedup();
        for accessor in positions {
            let found = self.document.values(accessor, "POSITION", 1..=16);
            // Compressed positions are written as they were read.
            let found = found.and_then(|values| values.find_not_finite()).unwrap_or_default();
            if let Some((vertex, value)) = found {
                return Err(WriteError::NotFinite { format, vertex, value });
            }
        }
        Ok(())
    }

    /// The document and its buffers, with all bytes in the first one. If unknown extensions may refer to buffers, they
    /// stay apart.
    fn joined(&self, lost: &mut Vec<Lost>) -> (Value, Vec<Cow<'_, [u8]>>) {
        let mut json = self.json.clone();
        let buffers = &self.document.buffers;
        let filled = buffers.iter().filter(|buffer| !buffer.get().is_empty()).count();
        let is_plain = buffers.first().is_none_or(|first| !first.get().is_empty()) && filled <= 1;
        if is_plain || !unknown(&json).is_empty() {
            return (json, buffers.iter().map(|buffer| Cow::Borrowed(buffer.get())).collect());
        }
        let objects = list_mut(&mut json, "buffers").to_vec();
        let has_more = |object: &Value| object.as_object().is_some_and(|object| object.len() > 1);
        let mut joined = Joined { bytes: Vec::new(), places: Vec::new(), objects: Vec::new() };
        let mut first = None;
        for (buffer, object) in buffers.iter().zip(objects) {
            if buffer.get().is_empty() {
                joined.objects.push(object);
                joined.places.push((joined.objects.len(), 0));
                continue;
            }
            joined.bytes.resize(joined.bytes.len().next_multiple_of(ALIGNMENT), 0);
            joined.places.push((0, joined.bytes.len()));
            joined.bytes.extend_from_slice(buffer.get());
            if first.is_none() {
                first = Some(object);
            } else if has_more(&object) {
                let why = "all buffers are written as one";
                lost.push(Lost::new("names and extras of buffers", why));
            }
        }
        let mut object = first.unwrap_or_default();
        // The joined buffer holds more than what compressed views hold too.
        if let Some(extensions) = object.get_mut("extensions").and_then(Value::as_object_mut) {
            extensions.retain(|name, _| !MESHOPT.contains(&name.as_str()));
            if extensions.is_empty()
                && let Some(members) = object.as_object_mut()
            {
                members.remove("extensions");
            }
        }
        if let Some(members) = object.as_object_mut() {
            members.insert("byteLength".to_owned(), joined.bytes.len().into());
        }
        joined.objects.insert(0, object);
        for view in list_mut(&mut json, "bufferViews") {
            each_range(view, &mut |range| joined.place(range));
        }
        let mut all: Vec<Cow<'_, [u8]>> = vec![Cow::Borrowed(&[]); joined.objects.len()];
        if let (Some(document), Some(first)) = (json.as_object_mut(), all.first_mut()) {
            document.insert("buffers".to_owned(), joined.objects.into());
            *first = joined.bytes.into();
        }
        (json, all)
    }
}

/// Buffers that become one.
struct Joined {
    bytes: Vec<u8>,
    /// For each buffer, its new index and the offset in it.
    places: Vec<(usize, usize)>,
    objects: Vec<Value>,
}

impl Joined {
    fn place(&self, range: &mut Map<String, Value>) {
        let number = |name: &str| range.get(name).and_then(Value::as_u64);
        let (buffer, offset) = (number("buffer"), number("byteOffset").unwrap_or(0));
        let place = buffer.and_then(|buffer| self.places.get(buffer as usize));
        let Some(&(buffer, start)) = place else { return };
        range.insert("buffer".to_owned(), buffer.into());
        if start > 0 {
            range.insert("byteOffset".to_owned(), offset.saturating_add(start as u64).into());
        }
    }
}

fn has_data_images(json: &Value) -> bool {
    let images = json.get("images").and_then(Value::as_array).into_iter().flatten();
    let mut uris = images.filter_map(|image| image.get("uri").and_then(Value::as_str));
    uris.any(|uri| uri.starts_with("data:"))
}

/// Moves images from data URIs to the first buffer, which becomes the binary chunk. No index changes.
fn images_to_views(json: &mut Value, buffers: &mut Vec<Cow<'_, [u8]>>) {
    // Readers need not load a buffer that stands for compressed data.
    let first = list_mut(json, "buffers").first();
    if first.is_some_and(|buffer| buffer.get("extensions").is_some()) {
        return;
    }
    let mut bytes = match buffers.first_mut() {
        // An empty buffer stands for a file of its own, or for data that other buffers hold compressed.
        Some(first) if first.is_empty() => return,
        Some(first) => std::mem::take(first).into_owned(),
        None => Vec::new(),
    };
    let first_view = list_mut(json, "bufferViews").len();
    let mut views = Vec::new();
    for image in list_mut(json, "images").iter_mut().filter_map(Value::as_object_mut) {
        let uri = image.get("uri").and_then(Value::as_str);
        let Some((media_type, Ok(data))) = uri.and_then(data_uri) else { continue };
        if data.is_empty() {
            continue;
        }
        let known = PictureFormat::of(&data).map(|format| format.media_type().to_owned());
        bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
        views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len() }));
        bytes.extend(data);
        image.remove("uri");
        image.insert("bufferView".to_owned(), (first_view + views.len() - 1).into());
        image.entry("mimeType").or_insert_with(|| known.unwrap_or(media_type).into());
    }
    if !views.is_empty() {
        if buffers.is_empty() {
            buffers.push(Cow::default());
            push_all(json, "buffers", [json!({})]);
        }
        push_all(json, "bufferViews", views);
        if let Some(buffer) = list_mut(json, "buffers").first_mut().and_then(Value::as_object_mut) {
            buffer.insert("byteLength".to_owned(), bytes.len().into());
        }
    }
    if let Some(first) = buffers.first_mut() {
        *first = bytes.into();
    }
}

/// Puts the bytes of buffers from `first` on into the document.
fn embed(json: &mut Value, buffers: &[Cow<'_, [u8]>], first: usize) -> Result<(), WriteError> {
    let objects = list_mut(json, "buffers").iter_mut().zip(buffers).skip(first);
    for (object, bytes) in objects.filter(|(_, bytes)| !bytes.is_empty()) {
        let mut uri = b"data:application/octet-stream;base64,".to_vec();
        let mut encoder = EncoderWriter::new(&mut uri, &STANDARD);
        encoder.write_all(bytes)?;
        encoder.finish()?;
        drop(encoder);
        if let Some(members) = object.as_object_mut() {
            members.insert("uri".to_owned(), String::from_utf8_lossy(&uri).into_owned().into());
        }
    }
    Ok(())
}

fn write_binary(writer: &mut dyn Write, json: &Value, binary: &[u8]) -> Result<(), WriteError> {
    let mut text = serde_json::to_vec(json).map_err(std::io::Error::from)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let padded = binary.len().next_multiple_of(4);
    write_glb_head(writer, text.len() as u64, padded as u64)?;
    writer.write_all(&text)?;
    if padded > 0 {
        write_glb_buffer_head(writer, padded as u64)?;
        writer.write_all(binary)?;
        writer.write_all(&[0; 3][..padded - binary.len()])?;
    }
    Ok(())
}
