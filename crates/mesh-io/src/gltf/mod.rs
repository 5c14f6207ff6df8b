//! glTF 2.0, as JSON or in its binary container.
//!
//! The parts of a document that are read are in [`schema`]; every index is checked when it is used. The whole scene is
//! planned before any of it is read, so that its size is known. The writer uses the types of the `gltf` crate for
//! documents, but not its accessors, which panic on indices and counts out of range.

pub(crate) mod accessor;
pub(crate) mod compressed;
pub(crate) mod container;
#[cfg(feature = "draco")]
pub(crate) mod draco;
#[cfg(feature = "gltf-crate")]
mod from_document;
mod level;
mod lost;
pub(crate) mod material;
pub(crate) mod parts;
pub(crate) mod plan;
pub(crate) mod read;
mod scan;
pub(crate) mod scene;
pub(crate) mod schema;
mod wedges;
pub(crate) mod write;

pub(crate) use read::read;
pub(crate) use scan::scan;
pub(crate) use write::{Levels, write_binary, write_json};
