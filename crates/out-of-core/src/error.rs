//! What can go wrong with a mesh on disk.

use std::path::{Path, PathBuf};

use mesh_io::{ReadError, WriteError};
use simplify::SimplifyError;

/// Why a step could not be done. What it was to write is not there, or as it was.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The input cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// An output cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file of the work folder cannot be opened, read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A file of the work folder is not what a step before this one has written.
    #[error("{}: {reason}; remove it, and do the step that makes it again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The work folder is that of another run.
    #[error(
        "{}: this folder belongs to a run with another {what}; take another folder, or remove this one",
        path.display()
    )]
    OtherRun {
        /// The folder.
        path: PathBuf,
        /// What differs.
        what: &'static str,
    },
    /// The work folder holds files of others.
    #[error("{}: this folder holds other files; name a new one, or an empty one", path.display())]
    NotEmpty {
        /// The folder.
        path: PathBuf,
    },
    /// A coordinate is not finite.
    #[error(
        "vertex {vertex} has a coordinate that is not finite: {position:?}; remove it from the file"
    )]
    NotFinite {
        /// The vertex, counted from zero; of formats without vertices, the corner.
        vertex: u64,
        /// Where it is said to be.
        position: [f64; 3],
    },
    /// A face refers to a vertex that is not there.
    #[error("face {face} uses vertex {vertex}, of which there are only {count}")]
    NoSuchVertex {
        /// The face, counted from zero.
        face: u64,
        /// The vertex, counted from zero.
        vertex: u64,
        /// The number of vertices.
        count: u64,
    },
    /// A face uses a vertex twice.
    #[error(
        "a face uses vertex {vertex} twice; allow such faces to be dropped with --drop-degenerate or --lenient"
    )]
    Degenerate {
        /// The vertex, counted from zero.
        vertex: u64,
    },
    /// The surface is not manifold at a vertex.
    #[error(
        "the surface is not an oriented manifold at vertex {vertex}; allow it to be cut there with --lenient"
    )]
    NotManifold {
        /// The vertex, counted from zero.
        vertex: u64,
    },
    /// The surface that is left cannot be made one mesh.
    #[error(transparent)]
    Build(Box<mesh_core::BuildError>),
    /// Regions that are to be joined know of vertices that their neighbours do not have.
    #[error(
        "the region of cell {cell} does not fit that of cell {other}: they are not of the same run"
    )]
    DoNotFit {
        /// A cell.
        cell: u32,
        /// Its neighbour.
        other: u32,
    },
    /// A region is too large for numbers of 32 bits.
    #[error(
        "a region has {faces} faces, more than numbers of 32 bits can tell apart: too many vertices are in the same place"
    )]
    RegionTooLarge {
        /// Its faces.
        faces: u64,
    },
    /// The memory that may be taken is too small to work in.
    #[error("{given} bytes of memory are too few to work in; allow at least {least}")]
    TooLittleMemory {
        /// The bytes that may be taken.
        given: u64,
        /// Those that are needed at least.
        least: u64,
    },
    /// The options ask for what cannot be done region by region.
    #[error("{0} cannot be done region by region; {1}")]
    Unsupported(&'static str, &'static str),
    /// An option of the simplification makes no sense.
    #[error(transparent)]
    Simplify(#[from] SimplifyError),
    /// A distance cannot be measured.
    #[error(transparent)]
    Surface(#[from] mesh_metric::SurfaceError),
    /// The observer said to stop. What is finished stays, and the run can be resumed.
    #[error("stopped; what is finished is kept in the work folder")]
    Stopped,
}

impl Error {
    pub(crate) fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        |source| Self::Io { path: path.to_owned(), source }
    }

    pub(crate) fn damaged(path: &Path, reason: impl Into<String>) -> Self {
        Self::Damaged { path: path.to_owned(), reason: reason.into() }
    }
}
