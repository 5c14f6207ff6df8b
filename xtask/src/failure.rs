//! What can go wrong while reproducing, drawing or torturing.

use std::path::{Path, PathBuf};

/// An error with what was being done.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("a file of published numbers is malformed: {0}")]
    Published(Box<toml::de::Error>),
    #[error("a file of recorded numbers is malformed: {0}")]
    Recorded(Box<csv::Error>),
    #[error("cannot write {path}: {source}")]
    Write { path: PathBuf, source: std::io::Error },
    #[error(transparent)]
    Render(Box<mesh_render::RenderError>),
    #[error("cannot read {path}: {source}")]
    Read { path: PathBuf, source: Box<mesh_io::ReadError> },
    #[error("cannot read {path}: {source}")]
    Source { path: PathBuf, source: std::io::Error },
    #[error("{path} is no Rust source: {source}")]
    Syntax { path: PathBuf, source: Box<syn::Error> },
    #[error("cannot make a mesh: {0}")]
    Mesh(Box<dyn std::error::Error + Send + Sync>),
    #[error("{0}")]
    Usage(String),
    #[error("{0} of the numbers and claims are not what is on record; the table says which")]
    Drift(usize),
    #[error(
        "{0} circles of files that use each other; what both need belongs in a file below both"
    )]
    Circles(usize),
    #[error("{0} of the items could not be computed; the table says why")]
    Items(usize),
    #[error("cannot read {path}: {source}")]
    Input { path: PathBuf, source: std::io::Error },
    #[error("{0} of the runs are at fault; the table says which")]
    Torture(usize),
    #[error(
        "{0} of the jobs take over a tenth more or fewer instructions than is on record; the table says which"
    )]
    Instructions(usize),
    #[error("{0} rules for dependencies are broken")]
    Denied(usize),
}

impl Failure {
    pub(crate) fn published(source: toml::de::Error) -> Self {
        Self::Published(Box::new(source))
    }

    pub(crate) fn recorded(source: csv::Error) -> Self {
        Self::Recorded(Box::new(source))
    }

    pub(crate) fn mesh(source: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Mesh(Box::new(source))
    }

    pub(crate) fn render(source: mesh_render::RenderError) -> Self {
        Self::Render(Box::new(source))
    }

    /// Adds the path to an error of writing there.
    pub(crate) fn writing(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        |source| Self::Write { path: path.to_owned(), source }
    }

    /// Adds the path to an error of reading source code.
    pub(crate) fn source(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        |source| Self::Source { path: path.to_owned(), source }
    }

    /// Adds the path to an error of reading a mesh.
    pub(crate) fn reading(path: &Path) -> impl FnOnce(mesh_io::ReadError) -> Self + '_ {
        |source| Self::Read { path: path.to_owned(), source: Box::new(source) }
    }
}
