//! Stereolithography: triangles without shared vertices, as text or binary.
//!
//! A facet repeats the positions of its corners. Reading makes equal positions one vertex (0 and
//! -0 are equal), for without that the file says nothing about which triangles are neighbours.
//! The normals in the file are ignored; writing computes them.

mod color;
mod facets;
mod passing;
mod read;
mod scan;
mod write;

pub use color::StlColors;
pub(crate) use passing::StlPassing;
pub(crate) use read::read;
pub(crate) use scan::scan;
pub(crate) use write::{write_binary, write_text};
