//! Errors of work with meshes on disk.

use std::path::{Path, PathBuf};

use mesh_io::{ReadError, WriteError};
use simplify::SimplifyError;

/// Cause of a failed step. Each output of the step is missing, or is the file of an earlier run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The input cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// An output cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file or folder cannot be opened, read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A file of the work folder is not what an earlier step has written.
    #[error("{}: {reason}; remove it, and run the step that makes it again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The defect.
        reason: String,
    },
    /// The folder is no work folder, or its input was not split to the end.
    #[error(
        "{}: there is no run in this folder; name the folder of a run, or split the input again",
        path.display()
    )]
    NoWorkFolder {
        /// The folder.
        path: PathBuf,
    },
    /// Another process works in the folder.
    #[error(
        "{}: another process works in this folder; wait until it has ended, or name another folder",
        path.display()
    )]
    InUse {
        /// The folder.
        path: PathBuf,
    },
    /// The work folder belongs to another run.
    #[error(
        "{}: this folder belongs to a run with another {what}; name another folder, or remove this one",
        path.display()
    )]
    OtherRun {
        /// The folder.
        path: PathBuf,
        /// What differs.
        what: &'static str,
    },
    /// The folder holds files that do not belong to a run.
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
        /// The vertex, counted from zero. In formats without vertices, the corner.
        vertex: u64,
        /// Its position in the file.
        position: [f64; 3],
    },
    /// A face refers to a missing vertex.
    #[error("face {face} uses vertex {vertex}, but there are only {count} vertices")]
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
        "a face uses vertex {vertex} twice; drop such faces with --drop-degenerate or --lenient"
    )]
    Degenerate {
        /// The vertex, counted from zero.
        vertex: u64,
    },
    /// The surface is not manifold at a vertex.
    #[error(
        "the surface is not an oriented manifold at vertex {vertex}; cut it there with --lenient"
    )]
    NotManifold {
        /// The vertex, counted from zero.
        vertex: u64,
    },
    /// The remaining faces cannot be built into one mesh.
    #[error(transparent)]
    Build(Box<mesh_core::BuildError>),
    /// A region refers to vertices that its neighbour does not have.
    #[error(
        "the regions of cells {cell} and {other} do not fit together: they belong to different runs"
    )]
    DoNotFit {
        /// A cell.
        cell: u32,
        /// Its neighbour.
        other: u32,
    },
    /// A region is too large for indices of 32 bits.
    #[error(
        "a region has {faces} faces, too many for indices of 32 bits; allow less memory, so that regions are smaller"
    )]
    RegionTooLarge {
        /// Its faces.
        faces: u64,
    },
    /// The input has more faces than the largest number of regions can hold.
    #[error("{faces} faces are too many for regions of {region_faces} faces; allow more memory")]
    TooManyRegions {
        /// The faces of the input.
        faces: u64,
        /// The faces that a region may have.
        region_faces: u64,
    },
    /// The input has more vertices than the files on disk can number.
    #[error(
        "the input has more than {most} vertices, which is too many to be numbered on disk; split the file"
    )]
    TooManyVertices {
        /// The largest number of vertices.
        most: u64,
    },
    /// The memory limit is too small.
    #[error("{given} bytes of memory are too few; allow at least {least}")]
    TooLittleMemory {
        /// The limit in bytes.
        given: u64,
        /// The smallest sufficient limit.
        least: u64,
    },
    /// The options need the whole mesh.
    #[error("{0} cannot be done region by region; {1}")]
    Unsupported(&'static str, &'static str),
    /// The simplification has failed, or one of its options is out of range.
    #[error(transparent)]
    Simplify(#[from] SimplifyError),
    /// A distance cannot be measured.
    #[error(transparent)]
    Surface(#[from] mesh_metric::SurfaceError),
    /// The observer has ended the run. Finished steps stay, and the run can be resumed.
    #[error("stopped; finished steps are kept in the work folder")]
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
