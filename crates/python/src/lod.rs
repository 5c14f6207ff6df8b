//! `curvmesh.lod` and `curvmesh.Record`.

use std::fs::File;
use std::io::{BufReader, Write};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use ::simplify::{Progress, simplify_observed};
use mesh_core::build::Weld;
use mesh_work::{Attributes, LevelOfDetail, LevelRecord, LevelSteps};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBytes, PyDict, PyList};

use crate::failure::Failure;
use crate::host::{Call, run};
use crate::length::{Given, units};
use crate::mesh::MeshData;
use crate::simplify::{ChoicesGiven, ConstraintsGiven, LogData, RulesGiven, state};

/// Levels, as they come from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct StepsGiven {
    ratios: Vec<f64>,
    faces: Vec<usize>,
    errors: Vec<Given>,
    relative: bool,
}

/// Levels of detail: from a run, or from its record.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "groups of options of Python")]
pub(crate) fn lod<'py>(
    py: Python<'py>,
    call: &Call,
    mesh: &MeshData,
    steps: StepsGiven,
    choices: ChoicesGiven,
    rules: RulesGiven,
    constraints: ConstraintsGiven,
    record: Option<&LogData>,
) -> PyResult<(Bound<'py, PyList>, LogData)> {
    let settings = || -> Result<_, Failure> {
        let errors =
            steps.errors.iter().map(|e| e.length("errors")).collect::<Result<Vec<_>, _>>()?;
        if let Some(ratio) = steps.ratios.iter().find(|r| !(0.0..=1.0).contains(*r)) {
            return Err(Failure::option(format!("ratios has {ratio}; they must be from 0 to 1")));
        }
        let keep_seams = constraints.keep_seams;
        let constraints = constraints.choices(steps.relative)?;
        Ok((errors, choices.choices()?, rules.rules()?, (constraints, keep_seams)))
    };
    let (errors, choices, rules, (constraints, keep_seams)) =
        settings().map_err(|failure| failure.raise(py))?;
    let content = mesh.content();
    let shared = Arc::clone(&content);
    let known = record.map(|record| Arc::clone(&record.record));
    let (levels, record) = run(py, call, move |watch| {
        let source = shared.source()?;
        let in_units = errors.into_iter().map(|e| units(Some(e), source.mesh, steps.relative));
        let errors = in_units.filter_map(Result::transpose).collect::<Result<_, _>>()?;
        let steps = LevelSteps { ratios: steps.ratios, faces: steps.faces, errors };
        let attributes = Attributes::find(source, &rules).map_err(Failure::from)?;
        let (record, attributes) = match known {
            Some(record) => {
                let attributes = record.attributes(source.mesh, attributes);
                (record, attributes)
            }
            None => {
                let options = choices.options(source.mesh, steps.limits());
                let limits = (&constraints, keep_seams);
                let plan = steps.plan(source, options, attributes, limits, choices.check());
                let plan = plan.map_err(Failure::option)?;
                let observe = &mut |now: &Progress| -> ControlFlow<()> { watch.tell(state(now)) };
                let result = simplify_observed(source.mesh, &plan.options, observe);
                let log = result.map_err(Failure::from)?.log;
                (Arc::new(plan.record(source.mesh, log)), plan.attributes)
            }
        };
        watch.check()?;
        let levels =
            steps.levels(&record, source, &attributes, choices.check()).map_err(Failure::from)?;
        Ok((levels, record))
    })?;
    let list = PyList::empty(py);
    for LevelOfDetail { model, collapses, distance, .. } in levels {
        let level = PyDict::new(py);
        level.set_item("mesh", MeshData::new(model, Weld::None))?;
        level.set_item("collapses", collapses)?;
        level.set_item("mean", distance.mean())?;
        level.set_item("rms", distance.rms())?;
        level.set_item("max", distance.hausdorff())?;
        list.append(level)?;
    }
    Ok((list, LogData { record, content }))
}

/// Writes the record of a run: `CURVLOD1`.
#[pyfunction]
pub(crate) fn save_record(
    py: Python<'_>,
    call: &Call,
    record: &LogData,
    path: PathBuf,
) -> PyResult<()> {
    let (record, content) = (Arc::clone(&record.record), Arc::clone(&record.content));
    run(py, call, move |_| {
        let mesh = &content.whole()?.mesh;
        let write = |writer: &mut dyn Write| record.write(mesh, writer);
        let written = mesh_io::replace_file(&path, write);
        Ok(written.map_err(Failure::from)?)
    })
}

/// The content of such a file.
#[pyfunction]
pub(crate) fn record_bytes<'py>(
    py: Python<'py>,
    call: &Call,
    record: &LogData,
) -> PyResult<Bound<'py, PyBytes>> {
    let (record, content) = (Arc::clone(&record.record), Arc::clone(&record.content));
    let bytes = run(py, call, move |_| {
        let mut bytes = Vec::new();
        let written = record.write(&content.whole()?.mesh, &mut bytes);
        written.map_err(|error| Failure::internal(error).into()).map(|()| bytes)
    })?;
    Ok(PyBytes::new(py, &bytes))
}

/// A file, by its path or its content.
#[derive(FromPyObject)]
pub(crate) enum RecordFile {
    Content(PyBackedBytes),
    Path(PathBuf),
}

/// Reads the record of a run on this mesh.
#[pyfunction]
pub(crate) fn load_record(
    py: Python<'_>,
    call: &Call,
    file: RecordFile,
    mesh: &MeshData,
) -> PyResult<LogData> {
    let content = mesh.content();
    let shared = Arc::clone(&content);
    let record = run(py, call, move |_| {
        let mesh = &shared.whole()?.mesh;
        let record = match &file {
            RecordFile::Content(bytes) => LevelRecord::read(mesh, &mut &bytes[..]),
            RecordFile::Path(path) => {
                let file = File::open(path).map_err(|error| Failure::opening(path, &error))?;
                LevelRecord::read(mesh, &mut BufReader::new(file))
            }
        };
        Ok(record.map_err(Failure::from)?)
    })?;
    Ok(LogData { record: Arc::new(record), content })
}

/// What the vertices of the mesh have become after so many collapses.
#[pyfunction]
pub(crate) fn representatives<'py>(
    py: Python<'py>,
    record: &LogData,
    collapses: usize,
) -> PyResult<Bound<'py, PyArray1<i32>>> {
    let whole = record.content.whole().map_err(|failure| failure.raise(py))?;
    let of_mesh = record.record.log.representatives(&whole.mesh, collapses);
    let ids = of_mesh.as_slice().iter().map(|v| v.get().cast_signed()).collect();
    Ok(whole.of_vertices(ids, -1).into_pyarray(py))
}
