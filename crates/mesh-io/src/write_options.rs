//! Options and reports of the writers.

use crate::error::WriteError;
use crate::format::Format;
use crate::lost::Lost;
use crate::stl::StlColors;
use std::path::PathBuf;

/// Options of the writers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct WriteOptions {
    /// The format. By default the extension names it.
    pub format: Option<Format>,
    /// Text, or binary in one of two byte orders.
    pub encoding: Encoding,
    /// The width of floating-point numbers in PLY.
    pub precision: Precision,
    /// Whether a material library or picture of an OBJ file may replace a file that was not written with the
    /// same OBJ file before. If not, such a file is an error
    /// ([`WriteError::Companion`](crate::WriteError::Companion)).
    pub overwrite_companions: bool,
    /// Where binary STL has the colours of faces.
    pub stl_colors: StlColors,
    /// How the data of a glTF or GLB file are compressed.
    pub compression: Compression,
    /// Whether the data of vertices in a glTF or GLB file become integers, and of how many bits.
    pub quantization: Option<Quantization>,
}

/// The numbers of bits of vertex data that become integers (`KHR_mesh_quantization`). Colours and weights of skins have
/// 8 bits, the weights of a vertex with the sum 255.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Quantization {
    /// Bits of each coordinate of a position, from 8 to 16. They cover the longest side of the bounding box of all
    /// meshes that are drawn in the same place.
    pub positions: u8,
    /// Bits of texture coordinates between 0 and 1, from 8 to 16. Coordinates down to -1 take one bit for the sign;
    /// those beyond stay as they are.
    pub texture_coordinates: u8,
    /// Bits of each component of normals and tangents, with the sign, from 4 to 16.
    pub normals: u8,
}

impl Default for Quantization {
    fn default() -> Self {
        Self { positions: 16, texture_coordinates: 16, normals: 8 }
    }
}

impl Quantization {
    /// Positions and texture coordinates of a number of bits, which must be from 8 to 16.
    #[must_use]
    pub fn with_bits(bits: u8) -> Self {
        Self { positions: bits, texture_coordinates: bits, ..Self::default() }
    }

    /// Checks that all numbers are in range.
    pub(crate) fn check(&self) -> Result<(), WriteError> {
        let Self { positions, texture_coordinates, normals } = *self;
        for (what, bits, least) in [
            ("positions", positions, 8),
            ("texture coordinates", texture_coordinates, 8),
            ("normals", normals, 4),
        ] {
            if !(least..=16).contains(&bits) {
                return Err(WriteError::Bits { what, bits, least });
            }
        }
        Ok(())
    }
}

/// The compression of the data of a glTF or GLB file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Compression {
    /// None.
    #[default]
    None,
    /// The extension `EXT_meshopt_compression`, which readers of the file must know. All values are the same, in an
    /// order that vertex caches like.
    Meshopt,
}

/// Text or binary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Encoding {
    /// The usual one of the format: binary for PLY (little-endian) and STL, text for OFF.
    #[default]
    Usual,
    /// Text.
    Text,
    /// Binary, the least significant byte first (PLY, STL).
    LittleEndian,
    /// Binary, the most significant byte first (PLY, OFF).
    BigEndian,
}

impl Encoding {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Usual => "its usual encoding",
            Self::Text => "text",
            Self::LittleEndian => "little-endian binary",
            Self::BigEndian => "big-endian binary",
        }
    }
}

/// The width of floating-point numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Precision {
    /// Exact: named numbers keep their type. Positions have 32 bits if that is exact for all of them, else 64.
    #[default]
    Exact,
    /// 32 bits.
    Single,
    /// 64 bits.
    Double,
}

/// The result of writing a file.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct WriteReport {
    /// Largest error of a coordinate in model units, from rounding to 32 bits. Zero if positions are exact. With a
    /// [`Quantization`], the largest distance by which a vertex moves, in units of the scene.
    pub rounding: f64,
    /// The data that the [`Quantization`] leaves as they are, with the reason.
    pub stayed: Vec<String>,
    /// The content of the model that is not in the file.
    pub lost: Vec<Lost>,
    /// The files written beside the target: material library and pictures.
    pub companions: Vec<PathBuf>,
    /// The material libraries that were there before and were not changed.
    pub kept: Vec<PathBuf>,
}
