//! The class that holds a mesh.

use std::path::PathBuf;
use std::sync::Arc;

use bytemuck::cast_slice;
use mesh_io::{
    Encoding, External, Format, Group, ImageData, Material, Model, Precision, ReadOptions,
    WriteOptions,
};
use mesh_work::splits_vertices;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};

use crate::content::Content;
use crate::failure::{Ended, Failure, choose};
use crate::host::{Call, run};
use crate::input::{Coordinates, Triangles, check, polygons, triangles};
use crate::views::{rows, view};

/// The compiled part of `curvmesh.Mesh`. Never changes.
#[pyclass(frozen, weakref, module = "curvmesh._core")]
pub(crate) struct MeshData(Arc<Content>);

impl MeshData {
    pub(crate) fn new(model: Model, joins: bool) -> Self {
        Self(Arc::new(Content::new(model, joins)))
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
        let make = || -> Result<Self, Failure> {
            let soup = triangles(vertices.points()?, faces.corners()?)?;
            if checked {
                check(&soup)?;
            }
            Ok(Self::new(soup.into(), false))
        };
        make().map_err(|failure| failure.raise(py))
    }

    /// From rows of coordinates, the corners of all faces, and where each face ends.
    #[staticmethod]
    fn of_polygons(
        py: Python<'_>,
        vertices: Coordinates<'_>,
        corners: PyReadonlyArray1<'_, i64>,
        ends: PyReadonlyArray1<'_, i64>,
        checked: bool,
    ) -> PyResult<Self> {
        let make = || -> Result<Self, Failure> {
            let soup = polygons(vertices.points()?, &corners, &ends)?;
            if checked {
                check(&soup)?;
            }
            Ok(Self::new(soup.into(), false))
        };
        make().map_err(|failure| failure.raise(py))
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

    /// Whether vertices that the file splits count as one.
    #[getter]
    fn joins(&self) -> bool {
        self.0.joins
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.model().notes.clone()
    }

    /// A view of the positions.
    #[getter]
    #[allow(unsafe_code, reason = "a view of memory that the object keeps alive")]
    fn vertices(this: Bound<'_, Self>) -> Bound<'_, PyAny> {
        let content = this.get().content();
        let values: &[[f64; 3]] = cast_slice(content.model.soup.positions());
        // SAFETY: the content never changes, and lives as long as the object.
        unsafe { rows(values, this.into_any()) }.into_any()
    }

    /// A view of the corners, signed.
    #[getter]
    #[allow(unsafe_code, reason = "a view of memory that the object keeps alive")]
    fn corners(this: Bound<'_, Self>) -> Bound<'_, PyAny> {
        let content = this.get().content();
        let values: &[i32] = cast_slice(content.model.soup.corners());
        // SAFETY: the content never changes, and lives as long as the object.
        unsafe { view(values, this.into_any()) }.into_any()
    }

    /// A view of the ends of the faces, signed.
    #[getter]
    #[allow(unsafe_code, reason = "a view of memory that the object keeps alive")]
    fn face_ends(this: Bound<'_, Self>) -> Bound<'_, PyAny> {
        let content = this.get().content();
        let values: &[i32] = cast_slice(content.model.soup.face_ends());
        // SAFETY: the content never changes, and lives as long as the object.
        unsafe { view(values, this.into_any()) }.into_any()
    }

    /// The same, with vertices that a format splits counting as one or not.
    fn with_joins(&self, joins: bool) -> Self {
        Self::new(self.model().clone(), joins)
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
            Some(model) => Self::new(model, false),
            None => Self(self.content()),
        })
    }

    /// Materials as dictionaries.
    fn materials<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        for material in &self.model().materials {
            let Material { name, base_color, base_color_image, metallic, roughness, .. } = material;
            let item = PyDict::new(py);
            item.set_item("name", name)?;
            item.set_item("base_color", base_color)?;
            item.set_item("image", base_color_image)?;
            item.set_item("metallic", metallic)?;
            item.set_item("roughness", roughness)?;
            item.set_item("emissive", material.emissive)?;
            item.set_item("double_sided", material.double_sided)?;
            list.append(item)?;
        }
        Ok(list)
    }

    /// Images as dictionaries.
    fn images<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        for image in &self.model().images {
            let item = PyDict::new(py);
            item.set_item("name", &image.name)?;
            item.set_item("media_type", image.media_type())?;
            match &image.data {
                ImageData::Bytes(bytes) => item.set_item("data", PyBytes::new(py, bytes))?,
                ImageData::Uri(uri) => item.set_item("uri", uri)?,
            }
            list.append(item)?;
        }
        Ok(list)
    }

    /// Groups as pairs of object and name.
    fn groups(&self) -> Vec<(String, String)> {
        let pair = |Group { object, name }: &Group| (object.clone(), name.clone());
        self.model().groups.iter().map(pair).collect()
    }
}

const FORMATS: &[(&str, Format)] = &[
    ("obj", Format::Obj),
    ("ply", Format::Ply),
    ("stl", Format::Stl),
    ("off", Format::Off),
    ("gltf", Format::Gltf),
    ("glb", Format::Glb),
];

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
    let choices = [("none", External::None), ("folder", External::Folder), ("any", External::Any)];
    let options = || -> Result<ReadOptions, Failure> {
        Ok(ReadOptions {
            format: format.map(|name| choose("format", name, FORMATS)).transpose()?,
            external: choose("external", external, &choices)?,
            max_memory,
            allow_empty,
            ..ReadOptions::default()
        })
    };
    let options = options().map_err(|failure| failure.raise(py))?;
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
        let joins = join.unwrap_or_else(|| splits_vertices(&model, format));
        Ok(MeshData::new(model, joins))
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
        })
    };
    let options = options().map_err(|failure| failure.raise(py))?;
    let content = mesh.content();
    let report = run(py, call, move |_| {
        mesh_io::write(&path, &content.model, &options).map_err(|e| Ended::from(Failure::from(e)))
    })?;
    let found = PyDict::new(py);
    found.set_item("rounding", report.rounding)?;
    found
        .set_item("dropped", report.dropped.iter().map(ToString::to_string).collect::<Vec<_>>())?;
    found.set_item("kept", report.kept)?;
    Ok(found)
}
