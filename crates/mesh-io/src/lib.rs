//! Meshes in and out: OBJ, PLY, STL, OFF and glTF/GLB.
//!
//! [`read`] finds out the format from the content and returns a [`Model`]: a
//! [`mesh_core::PolygonSoup`] with whatever else the file says about its vertices, faces and
//! corners. [`write()`] puts a model into a file of any of these formats; the file at the target is
//! replaced only once the new one is whole.
//!
//! ```
//! let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
//! let model = mesh_io::read_from(&mut &text[..], &mesh_io::ReadOptions::default())?;
//! assert_eq!(model.soup.face_count(), 1);
//!
//! let mut ply = Vec::new();
//! mesh_io::write_to(&mut ply, &model, mesh_io::Format::Ply, &mesh_io::WriteOptions::default())?;
//! assert!(ply.starts_with(b"ply\n"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Nothing is welded, dropped or reoriented: that is for [`mesh_core`] to do, on demand. The one
//! exception is STL, whose facets name no vertices: equal positions become one vertex.
//!
//! | | positions | vertices | faces | corners | parts |
//! |---|---|---|---|---|---|
//! | OBJ | exact | colours | n-gons | UVs, normals | groups, materials, textures beside it |
//! | PLY | exact | normals, colours, scalars | n-gons, colours, scalars | UVs | |
//! | STL | 32 bits | | triangles | | one name |
//! | OFF | exact (text) | normals, colours | n-gons, colours | UVs | |
//! | glTF | 32 bits and an offset | colours, scalars | triangles | UVs, normals | materials, textures |
//!
//! Files of strangers are safe to read. A reader never holds the file as a whole, save for the
//! buffers of glTF; a file takes no more than 64 MiB and 60 bytes for each of its bytes, or what
//! [`ReadOptions::max_memory`] says; it makes no other file be read than those below its own folder
//! ([`External`]); and messages show nothing of it that a terminal would obey ([`printable`]).

mod atomic;
mod budget;
mod decimal;
mod error;
mod external;
mod format;
#[cfg(feature = "gltf")]
mod gltf;
mod input;
mod model;
mod notes;
#[cfg(feature = "obj")]
mod numbering;
#[cfg(feature = "obj")]
mod obj;
mod off;
mod ply;
mod read;
mod stl;
mod text;
mod write;

pub use error::{Location, ReadError, ReadErrorKind, WriteError};
pub use external::External;
pub use format::Format;
pub use model::{Alpha, Blend, Group, Image, ImageData, Material, Model, ModelError, Scalars};
pub use read::{ReadOptions, read, read_from, read_with};
pub use text::printable;
#[cfg(feature = "gltf")]
pub use write::write_levels;
pub use write::{Encoding, Precision, WriteOptions, WriteReport, replace_file, write, write_to};
