//! glTF 2.0, as JSON or in its binary container.
//!
//! The `gltf` crate deserialises the document. Its own validation and its accessor iterators
//! panic on indices and counts out of range, so that documents are taken apart here with every
//! index checked where it is followed.

mod accessor;
mod container;
mod level;
mod material;
mod read;
mod scene;
mod wedges;
mod write;

pub(crate) use read::read;
pub(crate) use write::{Levels, write_binary, write_json};
