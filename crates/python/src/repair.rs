//! `curvmesh.repair` and `curvmesh.subdivide`: functions that change vertices and faces.

use mesh_core::build::{Repair, Weld};
use mesh_core::butterfly::{ButterflyOptions, IrregularRule};
use mesh_core::fill::FillOptions;
use mesh_work::{Loaded, diagonal, subdivide_step};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::failure::{Ended, Failure};
use crate::host::{Call, State, run};
use crate::length::Given;
use crate::mesh::MeshData;
use crate::views::signed;

/// Repairs, as they come from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct RepairsGiven {
    weld: Option<Given>,
    relative: bool,
    drop_out_of_range: bool,
    drop_not_finite: bool,
    drop_degenerate: bool,
    drop_duplicates: bool,
    reorient: bool,
    cut_non_manifold: bool,
    drop_unreferenced: bool,
}

/// Which holes are filled: of at most so many edges, or all.
#[derive(FromPyObject)]
pub(crate) enum Holes {
    UpTo(usize),
    All(String),
}

/// An oriented manifold of triangles.
#[pyfunction]
pub(crate) fn repair<'py>(
    py: Python<'py>,
    call: &Call,
    mesh: &MeshData,
    repairs: RepairsGiven,
    fill_holes: Option<Holes>,
) -> PyResult<(MeshData, Bound<'py, PyDict>)> {
    let settings = || -> Result<_, Failure> {
        let max_edges = match fill_holes {
            None => None,
            Some(Holes::UpTo(edges)) => Some(Some(edges)),
            Some(Holes::All(all)) if all == "all" => Some(None),
            Some(Holes::All(other)) => {
                let message =
                    format!("fill_holes is {other:?}; it must be a number of edges, or \"all\"");
                return Err(Failure::option(message));
            }
        };
        let fill = max_edges.map(|max_edges| FillOptions { max_edges, ..FillOptions::default() });
        let weld = match &repairs.weld {
            None => Weld::None,
            Some(Given::Text(text)) if text == "none" => Weld::None,
            Some(Given::Text(text)) if text == "seams" => Weld::Seams,
            Some(Given::Text(text)) if text == "exact" => Weld::Exact,
            Some(given) => {
                let size = || {
                    let bounds = mesh.model().soup.measure().bounds;
                    diagonal(bounds.map(|b| b.diagonal()))
                };
                Weld::Distance(given.length("weld")?.in_units(repairs.relative, size)?)
            }
        };
        let RepairsGiven {
            drop_out_of_range,
            drop_not_finite,
            drop_degenerate,
            drop_duplicates,
            reorient,
            cut_non_manifold,
            drop_unreferenced,
            ..
        } = repairs;
        let mut repair = Repair::strict();
        repair.weld = weld;
        repair.drop_out_of_range = drop_out_of_range;
        repair.drop_not_finite = drop_not_finite;
        repair.drop_degenerate = drop_degenerate;
        repair.drop_duplicates = drop_duplicates;
        repair.reorient = reorient;
        repair.cut_non_manifold = cut_non_manifold;
        repair.drop_unreferenced = drop_unreferenced;
        Ok((repair, fill))
    };
    let (repair, fill) = settings().map_err(|failure| failure.raise(py))?;
    let content = mesh.content();
    let (mesh, report, holes, sources) = run(py, call, move |watch| {
        let mut loaded = Loaded::build(content.model.clone(), &repair).map_err(Failure::from)?;
        watch.check()?;
        let holes = fill.map(|fill| loaded.fill_holes(&fill));
        let corners = loaded.provenance.corner_source.clone();
        let model = loaded.to_model(&corners).map_err(Failure::from)?;
        let provenance = loaded.provenance;
        let sources = (provenance.vertex_source, provenance.face_source);
        Ok((MeshData::new(model, Weld::None), loaded.report, holes, sources))
    })?;
    let told = PyDict::new(py);
    let counts = [
        ("triangulated_polygons", report.triangulated),
        ("welded_vertices", report.welded_vertices.count()),
        ("dropped_out_of_range", report.dropped_out_of_range.count()),
        ("not_finite_vertices", report.not_finite_vertices.count()),
        ("dropped_not_finite", report.dropped_not_finite.count()),
        ("dropped_degenerate", report.dropped_degenerate.count()),
        ("dropped_duplicates", report.dropped_duplicates.count()),
        ("reversed_faces", report.flipped_faces.count()),
        ("cut_edges", report.cut_edges.count()),
        ("split_vertices", report.split_vertices.count()),
        ("dropped_vertices", report.dropped_vertices.count()),
        ("zero_area_faces", report.zero_area_faces.count()),
        ("filled_holes", holes.as_ref().map_or(0, |holes| holes.filled.len())),
        ("left_holes", holes.as_ref().map_or(0, |holes| holes.left.len())),
    ];
    for (name, count) in counts {
        told.set_item(name, count)?;
    }
    told.set_item("unchanged", report.is_unchanged())?;
    told.set_item("vertex_source", signed(sources.0).into_pyarray(py))?;
    told.set_item("face_source", signed(sources.1).into_pyarray(py))?;
    Ok((mesh, told))
}

/// Butterfly subdivision.
#[pyfunction]
pub(crate) fn subdivide(
    py: Python<'_>,
    call: &Call,
    mesh: &MeshData,
    steps: u32,
    tension: f64,
    eight_point: bool,
) -> PyResult<(MeshData, usize)> {
    const MOST: u32 = 12;
    if !(1..=MOST).contains(&steps) {
        let message = format!("steps is {steps}; it must be from 1 to {MOST}");
        return Err(Failure::option(message).raise(py));
    }
    if !(0.0..=0.25).contains(&tension) {
        let message = format!("tension is {tension}; it must be from 0 to 0.25");
        return Err(Failure::option(message).raise(py));
    }
    let irregular = if eight_point { IrregularRule::EightPoint } else { IrregularRule::Zorin };
    let rules = ButterflyOptions { tension, irregular };
    let content = mesh.content();
    run(py, call, move |watch| -> Result<(MeshData, usize), Ended> {
        let source = content.source()?;
        let corners = &source.provenance.corner_source;
        let model = source.to_model(source.mesh, corners).map_err(Failure::from)?;
        let (mut mesh, mut model) = (source.mesh.clone(), model);
        // The subdivided surface has different normals.
        (model.vertex_normals, model.corner_normals) = (None, None);
        let mut straight_edges = 0;
        for step in 0..steps {
            let made = subdivide_step(&mesh, &model, &rules).map_err(Failure::from)?;
            (mesh, model) = (made.mesh, made.model);
            straight_edges += made.straight_edges;
            let fraction = f64::from(step + 1) / f64::from(steps);
            let faces = Some(mesh.topology().face_count());
            let state = State { phase: "subdivide", fraction, faces, ..State::default() };
            if watch.tell(state).is_break() {
                return Err(Ended::interrupted());
            }
        }
        Ok((MeshData::new(model, Weld::None), straight_edges))
    })
}
