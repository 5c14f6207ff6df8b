//! `curvmesh.flip`.

use std::ops::ControlFlow;

use dtri_flip::{
    Anneal, CostName, FlipOptions, FlipReport, Phase, Progress, Rebuild, ShapeConstraint, Ties,
    optimise_with,
};
use mesh_core::build::Weld;
use mesh_work::Seams;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::failure::Failure;
use crate::flip_functions::FunctionCost;
use crate::host::{Call, State, run};
use crate::mesh::MeshData;
use crate::options::{angle, area, seconds};

/// How to flip, as it comes from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct FlipsGiven {
    area: String,
    look_ahead: usize,
    rebuild_effort: Option<usize>,
    rebuild_largest: usize,
    anneal_steps: Option<usize>,
    feature_angle: Option<f64>,
    shape_constraint: Option<String>,
    max_fold: Option<f64>,
    no_intersections: bool,
    random_ties: bool,
    seed: u64,
    max_flips: Option<u64>,
    time_limit: Option<f64>,
}

impl FlipsGiven {
    fn shape(&self) -> Result<Option<ShapeConstraint>, Failure> {
        let name = self.shape_constraint.as_deref();
        name.map(str::parse).transpose().map_err(Failure::option)
    }

    fn options(&self) -> Result<FlipOptions, Failure> {
        let anneal =
            |steps_per_edge| Anneal { seed: self.seed, steps_per_edge, ..Anneal::default() };
        let (seed, largest) = (self.seed, self.rebuild_largest);
        Ok(FlipOptions {
            look_ahead: self.look_ahead,
            rebuild: self.rebuild_effort.map(|effort| Rebuild { seed, effort, largest }),
            anneal: self.anneal_steps.map(anneal),
            feature_angle: angle("feature_angle", self.feature_angle)?,
            shape: self.shape()?,
            max_fold: angle("max_fold", self.max_fold)?,
            forbid_intersections: self.no_intersections,
            ties: if self.random_ties { Ties::Seeded(self.seed) } else { Ties::EdgeId },
            max_flips: self.max_flips,
            time_limit: seconds("time_limit", self.time_limit)?,
            ..FlipOptions::default()
        })
    }
}

/// What is lowered: a cost by its name, or functions.
#[derive(FromPyObject)]
pub(crate) enum CostGiven<'py> {
    Name(String),
    #[pyo3(transparent)]
    Functions(Bound<'py, PyAny>),
}

/// Flips edges until no flip lowers the cost.
#[pyfunction]
pub(crate) fn flip<'py>(
    py: Python<'py>,
    call: &Call,
    mesh: &MeshData,
    cost: CostGiven<'py>,
    options: FlipsGiven,
) -> PyResult<(MeshData, Bound<'py, PyDict>)> {
    enum By {
        Name(CostName),
        Functions(FunctionCost),
    }
    let by = match cost {
        CostGiven::Name(name) => {
            let name = name.parse::<CostName>().map_err(Failure::option);
            By::Name(name.map_err(|failure| failure.raise(py))?)
        }
        CostGiven::Functions(functions) => By::Functions(FunctionCost::of(&functions)?),
    };
    let settings = || Ok((options.options()?, area(&options.area)?));
    let (mut settings, area) = settings().map_err(|failure: Failure| failure.raise(py))?;
    let content = mesh.content();
    let (mesh, report) = run(py, call, move |watch| {
        let source = content.source()?;
        let mut mesh = source.mesh.clone();
        let seams = Seams::find(mesh.topology(), source.provenance, source.model);
        settings.locked = Some(seams.edges.clone());
        let mut most = 1;
        let progress =
            &mut |now: Progress| -> ControlFlow<()> { watch.tell(state(now, &mut most)) };
        let report = match by {
            By::Name(name) => name.optimise(&mut mesh, area, &settings, progress),
            By::Functions(mut cost) => {
                cost.watched(watch);
                optimise_with(&mut mesh, &cost, &settings, progress)
            }
        };
        let report = report.map_err(Failure::from)?;
        let corners = seams.corner_source(mesh.topology());
        let mut model = source.to_model(&mesh, &corners).map_err(Failure::from)?;
        model.vertex_normals = None;
        model.corner_normals = None;
        Ok((MeshData::new(model, Weld::None), report))
    })?;
    Ok((mesh, told(py, &report)?))
}

/// The state of a run. The completed share is relative to the largest remaining work so far.
fn state(now: Progress, most: &mut u64) -> State {
    *most = now.remaining.max(*most);
    let phase = match now.phase {
        Phase::Greedy => "greedy",
        Phase::Rebuilding => "rebuilding",
        _ => "annealing",
    };
    State {
        phase,
        fraction: 1.0 - now.remaining as f64 / *most as f64,
        faces: None,
        steps: now.flips,
        cost: Some(now.cost),
    }
}

fn told<'py>(py: Python<'py>, report: &FlipReport) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    found.set_item("cost_before", report.cost_before)?;
    found.set_item("cost_after", report.cost_after)?;
    found.set_item("flips", report.flips)?;
    found.set_item("annealed_flips", report.annealed_flips)?;
    found.set_item("locked_edges", report.locked_edges)?;
    found.set_item("stop", report.stop.to_string())?;
    found.set_item("rebuilt", report.rebuilt)?;
    let refused = PyDict::new(py);
    for (reason, count) in report.rejected.by_reason().into_iter().filter(|&(_, count)| count > 0) {
        refused.set_item(reason, count)?;
    }
    found.set_item("refused", refused)?;
    Ok(found)
}
