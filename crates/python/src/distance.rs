//! `curvmesh.distance`.

use mesh_metric::{
    CertifiedBounds, CertifyOptions, CompareOptions, OneSided, compare_until,
    hausdorff_bounds_until,
};
use mesh_work::{diagonal, surface};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::failure::{Ended, Failure};
use crate::host::{Call, run};
use crate::length::{Given, length};
use crate::mesh::MeshData;

/// The distances between two meshes.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "one per option of Python")]
pub(crate) fn distance<'py>(
    py: Python<'py>,
    call: &Call,
    first: &MeshData,
    second: &MeshData,
    samples: usize,
    exact: Option<Given>,
    relative: bool,
    seed: u64,
) -> PyResult<Bound<'py, PyDict>> {
    let exact = length("exact", exact).map_err(|failure| failure.raise(py))?;
    let (first, second) = (first.content(), second.content());
    let (found, bounds, size) = run(py, call, move |watch| {
        let a = surface(&first.model.soup).map_err(Failure::from)?;
        let b = surface(&second.model.soup).map_err(Failure::from)?;
        watch.check()?;
        let size = a.bounding_box().diagonal();
        let exact = exact.map(|length| length.in_units(relative, || diagonal(Some(size))));
        let exact = exact.transpose()?;
        let options = CompareOptions { samples, seed, ..CompareOptions::default() };
        let stops = || watch.is_cancelled();
        let found = compare_until(&a, &b, &options, &stops).ok_or_else(Ended::interrupted)?;
        let prove = |tolerance| {
            let options = CertifyOptions { tolerance, ..CertifyOptions::default() };
            let bounds = hausdorff_bounds_until(&a, &b, &options, &mut || stops());
            bounds.ok_or_else(Ended::interrupted)
        };
        // A sample can give a larger lower bound.
        let raise = |proved: CertifiedBounds| {
            proved.raised_by(&found.forward, &a, &b).raised_by(&found.backward, &b, &a)
        };
        let bounds = exact.map(prove).transpose()?.map(raise);
        Ok((found, bounds, size))
    })?;
    let told = PyDict::new(py);
    told.set_item("forward", side(py, &found.forward)?)?;
    told.set_item("backward", side(py, &found.backward)?)?;
    told.set_item("mean", found.mean())?;
    told.set_item("rms", found.rms())?;
    told.set_item("max", found.hausdorff())?;
    told.set_item("diagonal", size)?;
    let bounds = bounds.map(|proved| (proved.lower, proved.upper, proved.converged));
    told.set_item("bounds", bounds)?;
    Ok(told)
}

fn side<'py>(py: Python<'py>, side: &OneSided) -> PyResult<Bound<'py, PyDict>> {
    let told = PyDict::new(py);
    told.set_item("mean", side.mean)?;
    told.set_item("rms", side.rms)?;
    told.set_item("max", side.max)?;
    told.set_item("max_at", side.worst.from.to_array())?;
    told.set_item("max_to", side.worst.to.to_array())?;
    Ok(told)
}

/// The distance of every vertex of a mesh from another mesh.
#[pyfunction]
pub(crate) fn vertex_distances<'py>(
    py: Python<'py>,
    call: &Call,
    points: &MeshData,
    surface: &MeshData,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (from, to) = (points.content(), surface.content());
    let found = run(py, call, move |watch| {
        let surface = mesh_work::surface(&to.model.soup).map_err(Failure::from)?;
        watch.check()?;
        let points = from.model.soup.positions();
        surface.distances_until(points, &|| watch.is_cancelled()).ok_or_else(Ended::interrupted)
    })?;
    Ok(found.into_pyarray(py))
}
