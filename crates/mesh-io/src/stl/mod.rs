//! Stereolithography: triangles without shared vertices, as text or binary.
//!
//! A facet repeats the positions of its corners. The reader welds equal positions (0 and -0 are equal), because
//! otherwise the adjacency of triangles would be unknown. The normals in the file are ignored; the writer computes
//! them. The text in the header of a binary file is a comment of the model.

mod color;
mod facets;
mod header;
mod passing;
mod read;
mod scan;
mod write;

pub use color::StlColors;
pub(crate) use passing::StlPassing;
pub(crate) use read::read;
pub(crate) use scan::scan;
pub(crate) use write::{comment, write_binary, write_text};
