//! `curvmesh.simplify`.

use std::ops::ControlFlow;
use std::str::FromStr;
use std::sync::Arc;

use ::simplify::{
    FaceLimits, LogEntry, Options, Phase, Preset, Progress, Simplified, Target, simplify_observed,
    simplify_with,
};
use mesh_core::as_u32;
use mesh_core::build::Weld;
use mesh_work::{AttributeRules, Attributes, Choices, ConstraintChoices, LevelRecord};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::collapse_functions::CollapseFunctions;
use crate::content::Content;
use crate::failure::{Ended, Failure};
use crate::host::{Call, State, Watch, run};
use crate::length::{Given, length, units};
use crate::mesh::MeshData;
use crate::options::{angle, not_negative, seconds};
use crate::views::signed;

/// What is changed of a preset, as it comes from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ChoicesGiven {
    preset: String,
    placement: Option<String>,
    curvature_weight: Option<f64>,
    fit_rounds: Option<usize>,
    norm: Option<String>,
    anneal_time: Option<f64>,
    lock_boundary: bool,
    feature_angle: Option<f64>,
    no_intersections: bool,
    min_component_vertices: Option<usize>,
    verify: bool,
    seed: u64,
}

/// What a name stands for, if there is one.
fn parsed<T: FromStr<Err: std::error::Error>>(name: Option<&str>) -> Result<Option<T>, Failure> {
    name.map(|name| name.parse().map_err(|error: T::Err| Failure::option(error))).transpose()
}

impl ChoicesGiven {
    pub(crate) fn choices(&self) -> Result<Choices, Failure> {
        let choices = Choices {
            preset: self.preset.parse::<Preset>().map_err(Failure::option)?,
            placement: parsed(self.placement.as_deref())?,
            curvature_weight: not_negative("curvature_weight", self.curvature_weight)?,
            fit_rounds: self.fit_rounds,
            norm: parsed(self.norm.as_deref())?,
            anneal_time: seconds("anneal_time", self.anneal_time)?,
            lock_boundary: self.lock_boundary,
            feature_angle: angle("feature_angle", self.feature_angle)?,
            no_intersections: self.no_intersections,
            min_component_vertices: self.min_component_vertices,
            verify: self.verify,
            seed: self.seed,
        };
        if choices.norm.is_some() && !choices.fits() {
            let cure = "norm has no effect: the result is not fitted; set fit_rounds";
            return Err(Failure::option(cure));
        }
        if choices.anneal_time.is_some() && !choices.anneals() {
            let cure = "anneal_time has no effect: the result is not annealed; set preset to \
                        \"quality\" or \"extreme\"";
            return Err(Failure::option(cure));
        }
        Ok(choices)
    }
}

/// What becomes of attributes, as it comes from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct RulesGiven {
    attribute_weight: f64,
    normal_weight: f64,
    crease_angle: f64,
    keep_creases: bool,
    attributes: bool,
}

impl RulesGiven {
    pub(crate) fn rules(&self) -> Result<AttributeRules, Failure> {
        let given = AttributeRules::default();
        let weight = |option, value| not_negative(option, Some(value));
        Ok(AttributeRules {
            attribute_weight: weight("attribute_weight", self.attribute_weight)?
                .unwrap_or(given.attribute_weight),
            normal_weight: weight("normal_weight", self.normal_weight)?
                .unwrap_or(given.normal_weight),
            crease_angle: angle("crease_angle", Some(self.crease_angle))?
                .unwrap_or(given.crease_angle),
            keep_creases: self.keep_creases,
            carry: self.attributes,
        })
    }
}

/// Constraints, as they come from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ConstraintsGiven {
    keep: Option<String>,
    weight: Option<String>,
    max_edge: Option<Given>,
    min_angle: Option<f64>,
    max_valence: Option<usize>,
    pub(crate) keep_seams: bool,
}

