//! The binary container, and the buffers of a document.

use crate::error::{Location, ReadErrorKind, quote};
use crate::input::Input;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::json::Root;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The JSON text and the binary chunk.
pub(super) fn read(input: &mut Input<'_>) -> Result<(Vec<u8>, Option<Vec<u8>>), ReadErrorKind> {
    if !input.peek(4)?.starts_with(b"glTF") {
        return Ok((input.rest()?, None));
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
    // Chunks say their own length; the total adds nothing.
    input.skip(4, "the total length")?;
    let (mut json, mut binary) = (None, None);
    while !input.peek(1)?.is_empty() {
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
            _ => input.skip(length, "a chunk")?,
        }
    }
    let json = json.ok_or_else(|| input.too_short("a JSON chunk", 8))?;
    Ok((json, binary))
}

/// The bytes of all buffers.
pub(super) fn buffers(
    root: &Root,
    mut binary: Option<Vec<u8>>,
    folder: Option<&Path>,
) -> Result<Vec<Vec<u8>>, ReadErrorKind> {
    let load = |(index, buffer): (usize, &gltf::json::Buffer)| {
        let at = Location::Json(format!("buffers[{index}]"));
        let length = buffer.byte_length.0;
        let mut bytes = match &buffer.uri {
            Some(uri) => resource(uri, length, folder, &at)?,
            None if index == 0 => binary.take().unwrap_or_default(),
            None => Vec::new(),
        };
        if (bytes.len() as u64) < length {
            let found = format!("{} bytes", bytes.len());
            return Err(ReadErrorKind::malformed(at, format!("{length} bytes"), found));
        }
        // The binary chunk is padded.
        bytes.truncate(length as usize);
        Ok(bytes)
    };
    root.buffers.iter().enumerate().map(load).collect()
}

/// The bytes of a data URI, if this is one with a known encoding, and its media type.
pub(super) fn data_uri(uri: &str) -> Option<(String, Result<Vec<u8>, String>)> {
    let (head, data) = uri.strip_prefix("data:")?.split_once(',')?;
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

fn resource(
    uri: &str,
    length: u64,
    folder: Option<&Path>,
    at: &Location,
) -> Result<Vec<u8>, ReadErrorKind> {
    if let Some((_, bytes)) = data_uri(uri) {
        return bytes.map_err(|why| ReadErrorKind::malformed(at.clone(), "base64 data", why));
    }
    let missing = |reason: String| ReadErrorKind::MissingResource {
        at: at.clone(),
        uri: uri.chars().take(200).collect(),
        reason,
    };
    let folder = folder.ok_or_else(|| missing("the folder is not known".to_owned()))?;
    if uri.contains(':') || uri.starts_with('/') {
        return Err(missing("it is not relative to the folder of the document".to_owned()));
    }
    let name = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let file =
        File::open(folder.join(name.as_ref())).map_err(|error| missing(error.to_string()))?;
    if !file.metadata().is_ok_and(|metadata| metadata.is_file()) {
        return Err(missing("it is not a file".to_owned()));
    }
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes).map_err(|error| missing(error.to_string()))?;
    Ok(bytes)
}
