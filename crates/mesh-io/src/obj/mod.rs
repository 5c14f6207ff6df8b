//! Wavefront OBJ.
//!
//! Faces keep the vertices, the order and the polygons of the file. Names of groups and materials are kept with or
//! without a library. A corner may lack a texture coordinate or normal. Errors name the line.

mod companion;
mod library;
mod material;
mod names;
mod polypaint;
mod read;
mod scan;
mod write;

pub(crate) use library::{Library, prepare_library};
pub(crate) use read::read;
pub(crate) use scan::scan;
pub(crate) use write::write;