impl ConstraintsGiven {
    pub(crate) fn choices(self, relative: bool) -> Result<ConstraintChoices, Failure> {
        Ok(ConstraintChoices {
            keep: self.keep,
            weight: self.weight,
            max_edge: length("max_edge", self.max_edge)?,
            min_angle: angle("min_angle", self.min_angle)?,
            max_valence: self.max_valence,
            relative,
        })
    }
}

/// When to stop, as it comes from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct TargetsGiven {
    faces: Option<usize>,
    vertices: Option<usize>,
    ratio: Option<f64>,
    max_error: Option<Given>,
    max_cost: Option<f64>,
    time_limit: Option<f64>,
    relative: bool,
}

/// The collapses of a run, with the mesh that they belong to.
#[pyclass(frozen, module = "curvmesh._core")]
pub(crate) struct LogData {
    pub(crate) record: Arc<LevelRecord>,
    pub(crate) content: Arc<Content>,
}

#[pymethods]
impl LogData {
    fn __len__(&self) -> usize {
        self.record.log.len()
    }

    /// The mesh that the collapses belong to.
    fn mesh(&self) -> MeshData {
        MeshData::shared(&self.content)
    }

    /// The collapses as columns.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let entries = self.record.log.entries();
        let found = PyDict::new(py);
        let ids =
            |of: fn(&LogEntry) -> u32| signed(entries.iter().map(of).collect()).into_pyarray(py);
        found.set_item("removed", ids(|e| e.removed.get()))?;
        found.set_item("kept", ids(|e| e.kept.get()))?;
        found.set_item("faces_before", ids(|e| e.faces_before))?;
        let costs: Vec<f64> = entries.iter().map(|e| e.cost).collect();
        found.set_item("cost", costs.into_pyarray(py))?;
        let positions = entries.iter().map(|e| e.position).collect();
        found.set_item("position", crate::views::points(py, positions)?)?;
        Ok(found)
    }
}

/// The state of a run.
pub(crate) fn state(now: &Progress) -> State {
    let Progress { phase, faces_before, faces, face_target, collapses } = *now;
    let whole = faces_before.saturating_sub(face_target).max(1) as f64;
    let collapsed = faces_before.saturating_sub(faces) as f64 / whole;
    // The end of the steps after the collapses is not known in advance.
    let fraction = match phase {
        Phase::Collapse => 0.5 * collapsed,
        Phase::Search | Phase::Fit => 0.6,
        Phase::Anneal => 0.7,
        Phase::MaxError | Phase::DecimateToTolerance => 0.8,
        _ => 0.9,
    };
    State { phase: phase.name(), fraction, faces: Some(faces), steps: collapses as u64, cost: None }
}

struct Done {
    mesh: MeshData,
    result: Simplified,
    map: Vec<i32>,
    charts: Option<(usize, usize)>,
    /// The number of faces that charts were merged for.
    room: Option<u32>,
    limits: FaceLimits,
}

