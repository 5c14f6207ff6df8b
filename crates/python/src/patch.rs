//! `curvmesh.patch`.

use std::ops::ControlFlow;
use std::sync::Arc;

use curvpatch::{
    Cover, CoverCandidates, CoverMethod, CoverOptions, CoverPatch, CurvatureEstimator, Patch,
    Shape, SizeOptions, StopReason,
};
use mesh_core::build::Weld;
use mesh_core::{FaceId, Handle, as_u32};
use mesh_work::{PatchMesh, cover_model, patch_of_radius, patch_within, splat_model};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::content::Content;
use crate::failure::{Failure, choose};
use crate::host::{Call, State, run};
use crate::length::{Given, length, units};
use crate::mesh::MeshData;
use crate::options::sections;
use crate::views::{frames, matrix, points, signed};

/// Patches, and the mesh that they are of.
#[pyclass(frozen, module = "curvmesh._core")]
pub(crate) struct CoverData {
    cover: Arc<Cover>,
    content: Arc<Content>,
    /// How far triangles may be from a patch, unless it is said.
    cut: f64,
}

/// Patches of a mesh.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one per option of Python")]
pub(crate) fn patch(
    py: Python<'_>,
    call: &Call,
    mesh: &MeshData,
    tolerance: Option<Given>,
    relative: bool,
    face: Option<usize>,
    radius: Option<Given>,
    shape: &str,
    preset: &str,
    method: &str,
    overhang: bool,
) -> PyResult<CoverData> {
    let settings = || -> Result<_, Failure> {
        let shapes = match shape {
            "best" => vec![Shape::Circle, Shape::Ellipse],
            one => vec![choose("shape", one, SHAPES)?],
        };
        let methods = [
            ("best", CoverMethod::Best),
            ("greedy", CoverMethod::Greedy),
            ("sequential", CoverMethod::Sequential),
        ];
        let (tolerance, radius) = (length("tolerance", tolerance)?, length("radius", radius)?);
        match (face, radius, tolerance) {
            (None, Some(_), _) => {
                Err(Failure::option("a radius is that of one patch: name its face"))
            }
            (_, Some(_), Some(_)) => Err(Failure::option("give a radius or a tolerance, not both")),
            (_, None, None) => Err(Failure::option("give a tolerance, or a face and a radius")),
            _ => Ok((shapes, choose("method", method, &methods)?, tolerance, radius)),
        }
    };
    let (shapes, method, tolerance, radius) = settings().map_err(|failure| failure.raise(py))?;
    let params = sections(preset).map_err(|failure| failure.raise(py))?;
    let content = mesh.content();
    run(py, call, move |watch| {
        let original = &content.whole()?.mesh;
        let sized = PatchMesh::new(original).map_err(Failure::from)?;
        let mesh = sized.mesh();
        let estimator = CurvatureEstimator::new(mesh, params).map_err(Failure::from)?;
        let radius = units(radius, original, relative)?;
        let tolerance = units(tolerance, original, relative)?;
        let count = mesh.topology().face_count();
        if let Some(face) = face.filter(|&face| face >= count) {
            let message = format!("there is no face {face}; the mesh has {count}, counted from 0");
            return Err(Failure::new("OutOfRangeError", message).into());
        }
        let (cover, cut) = match (face.map(FaceId::from_index), radius, tolerance) {
            (Some(face), Some(radius), _) => (
                patch_of_radius(&estimator, face, sized.length(radius), &shapes)
                    .map_err(Failure::from)?,
                2e-3 * radius,
            ),
            (Some(face), None, Some(tolerance)) => {
                let size = SizeOptions::new(sized.length(tolerance));
                let options = SizeOptions { overhang, ..size };
                let cover = patch_within(&estimator, face, options, &shapes);
                (cover.map_err(Failure::from)?, 0.5 * tolerance)
            }
            (_, _, tolerance) => {
                let tolerance = tolerance.unwrap_or(0.0);
                let defaults = CoverOptions::new(sized.length(tolerance));
                let size = SizeOptions { overhang, ..defaults.size };
                let options = CoverOptions { size, shapes, method, ..defaults };
                let candidates =
                    CoverCandidates::find_with_progress(&estimator, &options, &mut |now| {
                        let fraction = now.settled as f64 / now.faces.max(1) as f64;
                        let steps = now.settled as u64;
                        let flow: ControlFlow<()> =
                            watch.tell(State { phase: "fit", fraction, steps, ..State::default() });
                        flow
                    });
                (candidates.map_err(Failure::from)?.choose(method), 0.5 * tolerance)
            }
        };
        let cover = sized.restore(cover).map_err(Failure::from)?;
        Ok(CoverData { cover: Arc::new(cover), content: Arc::clone(&content), cut })
    })
}

const SHAPES: &[(&str, Shape)] =
    &[("circle", Shape::Circle), ("ellipse", Shape::Ellipse), ("sagitta", Shape::EqualSagitta)];

fn stop(stop: StopReason) -> &'static str {
    match stop {
        StopReason::Tolerance => "tolerance",
        StopReason::Angle => "angle",
        StopReason::Boundary => "boundary",
        StopReason::MaxRadius => "max_radius",
        _ => "other",
    }
}

#[pymethods]
impl CoverData {
    fn __len__(&self) -> usize {
        self.cover.patches.len()
    }

    #[getter]
    fn tolerance(&self) -> f64 {
        self.cover.tolerance
    }

    #[getter]
    fn max_error(&self) -> f64 {
        self.cover.max_error()
    }

