//! The binary container, and the buffers of a document.

use super::accessor::Bytes;
use super::compressed::fallbacks;
use super::schema::Root;
use crate::error::{Location, ReadErrorKind};
use crate::external::{Files, open};
use crate::input::Input;
use crate::lost::Lost;
use crate::notes::Notes;
use crate::text::quote;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io::Read;
use std::path::PathBuf;
use std::sync::Arc;

/// The parts of a container.
#[derive(Default)]
pub(crate) struct Container {
    /// The JSON text.
    pub json: Vec<u8>,
    /// The binary chunk.
    pub binary: Option<Vec<u8>>,
    /// The number of chunks of other types.
    other_chunks: u64,
    /// Whether more bytes follow the container.
    has_more: bool,
}

impl Container {
    /// Names the content that is not read.
    pub(crate) fn note(&self, notes: &mut Notes) {
        let why = "only the JSON and the binary chunk are read";
        notes.lose_some("chunks of other types", self.other_chunks, why);
        if self.has_more {
            notes.lose(Lost::new("bytes after the GLB container", "they are no part of it"));
        }
    }
}

/// The parts of a container, or the whole of a JSON file.
pub(crate) fn read(input: &mut Input<'_>) -> Result<Container, ReadErrorKind> {
    if !input.peek(4)?.starts_with(b"glTF") {
        return Ok(Container { json: input.rest()?, ..Container::default() });
    }
    input.skip(4, "the header")?;
    let at = input.here();
    let version = u32::from_le_bytes(input.array("the version")?);
    if version != 2 {
        return Err(ReadErrorKind::Unsupported {
            at,
            what: format!("version {version} of GLB"),
            cure: "convert the file to glTF 2.0",
        });
    }
    let end = u64::from(u32::from_le_bytes(input.array("the total length")?));
    let (mut json, mut binary, mut other_chunks) = (None, None, 0);
    let mut has_more = false;
    while !input.peek(1)?.is_empty() {
        // If the total length is too small, the main chunks are read all the same: they have their own lengths.
        let is_binary = input.peek(8)?.get(4..8) == Some(b"BIN\0");
        has_more = input.offset() >= end && json.is_some() && !(is_binary && binary.is_none());
        if has_more {
            break;
        }
        let length = u64::from(u32::from_le_bytes(input.array("the length of a chunk")?));
        let at = input.here();
        let kind: [u8; 4] = input.array("the type of a chunk")?;
        match &kind {
            b"JSON" if json.is_none() => json = Some(input.block(length, "the JSON chunk")?),
            _ if json.is_none() => {
                return Err(ReadErrorKind::malformed(at, "the JSON chunk first", quote(&kind)));
            }
            b"BIN\0" if binary.is_none() => {
                binary = Some(input.block(length, "the binary chunk")?);
            }
            _ => {
                input.skip(length, "a chunk")?;
                other_chunks += 1;
            }
        }
    }
    let json = json.ok_or_else(|| input.too_short("a JSON chunk", 8))?;
    Ok(Container { json, binary, other_chunks, has_more })
}

/// The bytes of all buffers.
pub(crate) fn buffers(
    root: &Root,
    mut binary: Option<Vec<u8>>,
    files: &Files<'_>,
    input: &mut Input<'_>,
) -> Result<Vec<Bytes>, ReadErrorKind> {
    let fallbacks = fallbacks(root);
    let is_fallback = |index: usize| fallbacks.get(index).copied().unwrap_or(false);
    let mut others = Others::find(root, files, &is_fallback)?;
    let load = |(index, buffer): (usize, &super::schema::Buffer)| {
        let at = place(index);
        let all = match &buffer.uri {
            Some(uri) => match data_uri(uri) {
                Some((_, bytes)) => {
                    let bytes = bytes
                        .map_err(|why| ReadErrorKind::malformed(at.clone(), "base64 data", why))?;
                    input.spend(bytes.len() as u64, || at.clone())?;
                    Arc::new(bytes)
                }
                None => match others.bytes(uri, input, &at) {
                    Err(ReadErrorKind::MissingResource { .. }) if is_fallback(index) => {
                        Arc::default()
                    }
                    bytes => bytes?,
                },
            },
            None if index == 0 => Arc::new(binary.take().unwrap_or_default()),
            None => Arc::default(),
        };
        if all.is_empty() && is_fallback(index) {
            return Ok(Bytes::default());
        }
        if (all.len() as u64) < buffer.byte_length {
            let (expected, found) = (buffer.byte_length, all.len());
            let (expected, found) = (format!("{expected} bytes"), format!("{found} bytes"));
            return Err(ReadErrorKind::malformed(at, expected, found));
        }
        // The binary chunk is padded.
        Ok(Bytes { all, length: buffer.byte_length as usize })
    };
    root.buffers.iter().enumerate().map(load).collect()
}

