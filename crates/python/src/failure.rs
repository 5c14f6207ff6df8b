//! Errors as exceptions, with element ids and the remedy.
//!
//! Work runs without the interpreter lock: an error is first plain data, and becomes an exception of `curvmesh._errors`
//! once the lock is held again.

use std::fmt::Display;
use std::io::ErrorKind;
use std::path::Path;

use ::simplify::{RecordError, SimplifyError};
use mesh_core::build::{BuildError, Sample, VertexPair};
use mesh_core::{MeshError, TopologyError, as_u32};
use mesh_io::{Location, ReadError, ReadErrorKind, WriteError};
use mesh_metric::SurfaceError;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An exception that is not created yet.
#[derive(Debug)]
pub(crate) struct Failure {
    /// The class.
    kind: &'static str,
    message: String,
    /// Further attributes.
    attributes: Vec<(&'static str, Value)>,
}

/// An attribute of an exception.
#[derive(Debug)]
enum Value {
    Text(String),
    Count(usize),
    Ids(Vec<u32>),
    Edges(Vec<(u32, u32)>),
}

impl Failure {
    pub(crate) fn new(kind: &'static str, message: impl Display) -> Self {
        Self { kind, message: message.to_string(), attributes: Vec::new() }
    }

    /// An invalid option.
    pub(crate) fn option(message: impl Display) -> Self {
        Self::new("OptionError", message)
    }

    /// An operation that is not possible with this mesh.
    pub(crate) fn cannot(message: impl Display) -> Self {
        Self::new("CannotBeDoneError", message)
    }

    /// A defect of this package.
    pub(crate) fn internal(message: impl Display) -> Self {
        Self::new("InternalError", message)
    }

    pub(crate) fn text(self, name: &'static str, text: impl Display) -> Self {
        self.with(name, Value::Text(text.to_string()))
    }

    pub(crate) fn ids(self, name: &'static str, ids: Vec<u32>) -> Self {
        self.with(name, Value::Ids(ids))
    }

    pub(crate) fn count(self, count: usize) -> Self {
        self.with("count", Value::Count(count))
    }

    /// A file that cannot be opened for reading.
    pub(crate) fn opening(path: &Path, error: &std::io::Error) -> Self {
        let message = format!("{}: {error}", path.display());
        Self::new("ReadError", message).text("path", path.display()).system(error)
    }

    /// The error number of the system, from which Python chooses the class.
    fn system(self, error: &std::io::Error) -> Self {
        let number = error.raw_os_error().or_else(|| match error.kind() {
            ErrorKind::NotFound => Some(2),
            ErrorKind::PermissionDenied => Some(13),
            ErrorKind::IsADirectory => Some(21),
            _ => None,
        });
        match number.and_then(|number| usize::try_from(number).ok()) {
            Some(number) => self.with("errno", Value::Count(number)),
            None => self,
        }
    }

    fn sample(self, name: &'static str, sample: &Sample<u32>) -> Self {
        self.ids(name, sample.first().to_vec()).count(sample.count())
    }

    fn edges(self, sample: &Sample<VertexPair>) -> Self {
        let pairs = sample.first().iter().map(|&VertexPair(a, b)| (a, b)).collect();
        self.with("edges", Value::Edges(pairs)).count(sample.count())
    }

    fn repair(self, repair: &str) -> Self {
        self.text("repair", repair)
    }

    /// The failure of one mesh of a scene.
    fn of_mesh(self, mesh: usize) -> Self {
        Self { message: format!("mesh {mesh}: {}", self.message), ..self }
    }

    fn with(mut self, name: &'static str, value: Value) -> Self {
        self.attributes.push((name, value));
        self
    }

    /// The exception.
    pub(crate) fn raise(self, py: Python<'_>) -> PyErr {
        match self.make(py) {
            Ok(exception) => PyErr::from_value(exception),
            Err(error) => error,
        }
    }

    fn make<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let attributes = PyDict::new(py);
        for (name, value) in &self.attributes {
            match value {
                Value::Text(text) => attributes.set_item(name, text)?,
                Value::Count(count) => attributes.set_item(name, count)?,
                Value::Ids(ids) => attributes.set_item(name, ids)?,
                Value::Edges(edges) => attributes.set_item(name, edges)?,
            }
        }
        let class = py.import("curvmesh._errors")?.getattr(self.kind)?;
        class.call((&self.message,), Some(&attributes))
    }
}

