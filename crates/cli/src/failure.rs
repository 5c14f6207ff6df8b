//! Failures, as text and as JSON, and their exit codes.

use std::path::{Path, PathBuf};

use mesh_core::build::BuildError;
use mesh_io::{Location, ReadError, ReadErrorKind, WriteError};
use mesh_metric::SurfaceError;
use mesh_work::SceneError;
use serde::Serialize;
use simplify::{RecordError, ReplayError, SimplifyError};

use crate::counted::counted;
use crate::text::printable;

#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{0}")]
    Read(Box<ReadError>),
    #[error("{}: {source}", path.display())]
    Folder { path: PathBuf, source: std::io::Error },
    #[error("{}: there is no mesh file in this folder; name files, or a folder with some", .0.display())]
    NoFiles(PathBuf),
    #[error("{}: {}{}", path.display(), as_options(&source.to_string()), if *joined && !is_malformed(source) { JOINED } else { "" })]
    Build {
        path: PathBuf,
        source: Box<BuildError>,
        /// Whether vertices at equal positions were joined without being asked for.
        joined: bool,
    },
    #[error(
        "{}: the repairs leave nothing of it; weld within a smaller distance, or allow it with --allow-empty",
        .0.display()
    )]
    NothingLeft(PathBuf),
    #[error(
        "{}: it has {} and no faces, but this takes a surface; `info`, `convert`, `distance` and `view` take points, and --allow-empty passes them on",
        path.display(),
        counted(*points, "points")
    )]
    NoFaces { path: PathBuf, points: usize },
    #[error(
        "{}: it has points or lines and no faces, but this takes a surface; `convert` keeps it, and --allow-empty passes it on",
        .0.display()
    )]
    OnlyLines(PathBuf),
    #[error("{}: {source}", path.display())]
    Surface { path: PathBuf, source: Box<SurfaceError> },
    #[error("{0}")]
    Simplify(Box<SimplifyError>),
    #[error("{}: {source}", path.display())]
    Record { path: PathBuf, source: Box<RecordError> },
    #[error("the record does not fit the mesh: {0}")]
    Replay(Box<ReplayError>),
    #[error("cannot write {}: {}", path.display(), overwriting(&source.to_string()))]
    Write { path: PathBuf, source: Box<WriteError> },
    /// The content is inconsistent, which is a defect of this program.
    #[error("the mesh and its attributes do not fit: {0}")]
    Model(Box<mesh_io::ModelError>),
    #[error("{0}")]
    Usage(String),
    /// The mesh cannot be processed as asked.
    #[error("{0}")]
    Refused(String),
    /// A mesh larger than memory could not be processed.
    #[error("{0}")]
    Regions(Box<out_of_core::Error>),
    #[error("cannot make a JSON object: {0}")]
    Json(Box<serde_json::Error>),
    #[error("cannot write to the standard output: {0}")]
    Stdout(std::io::Error),
    #[error("cannot start threads: {0}")]
    Threads(std::io::Error),
    /// A defect of this program that occurred in one of many files.
    #[error("the program has a defect that this file shows: {0}")]
    Panic(String),
}

const JOINED: &str = "; vertices at equal positions were joined, --weld none leaves them apart";

/// A failure as a JSON object.
#[derive(Debug, Serialize)]
pub(crate) struct Described {
    /// The kind of failure; see [`Failure::code`].
    code: &'static str,
    /// The exit code of the program.
    exit_code: u8,
    message: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    place: Option<Place>,
    /// Options that may help.
    #[serde(skip_serializing_if = "Option::is_none")]
    cure: Option<String>,
}

/// The place of the failure, as far as it is known.
#[derive(Debug, Default, Serialize)]
struct Place {
    file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    byte: Option<u64>,
    /// A value of a glTF document.
    #[serde(skip_serializing_if = "Option::is_none")]
    value: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vertex: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    face: Option<u32>,
    /// The ends of an edge.
    #[serde(skip_serializing_if = "Option::is_none")]
    edge: Option<[u32; 2]>,
}