fn place(buffer: usize) -> Location {
    Location::Json(format!("buffers[{buffer}]"))
}

/// The files that contain buffers. Each is read once, up to the largest end of a buffer.
struct Others<'d> {
    /// The file for each name in the document.
    names: HashMap<&'d str, usize>,
    files: Vec<OtherFile>,
}

struct OtherFile {
    path: PathBuf,
    length: u64,
    bytes: Option<Arc<Vec<u8>>>,
}

impl<'d> Others<'d> {
    /// The files for the names in the document. Files of fallbacks need not be there.
    fn find(
        root: &'d Root,
        files: &Files<'_>,
        is_fallback: &impl Fn(usize) -> bool,
    ) -> Result<Self, ReadErrorKind> {
        let mut all = Self { names: HashMap::new(), files: Vec::new() };
        let mut places: HashMap<PathBuf, usize> = HashMap::new();
        for (index, buffer) in root.buffers.iter().enumerate() {
            let Some(uri) = buffer.uri.as_deref().filter(|uri| data_uri_parts(uri).is_none())
            else {
                continue;
            };
            let file = match all.names.entry(uri) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(new) => {
                    // The name is resolved before any access to the file.
                    let name = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
                    let path = match files.resolve(&name) {
                        Ok(path) => path,
                        Err(_) if is_fallback(index) => continue,
                        Err(reason) => return Err(missing(uri, reason, &place(index))),
                    };
                    let place = *places.entry(path.clone()).or_insert_with(|| {
                        all.files.push(OtherFile { path, length: 0, bytes: None });
                        all.files.len() - 1
                    });
                    *new.insert(place)
                }
            };
            if let Some(file) = all.files.get_mut(file) {
                file.length = file.length.max(buffer.byte_length);
            }
        }
        Ok(all)
    }

    fn bytes(
        &mut self,
        uri: &str,
        input: &mut Input<'_>,
        at: &Location,
    ) -> Result<Arc<Vec<u8>>, ReadErrorKind> {
        let file = self.names.get(uri).and_then(|&file| self.files.get_mut(file));
        let Some(OtherFile { path, length, bytes }) = file else { return Ok(Arc::default()) };
        if let Some(bytes) = bytes {
            return Ok(Arc::clone(bytes));
        }
        let (file, size) = open(path).map_err(|reason| missing(uri, reason, at))?;
        let wanted = size.min(*length);
        input.add_file(wanted);
        input.spend(wanted, || at.clone())?;
        let mut all = Vec::with_capacity(wanted as usize);
        let read = file.take(wanted).read_to_end(&mut all);
        read.map_err(|error| missing(uri, error.to_string(), at))?;
        let all = Arc::new(all);
        *bytes = Some(Arc::clone(&all));
        Ok(all)
    }
}

fn missing(uri: &str, reason: String, at: &Location) -> ReadErrorKind {
    let uri = uri.chars().take(200).collect();
    ReadErrorKind::MissingResource { at: at.clone(), uri, reason }
}

/// The parts before and after the comma of a data URI.
fn data_uri_parts(uri: &str) -> Option<(&str, &str)> {
    uri.strip_prefix("data:")?.split_once(',')
}

/// The media type and the bytes of a data URI, if this is one with a known encoding.
pub(crate) fn data_uri(uri: &str) -> Option<(String, Result<Vec<u8>, String>)> {
    let (head, data) = data_uri_parts(uri)?;
    match head.strip_suffix(";base64") {
        Some(media_type) => {
            let bytes = STANDARD.decode(data.as_bytes()).map_err(|error| error.to_string());
            Some((media_type.to_owned(), bytes))
        }
        None => {
            let bytes = percent_encoding::percent_decode_str(data).collect();
            Some((head.to_owned(), Ok(bytes)))
        }
    }
}
