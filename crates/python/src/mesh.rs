//! The mesh class.

use std::path::PathBuf;
use std::sync::Arc;

use bytemuck::cast_slice;
use mesh_core::PolygonSoup;
use mesh_core::build::Weld;
use mesh_io::{
    Encoding, External, Format, Model, Precision, ReadOptions, WriteOptions, WriteReport,
};
use mesh_work::usual_weld;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::content::Content;
use crate::failure::{Ended, Failure, choose};
use crate::host::{Call, run};
use crate::input::{Coordinates, Triangles, check, polygons, triangles};
use crate::views::{rows, view};

/// The compiled part of `curvmesh.Mesh`. It never changes.
#[pyclass(frozen, weakref, module = "curvmesh._core")]
pub(crate) struct MeshData(Arc<Content>);

/// Which vertices count as one.
pub(crate) fn weld_of(join: Option<bool>) -> Weld {
    match join {
        None => Weld::Seams,
        Some(true) => Weld::Exact,
        Some(false) => Weld::None,
    }
}

impl MeshData {
    pub(crate) fn new(model: Model, weld: Weld) -> Self {
        Self(Arc::new(Content::new(model, weld)))
    }

    pub(crate) fn shared(content: &Arc<Content>) -> Self {
        Self(Arc::clone(content))
    }

    pub(crate) fn content(&self) -> Arc<Content> {
        Arc::clone(&self.0)
    }

    pub(crate) fn replaced(&self, model: Model) -> Self {
        Self(Arc::new(self.0.with_model(model)))
    }

    pub(crate) fn model(&self) -> &Model {
        &self.0.model
    }
}

#[pymethods]
impl MeshData {
    /// From rows of coordinates and rows of indices.
    #[staticmethod]
    fn of_triangles(
        py: Python<'_>,
        vertices: Coordinates<'_>,
        faces: Triangles<'_>,
        checked: bool,
    ) -> PyResult<Self> {
        let (points, indices) = (vertices.rows(), faces.rows());
        made(py, checked, move || triangles(points.points()?, indices.corners()?))
    }

    /// From rows of coordinates, the corners of all faces, and the end of each face.
    #[staticmethod]
    fn of_polygons(
        py: Python<'_>,
        vertices: Coordinates<'_>,
        corners: PyReadonlyArray1<'_, i64>,
        ends: PyReadonlyArray1<'_, i64>,
        checked: bool,
    ) -> PyResult<Self> {
        let points = vertices.rows();
        let (corners, ends) = (corners.as_array(), ends.as_array());
        made(py, checked, move || polygons(points.points()?, &corners, &ends))
    }

    /// The same faces and data at other positions; without normals.
    fn with_positions(&self, py: Python<'_>, vertices: Coordinates<'_>) -> PyResult<Self> {
        let (points, model) = (vertices.rows(), self.model());
        let moved = || -> Result<Self, Failure> {
            let points = points.points()?;
            let [found, expected] = [points.len(), model.soup.vertex_count()];
            if found != expected {
                let message = format!("there are {found} positions for {expected} vertices");
                return Err(Failure::new("ArrayError", message));
            }
            let (corners, ends) = (model.soup.corners().to_vec(), model.soup.face_ends().to_vec());
            let soup = PolygonSoup::from_parts(points, corners, ends);
            let soup = soup.map_err(|error| Failure::new("ArrayError", error))?;
            check(&soup)?;
            let mut model = model.clone();
            (model.soup, model.vertex_normals, model.corner_normals) = (soup, None, None);
            Ok(Self::new(model, self.0.weld))
        };
        py.detach(moved).map_err(|failure| failure.raise(py))
    }

