//! What can go wrong while reading and writing, and where.

use crate::text::{brief, printable};
use crate::{Format, ModelError};
use std::fmt;
use std::path::{Path, PathBuf};

/// Why a file could not be read.
#[derive(Debug, thiserror::Error)]
#[error("{}{kind}", prefix(path.as_deref()))]
pub struct ReadError {
    /// The file, when reading from one.
    pub path: Option<PathBuf>,
    /// What is wrong with it.
    pub kind: ReadErrorKind,
}

impl ReadError {
    pub(crate) fn at_path(mut self, path: &Path) -> Self {
        self.path.get_or_insert_with(|| path.to_owned());
        self
    }

    /// Where in the file the fault is, when it is in a particular place.
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

/// A path as it may be shown: names of files are made by others too.
pub(crate) fn shown(path: &Path) -> String {
    printable(&path.display().to_string()).into_owned()
}

/// What is wrong with a file.
///
/// The texts in the fields may be those of the file; what `Display` makes of them is printable.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadErrorKind {
    /// The file could not be opened or read.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// Neither the content nor the extension is that of a known format.
    #[error(
        "not a known mesh format: the content starts with {found}; expected OBJ, PLY, STL, OFF, glTF or GLB (name the format if the file is one of these)"
    )]
    UnknownFormat {
        /// How the content starts.
        found: String,
    },
    /// The format is known, but this build of the crate leaves it out.
    #[error(
        "this build cannot read or write {0}: enable the cargo feature of that name in mesh-io"
    )]
    FormatDisabled(Format),
    /// The content breaks the rules of its format.
    #[error("{at}: expected {}, found {}", brief(expected), brief(found))]
    Malformed {
        /// Where.
        at: Location,
        /// What the format wants there.
        expected: String,
        /// What is there instead.
        found: String,
    },
    /// The content is legal, but uses something that this crate does not read.
    #[error("{at}: {} is not supported; {cure}", brief(what))]
    Unsupported {
        /// Where.
        at: Location,
        /// The feature.
        what: String,
        /// What the owner of the file can do.
        cure: &'static str,
    },
    /// A file that this one refers to cannot be read.
    #[error("{at}: cannot read the file it refers to, \"{}\": {}", brief(uri), brief(reason))]
    MissingResource {
        /// Where the reference is.
        at: Location,
        /// The reference.
        uri: String,
        /// Why it cannot be read.
        reason: String,
    },
    /// The content takes more memory than a file of its size may: a scene that draws the same
    /// meshes very often, or a file that is made to use up memory.
    #[error(
        "{at}: the content needs {}, more than the {} MiB that a file of this size may take; allow it with --max-memory {}MiB",
        need(at, *needed), mebibytes(*limit), enough(at, *needed)
    )]
    Memory {
        /// Where the limit is passed.
        at: Location,
        /// The bytes needed up to there; for a glTF scene, those of the whole scene.
        needed: u64,
        /// The bytes that may be taken.
        limit: u64,
    },
    /// The content has neither a vertex nor a face.
    #[error(
        "the file has no vertex and no face{}; if it may be empty, allow it with --allow-empty",
        because(notes)
    )]
    Empty {
        /// What the reader passed over.
        notes: Vec<String>,
    },
    /// The mesh is larger than 32-bit indices can address.
    #[error(transparent)]
    TooManyCorners(#[from] mesh_core::soup::TooManyCorners),
}

fn mebibytes(bytes: u64) -> u64 {
    bytes.div_ceil(1 << 20)
}

/// A scene says what it needs in all; other content, what it needs so far.
fn need(at: &Location, needed: u64) -> String {
    let more = if is_in_all(at) { "" } else { "more than " };
    format!("{more}{} MiB of memory", mebibytes(needed))
}

/// What to allow, so that it need not be asked for again and again.
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

/// A place in a file.
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

/// Why a model could not be written. The target is then as it was before.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The target or its folder cannot be written.
    #[error("{}{source}", prefix(path.as_deref()))]
    Io {
        /// The file, when writing to one.
        path: Option<PathBuf>,
        /// The cause.
        source: std::io::Error,
    },
    /// The target exists and is write-protected.
    #[error("{}: the file is read-only; make it writable or choose another target", shown(.0))]
    ReadOnly(PathBuf),
    /// A file beside the target would have to be replaced that is not known to be from an earlier
    /// run of the same output.
    #[error(
        "{}: this companion of the output would be replaced, but it {why}; move it away, write to another folder, or allow it with `overwrite_companions`",
        shown(path)
    )]
    Companion {
        /// The file that is in the way.
        path: PathBuf,
        /// What is wrong with it.
        why: &'static str,
    },
    /// The extension is not that of a known format.
    #[error(
        "{}: the extension names no format; use .obj, .ply, .stl, .off, .gltf or .glb, or name the format",
        shown(.0)
    )]
    UnknownExtension(PathBuf),
    /// The format is known, but this build of the crate leaves it out.
    #[error("this build cannot write {0}: enable the cargo feature of that name in mesh-io")]
    FormatDisabled(Format),
    /// The format has no such encoding.
    #[error("{format} cannot be written as {encoding}; leave the encoding to the format")]
    NoSuchEncoding {
        /// The format.
        format: Format,
        /// The encoding asked for.
        encoding: &'static str,
    },
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
    /// The format's size fields are too small for the model.
    #[error("{format} can hold no more than {limit} {what}, the model has {found}")]
    TooLarge {
        /// The format.
        format: Format,
        /// What there is too much of.
        what: &'static str,
        /// How much the format holds.
        limit: u64,
        /// How much there is.
        found: u64,
    },
    /// The format cannot be written from what passes by.
    #[error("{0} cannot be written as a stream; write PLY, STL or OBJ")]
    NoPassing(Format),
    /// The format holds no levels of detail.
    #[error("{0} holds no levels of detail; write glTF or GLB, or a file for each level")]
    NoLevels(Format),
    /// The part of the screen at which a level of detail is to be shown is no number from zero up.
    #[error(
        "level {level} is to be shown from {value} of the screen up; give a finite number, not below zero"
    )]
    Coverage {
        /// The level.
        level: usize,
        /// The number given.
        value: f64,
    },
    /// The model contradicts itself.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl WriteError {
    /// With the file that it is about, if it does not say.
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
