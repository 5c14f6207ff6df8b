//! Wavefront OBJ.
//!
//! `tobj` reads the faces and the material libraries. What it would lose is read by a filter in
//! front of it ([`filter`]): which vertex of the file a vertex is, positions in full precision,
//! material names without a library, corners without texture coordinate or normal, and the line
//! of an error.

mod companion;
mod filter;
mod library;
mod material;
mod names;
mod read;
mod write;

pub(crate) use library::{Library, prepare_library};
pub(crate) use read::read;
pub(crate) use write::write;