    #[getter]
    fn covered_faces(&self) -> usize {
        self.cover.covered_faces()
    }

    #[getter]
    fn cancelled(&self) -> bool {
        self.cover.cancelled
    }

    /// The patches as columns.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = &self.cover.patches;
        let found = PyDict::new(py);
        let numbers = |of: &dyn Fn(&CoverPatch) -> f64| {
            all.iter().map(of).collect::<Vec<f64>>().into_pyarray(py)
        };
        let faces = all.iter().map(|p| p.fit.point.face().get()).collect();
        found.set_item("face", signed(faces).into_pyarray(py))?;
        let covered: Vec<i32> = all.iter().map(|p| as_u32(p.faces.len()).cast_signed()).collect();
        found.set_item("faces", covered.into_pyarray(py))?;
        found.set_item("radius", numbers(&|p| p.fit.curvature.radius))?;
        found
            .set_item("origin", points(py, all.iter().map(|p| p.fit.patch.origin()).collect())?)?;
        found
            .set_item("center", points(py, all.iter().map(|p| p.fit.patch.center()).collect())?)?;
        let axes = |p: &CoverPatch| p.fit.patch.frame().map(|axis| axis.to_array());
        found.set_item("frame", frames(py, all.iter().map(axes).collect())?)?;
        let curvatures = all.iter().map(|p| p.fit.patch.curvatures()).collect();
        found.set_item("curvatures", matrix(py, curvatures)?)?;
        found.set_item("arcs", matrix(py, all.iter().map(|p| p.fit.patch.arcs()).collect())?)?;
        found.set_item("translation", numbers(&|p| p.fit.patch.translation()))?;
        found.set_item("error", numbers(&|p| p.errors.max()))?;
        found.set_item("overhang", numbers(&|p| p.errors.overhang))?;
        let names =
            |of: &dyn Fn(&CoverPatch) -> &'static str| all.iter().map(of).collect::<Vec<_>>();
        found.set_item("stop", names(&|p| stop(p.stop)))?;
        let shape = |p: &CoverPatch| {
            SHAPES.iter().find(|(_, shape)| *shape == p.fit.shape).map_or("other", |(name, _)| name)
        };
        found.set_item("shape", names(&shape))?;
        Ok(found)
    }

    /// For each face the first patch that covers it, -1 for none.
    fn patch_of_face<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i32>> {
        let of = self.cover.patch_of_face.as_slice().iter();
        let ids: Vec<i32> = of.map(|patch| patch.map_or(-1, u32::cast_signed)).collect();
        ids.into_pyarray(py)
    }

    /// The faces that a patch covers.
    fn faces_of<'py>(&self, py: Python<'py>, patch: usize) -> PyResult<Bound<'py, PyArray1<i32>>> {
        let faces = self.get(py, patch)?.faces.iter().map(|face| face.get()).collect();
        Ok(signed(faces).into_pyarray(py))
    }

    /// Points of a patch, or its normals there.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        patch: usize,
        u: PyReadonlyArray1<'py, f64>,
        phi: PyReadonlyArray1<'py, f64>,
        normals: bool,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let patch = self.get(py, patch)?.fit.patch;
        let at = if normals { Patch::normal } else { Patch::point };
        let pairs = u.as_array().into_iter().copied().zip(phi.as_array().into_iter().copied());
        points(py, pairs.map(|(u, phi)| at(&patch, u, phi)).collect())
    }

    /// The patches and the faces that stay, as triangles.
    fn tessellate(
        &self,
        py: Python<'_>,
        call: &Call,
        tolerance: Option<f64>,
    ) -> PyResult<MeshData> {
        let (cover, content) = (Arc::clone(&self.cover), Arc::clone(&self.content));
        let cut = tolerance.unwrap_or(self.cut);
        run(py, call, move |_| {
            let mesh = &content.whole()?.mesh;
            let model = cover_model(mesh, &cover, cut).map_err(Failure::from)?;
            Ok(MeshData::new(model, Weld::None))
        })
    }

    /// The patches as elliptical discs: points with normals, and half axes as data of vertices.
    fn splats(&self) -> MeshData {
        MeshData::new(splat_model(&self.cover.splats()), Weld::None)
    }

    /// The patches as bytes, for a pickle.
    fn dump<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| postcard::to_allocvec(&(&*self.cover, self.cut)));
        Ok(PyBytes::new(py, &bytes.map_err(|error| Failure::internal(error).raise(py))?))
    }

    /// The patches of such bytes, on the mesh that they cover.
    #[staticmethod]
    fn load(py: Python<'_>, content: &[u8], mesh: &MeshData) -> PyResult<Self> {
        let (cover, cut): (Cover, f64) =
            py.detach(|| postcard::from_bytes(content)).map_err(|error| {
                Failure::new("CurvmeshError", format!("the pickle is damaged: {error}")).raise(py)
            })?;
        Ok(Self { cover: Arc::new(cover), content: mesh.content(), cut })
    }

    /// The record of all patches, as JSON.
    fn record(&self, py: Python<'_>) -> PyResult<String> {
        serde_json::to_string(&self.cover.record())
            .map_err(|error| Failure::internal(error).raise(py))
    }
}

impl CoverData {
    fn get(&self, py: Python<'_>, patch: usize) -> PyResult<&CoverPatch> {
        let count = self.cover.patches.len();
        self.cover.patches.get(patch).ok_or_else(|| {
            let message = format!("there is no patch {patch}; there are {count}, counted from 0");
            Failure::new("OutOfRangeError", message).raise(py)
        })
    }
}
