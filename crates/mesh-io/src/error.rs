//! Errors of reading and writing, with their locations.

use crate::text::{brief, printable};
use crate::{Format, ModelError};
use std::fmt;
use std::path::{Path, PathBuf};

/// The error of a file that could not be read.
#[derive(Debug, thiserror::Error)]
#[error("{}{kind}", prefix(path.as_deref()))]
pub struct ReadError {
    /// The file, if the source was a file.
    pub path: Option<PathBuf>,
    /// The kind of error.
    pub kind: ReadErrorKind,
}

impl ReadError {
    /// The error with the path of the file, if it has none.
    #[must_use]
    pub fn at_path(mut self, path: &Path) -> Self {
        self.path.get_or_insert_with(|| path.to_owned());
        self
    }

    /// The location of the error in the file, if it has one.
    #[must_use]
    pub fn location(&self) -> Option<&Location> {
        match &self.kind {
            ReadErrorKind::Malformed { at, .. }
            | ReadErrorKind::Unsupported { at, .. }
            | ReadErrorKind::MissingResource { at, .. }
            | ReadErrorKind::Memory { at, .. } => Some(at),
            _ => None,
        }
    }
}

impl From<ReadErrorKind> for ReadError {
    fn from(kind: ReadErrorKind) -> Self {
        Self { path: None, kind }
    }
}

fn prefix(path: Option<&Path>) -> String {
    path.map(|path| format!("{}: ", shown(path))).unwrap_or_default()
}

/// A path that is safe to print: other people can choose names of files.
pub(crate) fn shown(path: &Path) -> String {
    printable(&path.display().to_string()).into_owned()
}

/// The kind of a read error.
///
/// The texts in the fields may come from the file; `Display` makes them printable.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadErrorKind {
    /// The file could not be opened or read.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// Neither the content nor the extension belongs to a known format.
    #[error(
        "not a known mesh format: the content starts with {found}; expected OBJ, PLY, STL, OFF, glTF or GLB (name the format if the file is one of these)"
    )]
    UnknownFormat {
        /// The start of the content.
        found: String,
    },
    /// The format is known, but not enabled in this build of the crate.
    #[error(
        "this build cannot read or write {0}: enable the cargo feature of that name in mesh-io"
    )]
    FormatDisabled(Format),
    /// The content breaks the rules of its format.
    #[error("{at}: expected {}, found {}", brief(expected), brief(found))]
    Malformed {
        /// The location.
        at: Location,
        /// The content that the format requires there.
        expected: String,
        /// The actual content.
        found: String,
    },
    /// The content is valid, but uses a feature that this crate does not read.
    #[error("{at}: {} is not supported; {cure}", brief(what))]
    Unsupported {
        /// The location.
        at: Location,
        /// The feature.
        what: String,
        /// What the user can do.
        cure: &'static str,
    },
    /// A file that this one refers to cannot be read.
    #[error("{at}: cannot read the file it refers to, \"{}\": {}", brief(uri), brief(reason))]
    MissingResource {
        /// The location of the reference.
        at: Location,
        /// The reference.
        uri: String,
        /// The reason why it cannot be read.
        reason: String,
    },
    /// The content needs more memory than a file of its size may use: a scene that draws the same meshes very often, or
    /// a malicious file.
    #[error(
        "{at}: the content needs {}, more than the {} MiB that a file of this size may take; allow it with --max-memory {}MiB",
        need(at, *needed), mebibytes(*limit), enough(at, *needed)
    )]
    Memory {
        /// The location at which the limit is exceeded.
        at: Location,
        /// The bytes needed up to there; for a glTF scene, for the whole scene.
        needed: u64,
        /// The allowed number of bytes.
        limit: u64,
    },
    /// The content has neither a vertex nor a face.
    #[error(
        "the file has no vertex and no face{}; if it may be empty, allow it with --allow-empty",
        because(notes)
    )]
    Empty {
        /// Content that the reader has skipped.
        notes: Vec<String>,
    },
    /// The mesh is larger than 32-bit indices can address.
    #[error(transparent)]
    TooManyCorners(#[from] mesh_core::soup::TooManyCorners),
}

fn mebibytes(bytes: u64) -> u64 {
    bytes.div_ceil(1 << 20)
}

/// For a scene the total need is known; for other content, only the need so far.
fn need(at: &Location, needed: u64) -> String {
    let more = if is_in_all(at) { "" } else { "more than " };
    format!("{more}{} MiB of memory", mebibytes(needed))
}

/// The limit to suggest, large enough to avoid repeated failures.
fn enough(at: &Location, needed: u64) -> u64 {
    mebibytes(if is_in_all(at) { needed } else { needed.saturating_mul(2) })
}

fn is_in_all(at: &Location) -> bool {
    matches!(at, Location::Json(_))
}

fn because(notes: &[String]) -> String {
    notes.first().map(|note| format!(" ({})", brief(note))).unwrap_or_default()
}

impl ReadErrorKind {
    pub(crate) fn malformed(
        at: Location,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::Malformed { at, expected: expected.into(), found: found.into() }
    }
}

