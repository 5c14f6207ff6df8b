//! How a file is to be written, and what came of it.

use crate::format::Format;
use std::path::PathBuf;

/// How to write.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct WriteOptions {
    /// The format; told by the extension when absent.
    pub format: Option<Format>,
    /// Text or binary.
    pub encoding: Encoding,
    /// The width of the numbers in PLY.
    pub precision: Precision,
    /// Whether a material library or picture that has to be written beside an OBJ file may replace
    /// a file that is no companion of it from an earlier run. Otherwise such a file is an error
    /// ([`WriteError::Companion`](crate::WriteError::Companion)).
    pub overwrite_companions: bool,
}

/// Text or binary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Encoding {
    /// What is usual for the format: binary for PLY (little-endian) and STL, text for OFF.
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
    /// 32 bits for numbers that all fit, 64 bits otherwise: nothing is lost.
    #[default]
    Exact,
    /// 32 bits.
    Single,
    /// 64 bits.
    Double,
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct WriteReport {
    /// The largest distance, along one axis, between a position and what the file holds, in model
    /// units: the price of 32-bit coordinates. Zero where positions are exact.
    pub rounding: f64,
    /// What the format has no place for, in words.
    pub dropped: Vec<String>,
    /// The files beside the target that were written with it: material library and pictures.
    pub companions: Vec<PathBuf>,
    /// The material libraries that were beside the target already and stay as they were.
    pub kept: Vec<PathBuf>,
}