/// The reason for the end of a run.
#[derive(Debug)]
pub(crate) enum Ended {
    /// A failure of the work.
    Failure(Failure),
    /// An exception of a Python function called by it.
    Raised(PyErr),
}

impl Ended {
    pub(crate) fn raise(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Failure(failure) => failure.raise(py),
            Self::Raised(error) => error,
        }
    }

    /// The run was cancelled.
    pub(crate) fn interrupted() -> Self {
        Self::Raised(PyKeyboardInterrupt::new_err(()))
    }
}

impl<F: Into<Failure>> From<F> for Ended {
    fn from(failure: F) -> Self {
        Self::Failure(failure.into())
    }
}

impl From<BuildError> for Failure {
    fn from(error: BuildError) -> Self {
        let message = in_python(&error.to_string());
        let of = |kind| Self::new(kind, &message);
        match &error {
            BuildError::TooManyElements { .. } => of("TooLargeError"),
            BuildError::InvalidWeldDistance { .. } => of("OptionError"),
            BuildError::NonFiniteCoordinate { vertices, .. } => {
                of("NotFiniteError").sample("vertices", vertices).repair("drop_not_finite")
            }
            BuildError::IndexOutOfRange { faces, .. } => {
                of("OutOfRangeError").sample("faces", faces).repair("drop_out_of_range")
            }
            BuildError::TooFewCorners { faces, .. } | BuildError::RepeatedVertex { faces, .. } => {
                of("DegenerateFaceError").sample("faces", faces).repair("drop_degenerate")
            }
            BuildError::DuplicateFace { duplicates, .. } => {
                of("DuplicateFaceError").sample("faces", duplicates).repair("drop_duplicates")
            }
            BuildError::NonManifoldEdge { edges, faces, .. } => of("NonManifoldError")
                .ids("faces", faces.first().to_vec())
                .edges(edges)
                .repair("cut_non_manifold"),
            BuildError::InconsistentOrientation { edges, faces, .. } => {
                of("OrientationError").ids("faces", faces.to_vec()).edges(edges).repair("reorient")
            }
            BuildError::NonOrientable { edges, faces, .. } => of("OrientationError")
                .ids("faces", faces.to_vec())
                .edges(edges)
                .repair("reorient, cut_non_manifold"),
            BuildError::PinchedVertex { vertices, .. } => {
                of("NonManifoldError").sample("vertices", vertices).repair("cut_non_manifold")
            }
            _ => of("CurvmeshError"),
        }
    }
}

/// Names of repairs are in backticks in the messages of the library; here they are arguments.
fn in_python(message: &str) -> String {
    let part = |(i, part): (usize, &str)| match i % 2 {
        1 => format!("`curvmesh.repair(mesh, {part}=True)`"),
        _ => part.to_owned(),
    };
    message.split('`').enumerate().map(part).collect()
}

impl From<MeshError> for Failure {
    fn from(error: MeshError) -> Self {
        Self::cannot(error)
    }
}

impl From<TopologyError> for Failure {
    fn from(error: TopologyError) -> Self {
        Self::cannot(error)
    }
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Self {
        // Options have other names in Python.
        let message = error.to_string().replace("--allow-empty", "allow_empty=True");
        let message = match message.split_once("--max-memory ") {
            Some((before, bytes)) => {
                format!("{before}max_memory={}", bytes.replace("MiB", " * 2**20"))
            }
            None => message,
        };
        let mut failure = Self::new("ReadError", message);
        if let Some(path) = &error.path {
            failure = failure.text("path", path.display());
        }
        failure = match error.location() {
            Some(Location::Line(line)) => failure.with("line", Value::Count(*line as usize)),
            Some(Location::Byte(byte)) => failure.with("byte", Value::Count(*byte as usize)),
            Some(Location::Json(place)) => failure.text("place", place),
            None => failure,
        };
        match &error.kind {
            ReadErrorKind::Io(source) => failure.system(source),
            ReadErrorKind::Unsupported { cure, .. } => failure.text("cure", cure),
            ReadErrorKind::UnknownFormat { .. } => failure.text("cure", "format="),
            ReadErrorKind::Memory { .. } => failure.text("cure", "max_memory="),
            ReadErrorKind::Empty { .. } => failure.text("cure", "allow_empty=True"),
            _ => failure,
        }
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        let message =
            error.to_string().replace("`overwrite_companions`", "overwrite_companions=True");
        let failure = Self::new("WriteError", message);
        match error {
            WriteError::Io { path, source } => match path {
                Some(path) => failure.text("path", path.display()).system(&source),
                None => failure.system(&source),
            },
            WriteError::Companion { .. } => failure.text("cure", "overwrite_companions=True"),
            WriteError::NotFinite { vertex, .. } | WriteError::OutOfSingleRange { vertex, .. } => {
                failure.ids("vertices", vec![as_u32(vertex)]).count(1)
            }
            _ => failure,
        }
    }
}