impl Place {
    fn file(path: &Path) -> Self {
        Self { file: path.display().to_string(), ..Self::default() }
    }
}

impl Failure {
    /// A scene of which no mesh with triangles is left; `faces` is the number of faces that it had.
    pub(crate) fn no_mesh_left(path: &Path, faces: usize) -> Self {
        let failure = if faces == 0 { Self::OnlyLines } else { Self::NothingLeft };
        failure(path.to_owned())
    }

    pub(crate) fn json(source: serde_json::Error) -> Self {
        Self::Json(Box::new(source))
    }

    pub(crate) fn model(source: mesh_io::ModelError) -> Self {
        Self::Model(Box::new(source))
    }

    pub(crate) fn refused(reason: impl std::fmt::Display) -> Self {
        Self::Refused(reason.to_string())
    }

    pub(crate) fn usage(reason: impl std::fmt::Display) -> Self {
        Self::Usage(reason.to_string())
    }

    pub(crate) fn simplify(source: SimplifyError) -> Self {
        Self::Simplify(Box::new(source))
    }

    /// A failure with a scene that is read from one file and written to another.
    pub(crate) fn scene(input: &Path, output: Option<&Path>, source: SceneError) -> Self {
        let path = input.to_owned();
        match source {
            SceneError::Read(error) => Self::Read(Box::new(error.at_path(input))),
            SceneError::Build { source, .. } => Self::Build { path, source, joined: false },
            SceneError::Simplify { source, .. } => Self::simplify(source),
            SceneError::Surface(source) => Self::Surface { path, source: Box::new(source) },
            SceneError::Model(source) => Self::model(source),
            SceneError::Write(source) => Self::write(output.unwrap_or(input), source),
            other => Self::refused(other),
        }
    }

    /// A failure with a mesh larger than memory. Errors in the input file are reported as errors of the input.
    pub(crate) fn regions(source: out_of_core::Error) -> Self {
        match source {
            out_of_core::Error::Read(error) => Self::Read(Box::new(error)),
            out_of_core::Error::Simplify(error) => Self::simplify(error),
            other => Self::Regions(Box::new(other)),
        }
    }

    pub(crate) fn pool(source: rayon::ThreadPoolBuildError) -> Self {
        Self::Threads(std::io::Error::other(source))
    }

