//! What can go wrong, and the exit code for it.

use std::path::PathBuf;

use mesh_core::build::BuildError;
use mesh_core::edit::CollapseRefusal;
use mesh_io::{ReadError, WriteError};
use mesh_metric::SurfaceError;
use simplify::{RecordError, SimplifyError};

#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{0}")]
    Read(Box<ReadError>),
    #[error("{}: {}", path.display(), as_options(&source.to_string()))]
    Build { path: PathBuf, source: Box<BuildError> },
    #[error("{}: {source}", path.display())]
    Surface { path: PathBuf, source: Box<SurfaceError> },
    #[error("{0}")]
    Simplify(Box<SimplifyError>),
    #[error("{}: {source}", path.display())]
    Record { path: PathBuf, source: Box<RecordError> },
    #[error("the record does not fit the mesh: {0}")]
    Replay(Box<CollapseRefusal>),
    #[error("cannot write {}: {}", path.display(), overwriting(&source.to_string()))]
    Write { path: PathBuf, source: Box<WriteError> },
    /// The content does not fit together, which is a mistake of this program.
    #[error("the mesh and its attributes do not fit: {0}")]
    Model(Box<mesh_io::ModelError>),
    #[error("{0}")]
    Usage(String),
    /// The mesh cannot be processed as asked.
    #[error("{0}")]
    Refused(String),
    #[error("cannot make a JSON object: {0}")]
    Json(Box<serde_json::Error>),
    #[error("cannot write to stdout: {0}")]
    Stdout(std::io::Error),
    #[error("cannot start threads: {0}")]
    Threads(Box<rayon::ThreadPoolBuildError>),
}

impl Failure {
    pub(crate) fn json(source: serde_json::Error) -> Self {
        Self::Json(Box::new(source))
    }

    pub(crate) fn model(source: mesh_io::ModelError) -> Self {
        Self::Model(Box::new(source))
    }

    pub(crate) fn refused(reason: impl std::fmt::Display) -> Self {
        Self::Refused(reason.to_string())
    }

    pub(crate) fn simplify(source: SimplifyError) -> Self {
        Self::Simplify(Box::new(source))
    }

    pub(crate) fn threads(source: rayon::ThreadPoolBuildError) -> Self {
        Self::Threads(Box::new(source))
    }

    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Read(_) | Self::Record { .. } | Self::Replay(_) => 3,
            Self::Build { source, .. } if is_malformed(source) => 3,
            Self::Simplify(error) if matches!(**error, SimplifyError::Option { .. }) => 2,
            Self::Write { source, .. } if is_beyond_format(source) => 4,
            Self::Build { .. } | Self::Surface { .. } | Self::Simplify(_) | Self::Refused(_) => 4,
            Self::Write { .. }
            | Self::Model(_)
            | Self::Json(_)
            | Self::Stdout(_)
            | Self::Threads(_) => 1,
        }
    }
}

/// Whether the file itself is at fault, not only what was asked of it.
fn is_malformed(error: &BuildError) -> bool {
    matches!(error, BuildError::NonFiniteCoordinate { .. } | BuildError::TooManyElements { .. })
}

/// Whether the format of the output cannot hold the mesh.
fn is_beyond_format(error: &WriteError) -> bool {
    matches!(
        error,
        WriteError::NotFinite { .. }
            | WriteError::OutOfSingleRange { .. }
            | WriteError::TooLarge { .. }
    )
}

/// Turns the names of repairs in a message of the library, which stand in backticks, into options
/// of the command line.
fn as_options(message: &str) -> String {
    let parts = message.split('`').enumerate().map(|(i, part)| {
        if i % 2 == 1 { format!("--{}", part.replace('_', "-")) } else { part.to_owned() }
    });
    let text: String = parts.collect();
    if text.contains("--") { format!("{text} (--lenient allows all repairs)") } else { text }
}

/// Names the option that lets companions be replaced as the command line does.
fn overwriting(message: &str) -> String {
    message.replace("`overwrite_companions`", "--overwrite-companions")
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