impl From<SimplifyError> for Failure {
    fn from(error: SimplifyError) -> Self {
        match error {
            SimplifyError::Option { .. } | SimplifyError::Conflict { .. } => Self::option(error),
            SimplifyError::NotFinite { vertex, .. } => Self::new("NotFiniteError", error)
                .ids("vertices", vec![as_u32(vertex.index())])
                .count(1),
            SimplifyError::OtherMesh(_) => Self::new("RecordError", error),
            _ => Self::cannot(error),
        }
    }
}

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Self {
        Self::new("RecordError", error)
    }
}

/// Errors that are fully described by their message.
macro_rules! plain {
    ($($kind:literal: $($error:ty),+;)+) => {
        $($(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::new($kind, error)
            }
        })+)+
    };
}

plain! {
    "CannotBeDoneError": SurfaceError, mesh_work::NoExtent, mesh_work::PatchWorkError,
        mesh_work::SubdivisionError, curvpatch::TessellationError;
    "OptionError": dcurv::InvalidRadius, curvpatch::CurvatureError,
        curvpatch::OptionError, mesh_render::RenderError, mesh_view::ViewError;
    "RecordError": simplify::ReplayError;
    "InternalError": mesh_io::ModelError;
}

impl From<mesh_work::CurvatureFailure> for Failure {
    fn from(error: mesh_work::CurvatureFailure) -> Self {
        match error {
            mesh_work::CurvatureFailure::Scale(error) => error.into(),
            other => Self::option(other),
        }
    }
}

impl From<dtri_flip::FlipError> for Failure {
    fn from(error: dtri_flip::FlipError) -> Self {
        match error {
            dtri_flip::FlipError::Scale(error) => error.into(),
            other => Self::option(other),
        }
    }
}

impl From<mesh_core::ScaleError> for Failure {
    fn from(error: mesh_core::ScaleError) -> Self {
        Self::cannot(error)
    }
}

impl From<mesh_work::LevelError> for Failure {
    fn from(error: mesh_work::LevelError) -> Self {
        match error {
            mesh_work::LevelError::Simplify(error) => error.into(),
            other => Self::cannot(other),
        }
    }
}

impl From<mesh_work::SceneError> for Failure {
    fn from(error: mesh_work::SceneError) -> Self {
        use mesh_work::SceneError;
        match error {
            SceneError::Read(error) => error.into(),
            SceneError::Build { mesh, source } => Self::from(*source).of_mesh(mesh),
            SceneError::Simplify { mesh, source } => Self::from(source).of_mesh(mesh),
            SceneError::Replay(error) => error.into(),
            SceneError::Surface(error) => error.into(),
            SceneError::Model(error) => error.into(),
            SceneError::Write(error) => error.into(),
            SceneError::NoExtent(error) => error.into(),
            other => Self::cannot(other),
        }
    }
}

/// The choice with this name, or a failure that lists all.
pub(crate) fn choose<T: Copy>(
    option: &str,
    name: &str,
    choices: &[(&str, T)],
) -> Result<T, Failure> {
    let found = choices.iter().find(|(known, _)| *known == name);
    found.map(|&(_, choice)| choice).ok_or_else(|| {
        let names: Vec<_> = choices.iter().map(|(known, _)| format!("{known:?}")).collect();
        Failure::option(format!("{option} is {name:?}; it must be one of {}", names.join(", ")))
    })
}
