//! Readers that share no code with `mesh-io`, to read its output.
//!
//! PLY, STL and glTF by third-party libraries; OBJ and OFF by a few lines each, for the content that `mesh-io` writes.
//! They refuse everything else.

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
