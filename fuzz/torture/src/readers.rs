//! Readers that share no code with `mesh-io`, to read what it wrote.
//!
//! PLY, STL and glTF by libraries of others; OBJ and OFF, as far as they are written here, in a few
//! lines each. They refuse whatever is not as it should be.

mod gltf;
mod obj;
mod off;
mod ply;
mod stl;

use std::path::Path;

use super::content::{Complaint, Content};

/// Reads a file in the format of its extension.
pub(super) fn read(path: &Path) -> Result<Content, Complaint> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match extension.as_str() {
        "obj" => obj::read(path),
        "off" => off::read(path),
        "ply" => ply::read(path),
        "stl" => stl::read(path),
        "glb" | "gltf" => gltf::read(path),
        other => Err(format!("no reader for .{other}").into()),
    }
}
