//! `curvmesh.distance`.

use std::borrow::Cow;

use mesh_core::build::{Repair, Weld};
use mesh_io::Model;
use mesh_metric::{
    CertifiedBounds, CertifyOptions, CompareOptions, Comparison, OneSided, SignedDistance,
    SignedSide, Surface, compare_one_way_until, compare_signed_until, compare_until,
    hausdorff_bounds_until,
};
use mesh_work::{Loaded, diagonal, drop_not_finite, is_point_cloud, surface_or_points};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::content::Content;
use crate::failure::{Ended, Failure};
use crate::host::{Call, run};
use crate::length::{Given, length};
use crate::mesh::MeshData;
use crate::repair_warning;

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
    signed: bool,
    seed: u64,
) -> PyResult<Bound<'py, PyDict>> {
    let exact = length("exact", exact).map_err(|failure| failure.raise(py))?;
    let (first, second) = (first.content(), second.content());
    let measured = run(py, call, move |watch| {
        let models = [finite(&first.model)?, finite(&second.model)?];
        let soups = models.each_ref().map(|model| &model.soup);
        let [is_cloud, other_is_cloud] = soups.map(is_point_cloud);
        check_points([is_cloud, other_is_cloud], signed, exact.is_some())?;
        let a = surface_or_points(soups[0]).map_err(Failure::from)?;
        let b = surface_or_points(soups[1]).map_err(Failure::from)?;
        watch.check()?;
        let size = a.bounding_box().diagonal();
        let exact = exact.map(|length| length.in_units(relative, || diagonal(Some(size))));
        let exact = exact.transpose()?;
        let is_sampled = !is_cloud && !other_is_cloud;
        let options = match is_sampled {
            true => CompareOptions { samples, seed, ..CompareOptions::default() },
            false => CompareOptions::for_points(),
        };
        let stops = || watch.is_cancelled();
        let [forward, backward] = if is_sampled {
            let found = compare_until(&a, &b, &options, &stops).ok_or_else(Ended::interrupted)?;
            [Some(found.forward), Some(found.backward)]
        } else {
            let one_way = |from: &Surface, to: &Surface| {
                compare_one_way_until(from, to, &options, &stops).ok_or_else(Ended::interrupted)
            };
            // Surfaces are not measured to points.
            let forward = is_cloud.then(|| one_way(&a, &b)).transpose()?;
            [forward, other_is_cloud.then(|| one_way(&b, &a)).transpose()?]
        };
        let solid = |content: &Content, is_cloud: bool| {
            let mut joined = Repair::strict();
            joined.weld = Weld::Exact;
            let build = || Loaded::build_with_needed_repairs(content.model.clone(), &joined);
            (signed && !is_cloud).then(build).transpose().map_err(Failure::from)
        };
        let (of_a, of_b) = (solid(&first, is_cloud)?, solid(&second, other_is_cloud)?);
        let signs = |from: &Surface, to: &Option<Loaded>| -> Result<Option<SignedSide>, Ended> {
            let Some(solid) = to else { return Ok(None) };
            let to = SignedDistance::negative_inside(&solid.mesh).map_err(Failure::from)?;
            let found = compare_signed_until(from, &to, &options, &stops);
            found.map(Some).ok_or_else(Ended::interrupted)
        };
        let forward = forward.map(|side| Ok::<_, Ended>((side, signs(&a, &of_b)?))).transpose()?;
        let backward =
            backward.map(|side| Ok::<_, Ended>((side, signs(&b, &of_a)?))).transpose()?;
        let known = forward.as_ref().or(backward.as_ref()).map(|either| {
            let side = |side: &Option<Side>| side.as_ref().unwrap_or(either).0;
            Comparison { forward: side(&forward), backward: side(&backward) }
        });
        let found = known.ok_or_else(Ended::interrupted)?;
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
        Ok(([forward, backward], found, bounds, size))
    })?;
    let ([forward, backward], found, bounds, size) = measured;
    let told = PyDict::new(py);
    told.set_item("forward", forward.map(|found| side(py, &found)).transpose()?)?;
    told.set_item("backward", backward.map(|found| side(py, &found)).transpose()?)?;
    told.set_item("mean", found.mean())?;
    told.set_item("rms", found.rms())?;
    told.set_item("max", found.hausdorff())?;
    told.set_item("diagonal", size)?;
    let bounds = bounds.map(|proved| (proved.lower, proved.upper, proved.converged));
    told.set_item("bounds", bounds)?;
    Ok(told)
}

/// The distances in a direction, and the signed ones.
type Side = (OneSided, Option<SignedSide>);

/// The content without vertices at infinite or undefined positions. A warning has their number.
fn finite(model: &Model) -> Result<Cow<'_, Model>, Failure> {
    if model.soup.positions().iter().all(|position| position.is_finite()) {
        return Ok(Cow::Borrowed(model));
    }
    let (model, report) = drop_not_finite(model.clone())?;
    repair_warning::put(&report.repairs().collect::<Vec<_>>());
    Ok(Cow::Owned(model))
}

/// Refuses what has no meaning for points without faces.
fn check_points(are_clouds: [bool; 2], signed: bool, proves: bool) -> Result<(), Failure> {
    if signed && are_clouds[1] {
        let cure = "signed needs a surface to measure to, but the second mesh has points only; \
                    exchange the meshes if the first one is a surface";
        return Err(Failure::option(cure));
    }
    if proves && are_clouds != [false; 2] {
        return Err(Failure::option("exact is for two surfaces, but a mesh has points only"));
    }
    Ok(())
}

fn side<'py>(py: Python<'py>, (side, signed): &Side) -> PyResult<Bound<'py, PyDict>> {
    let told = PyDict::new(py);
    told.set_item("mean", side.mean)?;
    told.set_item("rms", side.rms)?;
    told.set_item("max", side.max)?;
    told.set_item("max_at", side.worst.from.to_array())?;
    told.set_item("max_to", side.worst.to.to_array())?;
    let signed = signed
        .map(|SignedSide { rule, mean, min, max, inside }| (rule.name(), mean, min, max, inside));
    told.set_item("signed", signed)?;
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
        let surface = surface_or_points(&finite(&to.model)?.soup).map_err(Failure::from)?;
        watch.check()?;
        let points = from.model.soup.positions();
        surface.distances_until(points, &|| watch.is_cancelled()).ok_or_else(Ended::interrupted)
    })?;
    Ok(found.into_pyarray(py))
}
