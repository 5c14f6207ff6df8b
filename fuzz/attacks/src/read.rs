//! Files of every format: read, or refused with a message that is safe for a terminal.

use std::io::Read;

use mesh_io::{Format, Model, ReadError, ReadOptions, WriteOptions};

/// Wavefront OBJ.
pub fn obj(data: &[u8]) {
    attack(data, Format::Obj);
}

/// PLY.
pub fn ply(data: &[u8]) {
    attack(data, Format::Ply);
}

/// STL.
pub fn stl(data: &[u8]) {
    attack(data, Format::Stl);
}

/// OFF.
pub fn off(data: &[u8]) {
    attack(data, Format::Off);
}

/// GLB, or glTF without the magic number of GLB.
pub fn gltf(data: &[u8]) {
    attack(data, if data.starts_with(b"glTF") { Format::Glb } else { Format::Gltf });
}

/// Files up to this size are also read in pieces of a few bytes.
const SMALL: usize = 600;

fn attack(data: &[u8], format: Format) {
    let read = read(&mut &data[..], format, data.len());
    if data.len() <= SMALL {
        let slowly = self::read(&mut Slow(data), format, data.len());
        assert_eq!(format!("{read:?}"), format!("{slowly:?}"), "it matters how bytes arrive");
    }
    match read {
        Ok(model) => accept(&model, data.len(), format),
        Err(error) => is_printable(&error.to_string()),
    }
}

fn read(reader: &mut dyn Read, format: Format, size: usize) -> Result<Model, ReadError> {
    let options =
        ReadOptions { format: Some(format), size: Some(size as u64), ..ReadOptions::default() };
    mesh_io::read_from(reader, &options)
}

/// A model read from a file must be consistent, not larger than the file justifies, and writable.
fn accept(model: &Model, size: usize, format: Format) {
    model.check().expect("what is read fits together, save for faces that name no vertex");
    model.notes.iter().for_each(|note| is_printable(note));
    let soup = &model.soup;
    if !matches!(format, Format::Gltf | Format::Glb) {
        let largest = soup.vertex_count().max(soup.face_count()).max(soup.corners().len());
        assert!(largest <= size, "{size} bytes became {largest} elements");
    }
    if size > 20 * SMALL {
        return;
    }
    for format in Format::ALL.iter().copied() {
        // Some formats cannot store some models; then they return an error.
        if let Err(error) =
            mesh_io::write_to(&mut std::io::sink(), model, format, &WriteOptions::default())
        {
            is_printable(&error.to_string());
        }
    }
}

/// No control characters, which could affect the terminal.
fn is_printable(text: &str) {
    assert!(!text.contains(char::is_control), "a message holds control characters: {text:?}");
}

/// Returns one to seven bytes per call.
struct Slow<'a>(&'a [u8]);

impl Read for Slow<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = (1 + self.0.len() % 7).min(buffer.len()).min(self.0.len());
        let (now, later) = self.0.split_at(count);
        buffer[..count].copy_from_slice(now);
        self.0 = later;
        Ok(count)
    }
}
