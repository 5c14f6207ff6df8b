//! The errors of the programs, with their context.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The source of an error that another crate reports.
type Source = Box<dyn std::error::Error + Send + Sync>;

/// An error with its context.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A file cannot be read or parsed.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: Source,
    },
    /// A file cannot be written.
    #[error("cannot write {path}: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: Source,
    },
    /// A file that is part of the program is malformed.
    #[error("a file of numbers is malformed: {0}")]
    Numbers(Source),
    /// An algorithm of the libraries refused its input.
    #[error("cannot compute: {0}")]
    Compute(Source),
    /// The program was called incorrectly, or something that it needs is missing.
    #[error("{0}")]
    Usage(String),
    /// A check was completed and failed.
    #[error("{0}")]
    Check(String),
}

impl Failure {
    /// Wraps an error of a file of published or recorded numbers.
    pub fn numbers(source: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Numbers(Box::new(source))
    }

    /// Wraps an error of a library function.
    pub fn mesh(source: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Compute(Box::new(source))
    }

    /// Adds the path to a write error.
    pub fn writing<E: std::error::Error + Send + Sync + 'static>(
        path: &Path,
    ) -> impl FnOnce(E) -> Self + '_ {
        |source| Self::Write { path: path.to_owned(), source: Box::new(source) }
    }

    /// Adds the path to a read error.
    pub fn reading<E: std::error::Error + Send + Sync + 'static>(
        path: &Path,
    ) -> impl FnOnce(E) -> Self + '_ {
        |source| Self::Read { path: path.to_owned(), source: Box::new(source) }
    }
}

/// The exit code of a program; prints the error, if any.
#[must_use]
pub fn exit_code(result: Result<(), Failure>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}
