//! glTF 2.0, as JSON or in its binary container.
//!
//! What is read of a document is in [`schema`]; every index is checked where it is followed. The
//! whole scene is planned before any of it is read, so that its size is known. Writing takes the
//! types of the `gltf` crate, which know how documents look, but not those of its accessors, which
//! panic on indices and counts out of range.

mod accessor;
mod container;
#[cfg(feature = "gltf-crate")]
mod from_document;
mod level;
mod lost;
mod material;
mod plan;
mod read;
mod scene;
mod schema;
mod wedges;
mod write;

pub(crate) use read::read;
pub(crate) use write::{Levels, write_binary, write_json};
