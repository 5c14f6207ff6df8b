#![doc = include_str!("../README.md")]

mod atomic;
mod budget;
mod color;
mod color_range;
mod copied_pictures;
mod cutter;
mod decimal;
mod distinct_names;
mod error;
mod external;
mod format;
#[cfg(feature = "tobj")]
mod from_tobj;
#[cfg(feature = "gltf")]
mod gltf;
mod input;
mod item;
mod losses;
mod lost;
#[cfg(feature = "gltf")]
mod meshopt;
mod model;
mod notes;
#[cfg(any(feature = "obj", feature = "gltf"))]
mod numbering;
#[cfg(feature = "obj")]
mod obj;
mod off;
mod passing;
mod picture_format;
mod pictures;
mod ply;
mod read;
mod scalars;
mod scan;
#[cfg(feature = "gltf")]
mod scene;
mod single;
mod smoothing;
mod stl;
mod temporary;
mod text;
mod to_model;
#[cfg(feature = "gltf")]
mod vertex_cache;
mod whole_numbers;
mod write;
mod write_options;
mod write_passing;

pub use color::color_in_bytes;
pub use copied_pictures::{CopiedPictures, copy_pictures};
pub use error::{Location, ReadError, ReadErrorKind, WriteError};
pub use external::External;
pub use format::Format;
pub use item::Item;
pub use lost::Lost;
pub use model::{Alpha, Blend, Group, Image, ImageData, Material, Model, ModelError};
pub use passing::{NO_COLOR, Passing};
pub use picture_format::PictureFormat;
pub use pictures::{Picture, PictureError, PictureOptions, Pictures};
pub use read::{ReadOptions, read, read_from, read_with};
pub use scalars::{ScalarType, ScalarValues, Scalars};
pub use scan::{Scanned, scan, scan_from};
#[cfg(feature = "gltf")]
pub use scene::{
    NewMesh, NewPrimitive, QuantizedScene, Scene, SceneDraw, SceneMesh, SceneNode, ScenePose,
    ScenePrimitive, VertexData,
};
pub use stl::StlColors;
pub use text::printable;
pub use to_model::ToModel;
pub use write::{Staged, check_write, replace_file, stage, stage_file, write, write_to};
#[cfg(feature = "gltf")]
pub use write::{stage_levels, write_levels};
pub use write_options::{
    Compression, Encoding, Precision, Quantization, WriteOptions, WriteReport,
};
pub use write_passing::{Passer, stage_passing, write_passing};