    pub(crate) fn write(path: &Path, source: impl Into<WriteError>) -> Self {
        Self::Write { path: path.to_owned(), source: Box::new(source.into()) }
    }

    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Read(_)
            | Self::Folder { .. }
            | Self::NoFiles(_)
            | Self::Record { .. }
            | Self::Replay(_) => 3,
            Self::Build { source, .. } if is_malformed(source) => 3,
            Self::Simplify(error)
                if matches!(
                    **error,
                    SimplifyError::Option { .. } | SimplifyError::Conflict { .. }
                ) =>
            {
                2
            }
            Self::Write { source, .. } => match **source {
                WriteError::NoSuchEncoding { .. }
                | WriteError::UnknownExtension(_)
                | WriteError::NoCompression(_)
                | WriteError::NoQuantization(_)
                | WriteError::Bits { .. }
                | WriteError::NoLevels(_)
                | WriteError::NoScene(_) => 2,
                WriteError::NotFinite { .. }
                | WriteError::OutOfSingleRange { .. }
                | WriteError::TooLarge { .. }
                | WriteError::Scene(_) => 4,
                _ => 1,
            },
            Self::Regions(error) => match **error {
                out_of_core::Error::NotFinite { .. }
                | out_of_core::Error::NoSuchVertex { .. }
                | out_of_core::Error::Damaged { .. } => 3,
                out_of_core::Error::OtherRun { .. }
                | out_of_core::Error::NotEmpty { .. }
                | out_of_core::Error::TooLittleMemory { .. }
                | out_of_core::Error::Unsupported(..) => 2,
                out_of_core::Error::Io { .. } | out_of_core::Error::Write(_) => 1,
                _ => 4,
            },
            Self::Build { .. }
            | Self::NothingLeft(_)
            | Self::OnlyLines(_)
            | Self::NoFaces { .. }
            | Self::Surface { .. }
            | Self::Simplify(_)
            | Self::Refused(_) => 4,
            Self::Model(_)
            | Self::Json(_)
            | Self::Stdout(_)
            | Self::Threads(_)
            | Self::Panic(_) => 1,
        }
    }

    /// A word for the kind of failure, for programs.
    fn code(&self) -> &'static str {
        match self {
            Self::Read(error) => match &error.kind {
                ReadErrorKind::Io(_) => "unreadable",
                ReadErrorKind::UnknownFormat { .. } => "unknown-format",
                ReadErrorKind::Unsupported { .. } => "unsupported",
                ReadErrorKind::MissingResource { .. } => "missing-resource",
                ReadErrorKind::Memory { .. } => "memory",
                ReadErrorKind::Empty { .. } => "empty",
                _ => "malformed",
            },
            Self::Folder { .. } => "unreadable",
            Self::NoFiles(_) => "no-files",
            Self::NothingLeft(_) | Self::OnlyLines(_) | Self::NoFaces { .. } => "empty",
            Self::Record { .. } | Self::Replay(_) => "record",
            Self::Build { source, .. } => match **source {
                BuildError::TooManyElements { .. } => "too-large",
                BuildError::InvalidWeldDistance { .. } => "usage",
                BuildError::NonFiniteCoordinate { .. } => "not-finite",
                BuildError::IndexOutOfRange { .. } => "index-out-of-range",
                BuildError::TooFewCorners { .. } | BuildError::RepeatedVertex { .. } => {
                    "degenerate-face"
                }
                BuildError::DuplicateFace { .. } => "duplicate-face",
                BuildError::NonManifoldEdge { .. } => "non-manifold-edge",
                BuildError::InconsistentOrientation { .. } => "inconsistent-orientation",
                BuildError::NonOrientable { .. } => "non-orientable",
                BuildError::PinchedVertex { .. } => "pinched-vertex",
                _ => "not-a-mesh",
            },
            Self::Regions(error) => match **error {
                out_of_core::Error::NotFinite { .. } => "not-finite",
                out_of_core::Error::NoSuchVertex { .. } => "index-out-of-range",
                out_of_core::Error::Degenerate { .. } => "degenerate-face",
                out_of_core::Error::NotManifold { .. } => "not-a-mesh",
                out_of_core::Error::RegionTooLarge { .. } => "too-large",
                out_of_core::Error::Damaged { .. } => "damaged",
                out_of_core::Error::OtherRun { .. }
                | out_of_core::Error::NotEmpty { .. }
                | out_of_core::Error::TooLittleMemory { .. }
                | out_of_core::Error::Unsupported(..) => "usage",
                out_of_core::Error::Io { .. } | out_of_core::Error::Write(_) => "cannot-write",
                _ => "cannot-be-done",
            },
            Self::Write { .. } if self.exit_code() == 4 => "does-not-fit-format",
            Self::Usage(_) => "usage",
            Self::Simplify(_) | Self::Write { .. } if self.exit_code() == 2 => "usage",
            Self::Write { source, .. } if is_companion(source) => "companion",
            Self::Surface { .. } | Self::Simplify(_) | Self::Refused(_) => "cannot-be-done",
            Self::Write { .. } | Self::Stdout(_) => "cannot-write",
            Self::Model(_) | Self::Json(_) | Self::Threads(_) | Self::Panic(_) => "internal",
        }
    }

    fn place(&self) -> Option<Place> {
        match self {
            Self::Read(error) => {
                let mut place = Place::file(error.path.as_deref()?);
                match error.location() {
                    Some(Location::Line(line)) => place.line = Some(*line),
                    Some(Location::Byte(byte)) => place.byte = Some(*byte),
                    Some(Location::Json(value)) => place.value = Some(value.clone()),
                    _ => {}
                }
                Some(place)
            }
            Self::Build { path, source, .. } => {
                let mut place = Place::file(path);
                match &**source {
                    BuildError::NonFiniteCoordinate { vertex, .. }
                    | BuildError::PinchedVertex { vertex, .. } => place.vertex = Some(*vertex),
                    BuildError::IndexOutOfRange { face, .. }
                    | BuildError::TooFewCorners { face, .. }
                    | BuildError::RepeatedVertex { face, .. }
                    | BuildError::DuplicateFace { face, .. } => place.face = Some(*face),
                    BuildError::NonManifoldEdge { edge, .. }
                    | BuildError::InconsistentOrientation { edge, .. }
                    | BuildError::NonOrientable { edge, .. } => place.edge = Some([edge.0, edge.1]),
                    _ => {}
                }
                Some(place)
            }
            Self::Folder { path, .. }
            | Self::NoFiles(path)
            | Self::NothingLeft(path)
            | Self::OnlyLines(path)
            | Self::NoFaces { path, .. }
            | Self::Surface { path, .. }
            | Self::Record { path, .. }
            | Self::Write { path, .. } => Some(Place::file(path)),
            _ => None,
        }
    }

    fn cure(&self) -> Option<String> {
        match self {
            Self::Read(error) => match &error.kind {
                ReadErrorKind::Unsupported { cure, .. } => Some((*cure).to_owned()),
                ReadErrorKind::UnknownFormat { .. } => Some("--from FORMAT".into()),
                ReadErrorKind::Memory { .. } => Some("--max-memory BYTES".into()),
                ReadErrorKind::Empty { .. } => Some("--allow-empty".into()),
                _ => None,
            },
            Self::NothingLeft(_) | Self::OnlyLines(_) | Self::NoFaces { .. } => {
                Some("--allow-empty".into())
            }
            Self::Build { source, joined, .. } => {
                let message = source.to_string();
                let repairs = message.split('`').skip(1).step_by(2).map(as_option);
                let mut cures: Vec<String> = repairs.collect();
                if cures.is_empty() {
                    return None;
                }
                cures.push("--lenient".into());
                if *joined {
                    cures.push("--weld none".into());
                }
                Some(cures.join(", "))
            }
            Self::Write { source, .. } if is_companion(source) => Some(OVERWRITE.into()),
            _ => None,
        }
    }

    /// The failure as text: one line, for any content of the file.
    pub(crate) fn message(&self) -> String {
        printable(self)
    }

    /// The failure as JSON.
    pub(crate) fn described(&self) -> Described {
        Described {
            code: self.code(),
            exit_code: self.exit_code(),
            message: self.to_string(),
            place: self.place(),
            cure: self.cure(),
        }
    }
}