    /// The whole content as bytes, for a pickle.
    fn dump<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| postcard::to_allocvec(&(self.0.weld, self.model())));
        let bytes = bytes.map_err(|error| Failure::internal(error).raise(py))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The mesh of such bytes.
    #[staticmethod]
    fn load(py: Python<'_>, content: &[u8]) -> PyResult<Self> {
        let (weld, model): (Weld, Model) =
            py.detach(|| postcard::from_bytes(content)).map_err(|error| {
                Failure::new("CurvmeshError", format!("the pickle is damaged: {error}")).raise(py)
            })?;
        let model_fits = model.check_attributes();
        model_fits.map_err(|error| Failure::new("CurvmeshError", error).raise(py))?;
        Ok(Self::new(model, weld))
    }

    /// Whether all content is the same to the last bit, apart from notes.
    fn equals(&self, py: Python<'_>, other: &Self) -> PyResult<bool> {
        let bytes = |mesh: &Self| {
            let model = Model { notes: Vec::new(), ..mesh.model().clone() };
            postcard::to_allocvec(&(mesh.0.weld == Weld::Exact, model))
        };
        let equal = py.detach(|| {
            let [a, b] = [self, other].map(|mesh| &mesh.model().soup);
            let same = a.vertex_count() == b.vertex_count() && a.corners() == b.corners();
            Ok::<_, postcard::Error>(same && bytes(self)? == bytes(other)?)
        });
        equal.map_err(|error| Failure::internal(error).raise(py))
    }

    /// The same mesh with other notes.
    fn with_notes(&self, notes: Vec<String>) -> Self {
        self.replaced(Model { notes, ..self.model().clone() })
    }

    #[getter]
    fn vertex_count(&self) -> usize {
        self.model().soup.vertex_count()
    }

    #[getter]
    fn face_count(&self) -> usize {
        self.model().soup.face_count()
    }

    #[getter]
    fn corner_count(&self) -> usize {
        self.model().soup.corners().len()
    }

    #[getter]
    fn is_triangular(&self) -> bool {
        self.0.is_triangular()
    }

    /// Whether vertices at equal positions count as one; `None` if only open edges that lie on each other do.
    #[getter]
    fn joins(&self) -> Option<bool> {
        match self.0.weld {
            Weld::Seams => None,
            weld => Some(weld != Weld::None),
        }
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.model().notes.clone()
    }

    /// The repairs that were made for functions that need an oriented manifold, and their numbers.
    #[getter]
    fn repairs(&self) -> Vec<(String, usize)> {
        self.0.repairs().iter().map(|&(what, count)| (what.to_owned(), count)).collect()
    }

    /// A view of the positions.
    #[getter]
    #[allow(unsafe_code, reason = "a view of memory that the object keeps alive")]
    fn vertices(this: Bound<'_, Self>) -> Bound<'_, PyArray2<f64>> {
        let content = this.get().content();
        let values: &[[f64; 3]] = cast_slice(content.model.soup.positions());
        // SAFETY: the content never changes, and lives as long as the object.
        unsafe { rows(values, this.into_any()) }
    }

    /// A view of the corners, signed.
    #[getter]
    #[allow(unsafe_code, reason = "a view of memory that the object keeps alive")]
    fn corners(this: Bound<'_, Self>) -> Bound<'_, PyArray1<i32>> {
        let content = this.get().content();
        let values: &[i32] = cast_slice(content.model.soup.corners());
        // SAFETY: the content never changes, and lives as long as the object.
        unsafe { view(values, this.into_any()) }
    }

    /// A view of the ends of the faces, signed.
    #[getter]
    #[allow(unsafe_code, reason = "a view of memory that the object keeps alive")]
    fn face_ends(this: Bound<'_, Self>) -> Bound<'_, PyArray1<i32>> {
        let content = this.get().content();
        let values: &[i32] = cast_slice(content.model.soup.face_ends());
        // SAFETY: the content never changes, and lives as long as the object.
        unsafe { view(values, this.into_any()) }
    }

    /// The same, with vertices at equal positions counting as one or not.
    #[pyo3(signature = (joins))]
    fn with_joins(&self, joins: Option<bool>) -> Self {
        Self::new(self.model().clone(), weld_of(joins))
    }

    /// Refuses what is no oriented manifold.
    fn validate(&self, py: Python<'_>, call: &Call) -> PyResult<()> {
        let content = self.content();
        run(py, call, move |_| Ok(content.validate()?))
    }

    /// The triangles that everything is computed on.
    fn triangulated(&self, py: Python<'_>, call: &Call) -> PyResult<Self> {
        let content = self.content();
        let model = run(py, call, move |_| {
            let source = content.source()?;
            if source.is_whole() {
                return Ok(None);
            }
            let corners = &source.provenance.corner_source;
            Ok(Some(source.to_model(source.mesh, corners).map_err(Failure::from)?))
        })?;
        Ok(match model {
            Some(model) => Self::new(model, Weld::None),
            None => Self(self.content()),
        })
    }
}

/// A mesh of a polygon soup that is made without the interpreter.
fn made(
    py: Python<'_>,
    checked: bool,
    soup: impl FnOnce() -> Result<PolygonSoup, Failure> + Send,
) -> PyResult<MeshData> {
    let make = || -> Result<MeshData, Failure> {
        let soup = soup()?;
        if checked {
            check(&soup)?;
        }
        Ok(MeshData::new(soup.into(), Weld::Seams))
    };
    py.detach(make).map_err(|failure| failure.raise(py))
}

const FORMATS: &[(&str, Format)] = &[
    ("obj", Format::Obj),
    ("ply", Format::Ply),
    ("stl", Format::Stl),
    ("off", Format::Off),
    ("gltf", Format::Gltf),
    ("glb", Format::Glb),
];

/// Which of the files that a file refers to are read.
pub(crate) fn externals(name: &str) -> Result<External, Failure> {
    let choices = [("none", External::None), ("folder", External::Folder), ("any", External::Any)];
    choose("external", name, &choices)
}

/// The options of readers.
pub(crate) fn read_options(
    format: Option<&str>,
    external: &str,
    max_memory: Option<u64>,
    allow_empty: bool,
) -> Result<ReadOptions, Failure> {
    Ok(ReadOptions {
        format: format.map(|name| choose("format", name, FORMATS)).transpose()?,
        external: externals(external)?,
        max_memory,
        allow_empty,
        ..ReadOptions::default()
    })
}

/// Reads a file or bytes.
#[pyfunction]
#[pyo3(signature = (call, path=None, data=None, *, format=None, external="folder", max_memory=None, allow_empty=false, join=None))]
#[allow(clippy::too_many_arguments, reason = "one per option of Python")]
pub(crate) fn read(
    py: Python<'_>,
    call: &Call,
    path: Option<PathBuf>,
    data: Option<Vec<u8>>,
    format: Option<&str>,
    external: &str,
    max_memory: Option<u64>,
    allow_empty: bool,
    join: Option<bool>,
) -> PyResult<MeshData> {
    let options = read_options(format, external, max_memory, allow_empty)
        .map_err(|failure| failure.raise(py))?;
    run(py, call, move |_| {
        let (model, format) = match (&path, &data) {
            (Some(path), _) => {
                let model = mesh_io::read_with(path, &options).map_err(Failure::from)?;
                (model, options.format.or_else(|| detect(path)))
            }
            (None, data) => {
                let bytes = data.as_deref().unwrap_or_default();
                let size = Some(bytes.len() as u64);
                let format = options.format.or_else(|| Format::detect(bytes, size, None));
                let options = ReadOptions { size, ..options };
                let model = mesh_io::read_from(&mut &*bytes, &options).map_err(Failure::from)?;
                (model, format)
            }
        };
        let weld = join.map_or_else(|| usual_weld(&model, format), |join| weld_of(Some(join)));
        Ok(MeshData::new(model, weld))
    })
}

/// The format of a file that was read.
fn detect(path: &std::path::Path) -> Option<Format> {
    use std::io::Read;
    let mut head = Vec::new();
    let file = std::fs::File::open(path).ok()?;
    let size = file.metadata().ok()?.len();
    file.take(4096).read_to_end(&mut head).ok()?;
    Format::detect(&head, Some(size), Some(path))
}

/// Writes a file, whole or not at all, and says what the format could not hold.
#[pyfunction]
#[pyo3(signature = (call, path, mesh, *, format=None, encoding="usual", precision="exact", overwrite_companions=false))]
#[allow(clippy::too_many_arguments, reason = "one per option of Python")]
pub(crate) fn write<'py>(
    py: Python<'py>,
    call: &Call,
    path: PathBuf,
    mesh: &MeshData,
    format: Option<&str>,
    encoding: &str,
    precision: &str,
    overwrite_companions: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let encodings = [
        ("usual", Encoding::Usual),
        ("text", Encoding::Text),
        ("little-endian", Encoding::LittleEndian),
        ("big-endian", Encoding::BigEndian),
    ];
    let precisions =
        [("exact", Precision::Exact), ("single", Precision::Single), ("double", Precision::Double)];
    let options = || -> Result<WriteOptions, Failure> {
        Ok(WriteOptions {
            format: format.map(|name| choose("format", name, FORMATS)).transpose()?,
            encoding: choose("encoding", encoding, &encodings)?,
            precision: choose("precision", precision, &precisions)?,
            overwrite_companions,
            ..WriteOptions::default()
        })
    };
    let options = options().map_err(|failure| failure.raise(py))?;
    let content = mesh.content();
    let report = run(py, call, move |_| {
        mesh_io::write(&path, &content.model, &options).map_err(|e| Ended::from(Failure::from(e)))
    })?;
    written(py, &report)
}

/// What the format of a written file could not hold.
pub(crate) fn written<'py>(py: Python<'py>, report: &WriteReport) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    found.set_item("rounding", report.rounding)?;
    found.set_item("dropped", report.lost.iter().map(ToString::to_string).collect::<Vec<_>>())?;
    found.set_item("kept", &report.kept)?;
    if !report.stayed.is_empty() {
        found.set_item("stayed", &report.stayed)?;
    }
    Ok(found)
}