/// Simplifies a mesh.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "groups of options of Python")]
pub(crate) fn simplify<'py>(
    py: Python<'py>,
    call: &Call,
    mesh: &MeshData,
    targets: TargetsGiven,
    choices: ChoicesGiven,
    rules: RulesGiven,
    constraints: ConstraintsGiven,
    cost: Option<Py<PyAny>>,
    weight: Option<Py<PyAny>>,
    constraint: Option<Py<PyAny>>,
) -> PyResult<(MeshData, Bound<'py, PyDict>)> {
    let settings = || -> Result<_, Failure> {
        let max_error = length("max_error", targets.max_error)?;
        let limits = Target {
            faces: targets.faces,
            vertices: targets.vertices,
            ratio: targets.ratio,
            cost: targets.max_cost,
            collapses: None,
            time: seconds("time_limit", targets.time_limit)?,
        };
        let keep_seams = constraints.keep_seams;
        let constraints = constraints.choices(targets.relative)?;
        Ok((limits, max_error, choices.choices()?, rules.rules()?, (constraints, keep_seams)))
    };
    let (limits, max_error, choices, rules, (constraints, keep_seams)) =
        settings().map_err(|f| f.raise(py))?;
    let content = mesh.content();
    let shared = Arc::clone(&content);
    let functions = CollapseFunctions { cost, weight, constraint };
    let done = run(py, call, move |watch| {
        let content = shared;
        let whole = content.whole()?;
        let source = content.source()?;
        let attributes = Attributes::find(source, &rules).map_err(Failure::from)?;
        let mut options: Options = choices.options(&whole.mesh, limits);
        options.record = true;
        let merged = (!keep_seams).then(|| attributes.merge_charts(&whole.mesh, &options.target));
        let attributes = merged.flatten().unwrap_or(attributes);
        attributes.constrain(&whole.mesh, &mut options);
        constraints.constrain(source, &mut options).map_err(Failure::option)?;
        if let Some(error) = units(max_error, &whole.mesh, targets.relative)? {
            options = options.within(error, choices.check());
        }
        let result = reduce(&whole.mesh, &options, functions, watch)?;
        let model =
            attributes.carry(source, &result.mesh, &result.vertex_map).map_err(Failure::from)?;
        let map = result.vertex_map.as_slice().iter();
        let map = map.map(|v| v.map_or(-1, |v| v.get().cast_signed())).collect();
        let charts = attributes.merged().map(|[before, after]| (before, after));
        let wanted = options.target.face_target(whole.mesh.topology().face_count());
        let room = charts.map(|_| as_u32(wanted));
        let (mesh, map) = (MeshData::new(model, Weld::None), whole.of_vertices(map, -1));
        Ok(Done { mesh, map, charts, room, limits: options.protect.limits, result })
    })?;
    report(py, done, content)
}

fn reduce(
    mesh: &mesh_core::TriMesh,
    options: &Options,
    functions: CollapseFunctions,
    watch: &Arc<Watch>,
) -> Result<Simplified, Ended> {
    let observe = &mut |now: &Progress| -> ControlFlow<()> { watch.tell(state(now)) };
    let result = if functions.is_none() {
        simplify_observed(mesh, options, observe)
    } else {
        let (policies, options) = functions.policies(options, watch);
        simplify_with(mesh, policies, &options, observe)
    };
    Ok(result.map_err(Failure::from)?)
}

fn report<'py>(
    py: Python<'py>,
    done: Done,
    content: Arc<Content>,
) -> PyResult<(MeshData, Bound<'py, PyDict>)> {
    let Done { mesh, result, map, charts, room, limits } = done;
    let found = PyDict::new(py);
    found.set_item("charts", charts)?;
    found.set_item("vertex_map", map.into_pyarray(py))?;
    found.set_item("stop", result.stop.name())?;
    let shortfall = result.shortfall.map(|shortfall| {
        let reasons = shortfall.held_by.into_iter();
        let held_by: Vec<(&str, usize)> = reasons.map(|(r, count)| (r.name(), count)).collect();
        (shortfall.wanted_faces, shortfall.wanted_vertices, held_by)
    });
    found.set_item("shortfall", shortfall)?;
    found.set_item("max_cost", result.max_cost)?;
    found.set_item("error", result.error.map(|e| (e.lower, e.upper)))?;
    found.set_item("boundary_shift", result.boundary_shift)?;
    let refused = PyDict::new(py);
    for (reason, count) in result.rejections.iter() {
        refused.set_item(reason.name(), count)?;
    }
    found.set_item("refused", refused)?;
    let fit = result
        .fit
        .map(|fit| (fit.rounds, fit.flips, fit.rms_before, fit.rms_last, fit.norm.name()));
    found.set_item("fit", fit)?;
    let turned = result.unfold.map(|unfold| (unfold.turned_before, unfold.turned_after));
    found.set_item("turned_over", turned)?;
    found.set_item("preset_kept", result.preset_kept.map(::simplify::Preset::name))?;
    let record = Arc::new(LevelRecord { log: result.log, room, limits });
    found.set_item("log", LogData { record, content })?;
    Ok((mesh, found))
}