/// Whether the file itself is invalid, not only the request.
fn is_malformed(error: &BuildError) -> bool {
    matches!(error, BuildError::NonFiniteCoordinate { .. } | BuildError::TooManyElements { .. })
}

/// Whether a file beside the output must not be replaced.
fn is_companion(error: &WriteError) -> bool {
    matches!(error, WriteError::Companion { .. })
}

/// The option that allows replacing it.
const OVERWRITE: &str = "--overwrite-companions";

/// Replaces the name of that option in a message of the library by the command-line option.
fn overwriting(message: &str) -> String {
    message.replace("`overwrite_companions`", OVERWRITE)
}

/// The command-line option for a repair of the library.
fn as_option(repair: &str) -> String {
    format!("--{}", repair.replace('_', "-"))
}

/// Replaces the names of repairs in backticks in a message of the library by command-line options.
fn as_options(message: &str) -> String {
    let parts = message.split('`').enumerate();
    let text: String =
        parts.map(|(i, part)| if i % 2 == 1 { as_option(part) } else { part.to_owned() }).collect();
    if text.contains("--") { format!("{text} (--lenient allows all repairs)") } else { text }
}

#[cfg(test)]
mod tests {
    use super::as_options;

    #[test]
    fn repairs_are_named_as_options() {
        assert_eq!(
            as_options("bad; `drop_degenerate` drops it"),
            "bad; --drop-degenerate drops it (--lenient allows all repairs)"
        );
        assert_eq!(as_options("bad"), "bad");
    }
}