/// A location in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Location {
    /// A line of a text file, counted from one.
    Line(u64),
    /// An offset into a binary file, counted from zero.
    Byte(u64),
    /// A value of a glTF document, such as `meshes[0].primitives[1].indices`.
    Json(String),
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Json(path) => f.write_str(&brief(path)),
        }
    }
}

/// The error of a model that could not be written. The target is unchanged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The target or its folder cannot be written.
    #[error("{}{source}", prefix(path.as_deref()))]
    Io {
        /// The file, if the target was a file.
        path: Option<PathBuf>,
        /// The cause.
        source: std::io::Error,
    },
    /// The target exists and is write-protected.
    #[error("{}: the file is read-only; make it writable or choose another target", shown(.0))]
    ReadOnly(PathBuf),
    /// A companion file exists that would be replaced, and is not known to be from an earlier run of the same output.
    #[error(
        "{}: this companion of the output would be replaced, but it {why}; move it away, write to another folder, or allow it with `overwrite_companions`",
        shown(path)
    )]
    Companion {
        /// The existing file.
        path: PathBuf,
        /// The reason for the rejection.
        why: &'static str,
    },
    /// The model refers to the target as its picture or material library, which the output would replace.
    #[error(
        "{}: the model refers to this file as its {what}, and the output would replace it; choose another name",
        shown(path)
    )]
    OwnCompanion {
        /// The target.
        path: PathBuf,
        /// What the model takes it for.
        what: &'static str,
    },
    /// The extension does not belong to a known format.
    #[error(
        "{}: the extension names no format; use .obj, .ply, .stl, .off, .gltf or .glb, or name the format",
        shown(.0)
    )]
    UnknownExtension(PathBuf),
    /// The format is known, but not enabled in this build of the crate.
    #[error("this build cannot write {0}: enable the cargo feature of that name in mesh-io")]
    FormatDisabled(Format),
    /// The format has no such encoding.
    #[error("{format} cannot be written as {encoding}; leave the encoding to the format")]
    NoSuchEncoding {
        /// The format.
        format: Format,
        /// The requested encoding.
        encoding: &'static str,
    },
    /// A number of bits is out of range.
    #[error("{what} cannot have {bits} bits; take {least} to 16")]
    Bits {
        /// The data.
        what: &'static str,
        /// The number of bits.
        bits: u8,
        /// The least number of bits.
        least: u8,
    },
    /// The format has no integers for the data of vertices.
    #[error("{0} cannot be quantized; write glTF or GLB, or leave the quantization out")]
    NoQuantization(Format),
    /// The format cannot be compressed.
    #[error("{0} cannot be compressed; write glTF or GLB, or leave the compression out")]
    NoCompression(Format),
    /// The format cannot hold a coordinate that is not a finite number.
    #[error(
        "vertex {vertex} has the coordinate {value}, which {format} cannot hold; remove the vertex, or write OBJ or PLY"
    )]
    NotFinite {
        /// The format.
        format: Format,
        /// The vertex.
        vertex: usize,
        /// Its coordinate.
        value: f64,
    },
    /// A finite coordinate is beyond the range of the 32-bit numbers that the file holds.
    #[error(
        "vertex {vertex} has the coordinate {value:e}, beyond what 32-bit numbers in {format} can hold; scale the mesh, or write OBJ or PLY with 64 bits"
    )]
    OutOfSingleRange {
        /// The format.
        format: Format,
        /// The vertex.
        vertex: usize,
        /// Its coordinate.
        value: f64,
    },
    /// The model exceeds the size fields of the format.
    #[error("{format} can hold no more than {limit} {what}, the model has {found}")]
    TooLarge {
        /// The format.
        format: Format,
        /// The elements that are too many.
        what: &'static str,
        /// The limit of the format.
        limit: u64,
        /// The actual number.
        found: u64,
    },
    /// The format cannot be written from a stream.
    #[error("{0} cannot be written as a stream; write PLY, STL or OBJ")]
    NoPassing(Format),
    /// The format does not hold scenes.
    #[error("{0} holds no scenes; write glTF or GLB")]
    NoScene(Format),
    /// New vertices of a scene do not fit the mesh that they are for.
    #[error("{}", brief(.0))]
    Scene(String),
    /// The format does not support levels of detail.
    #[error("{0} holds no levels of detail; write glTF or GLB, or a file for each level")]
    NoLevels(Format),
    /// The screen coverage of a level of detail is not a non-negative number.
    #[error(
        "level {level} is to be shown from {value} of the screen up; give a finite number, not below zero"
    )]
    Coverage {
        /// The level.
        level: usize,
        /// The number given.
        value: f64,
    },
    /// The model is inconsistent.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl WriteError {
    /// Adds the path of the file, if the error has none.
    pub(crate) fn in_file(self, path: &Path) -> Self {
        match self {
            Self::Io { path: None, source } => Self::Io { path: Some(path.to_owned()), source },
            other => other,
        }
    }
}

impl From<std::io::Error> for WriteError {
    fn from(source: std::io::Error) -> Self {
        Self::Io { path: None, source }
    }
}
