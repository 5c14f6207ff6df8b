//! Stanford PLY: a text header that describes elements with named properties, then their values
//! as text or binary.

mod columns;
mod header;
mod passing;
mod read;
mod records;
mod scan;
mod textures;
mod write;

pub(crate) use passing::PlyPassing;
pub(crate) use read::read;
pub(crate) use scan::scan;
pub(crate) use textures::Textures;
pub(crate) use write::write;
