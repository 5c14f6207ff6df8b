//! `curvmesh curvature --estimator vertex`: discrete curvature of every vertex.

use dcurv::{CurvatureOptions, Totals};
use mesh_core::{Topology, VertexMap, parallel};
use mesh_io::{Format, Model, Scalars};
use mesh_render::Scale;
use mesh_view::Page;
use mesh_work::{Integrals, Loaded, Quantity, VertexValues};
use serde::Serialize;

use crate::colormap::opaque;
use crate::commands::curvature::options::Curvature;
use crate::commands::curvature::orientation::load;
use crate::console::Console;
use crate::failure::Failure;
use crate::load::Seconds;
use crate::task::{Done, Report, Task};
use crate::view::{self, name_of};

#[derive(Serialize)]
pub(super) struct Results {
    settings: CurvatureOptions,
    #[serde(flatten)]
    integrals: Integrals,
    /// Total absolute extrinsic curvature; absent out of core.
    #[serde(skip_serializing_if = "Option::is_none")]
    extrinsic: Option<f64>,
    norm_l1: f64,
    norm_l2_squared: f64,
    clamped_vertices: usize,
    boundary_vertices: usize,
    /// Components that are inside out; unknown for a mesh that does not fit into memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    inside_out: Option<usize>,
    quantity: String,
    range: [f64; 2],
}

pub(crate) fn run(options: &Curvature, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    let (loaded, inside_out) = load(options, task, &mut seconds, console)?;
    let values =
        Seconds::time(&mut seconds.compute, || VertexValues::of(&loaded.mesh, options.area.into()));
    let shown = values.of_quantity(options.quantity);
    let scale = scale(options, loaded.mesh.topology(), &shown);
    let counts = loaded.counts();
    let page = if options.look.is_wanted() {
        Some(page(options, task, &loaded, &values, &shown, &scale)?)
    } else {
        None
    };
    if let Some(output) = &task.output {
        let format = options.job.save.format_of(output);
        let model =
            colored(loaded.into_model().map_err(Failure::model)?, format, &values, &shown, &scale);
        task.save(&model, &options.job.save, &mut seconds, console)?;
        console.message(options.colors.explain(&scale));
    }
    let totals = values.curvatures.totals();
    let extrinsic = Some(values.total_extrinsic());
    let results = Results::new(options, values.integrals(), &totals, extrinsic, &scale);
    let results = Results { inside_out: Some(inside_out), ..results };
    let report = task.report(console, counts, results, seconds);
    if let Some(page) = page {
        options.look.write(page, &report, console)?;
    }
    done(&report, console)
}

/// Prints the report.
pub(super) fn done(report: &Report<Results>, console: &Console) -> Result<Done, Failure> {
    let Integrals { integral_gaussian, integral_abs_mean, .. } = report.results.integrals;
    let brief = format!("integral of K {integral_gaussian:.6}, of |H| {integral_abs_mean:.6}");
    report.done(console, summary(report), brief)
}

/// The page that shows the mesh with every quantity.
fn page(
    options: &Curvature,
    task: &Task,
    loaded: &Loaded,
    values: &VertexValues,
    shown: &VertexMap<f64>,
    scale: &Scale,
) -> Result<Page, Failure> {
    let model = loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
    let model = colored(model, Some(Format::Ply), values, shown, scale);
    let mut exhibit =
        view::content(&name_of(&task.input), &task.input, &model, &options.job.loading)?;
    exhibit.vertex_colors = None;
    exhibit.directions = view::principal_directions(&loaded.mesh);
    Ok(options.page("curvature", "vertex", exhibit, scale))
}

/// The colours and their range; vertices without faces are ignored.
fn scale(options: &Curvature, topology: &Topology, shown: &VertexMap<f64>) -> Scale {
    let used = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v));
    options.colors.scale(options.quantity.is_signed(), used.map(|v| shown[v]).collect())
}

/// The content of the output: the mesh, its colours, and every quantity as a named number if the format can store it.
fn colored(
    mut model: Model,
    format: Option<Format>,
    values: &VertexValues,
    shown: &VertexMap<f64>,
    scale: &Scale,
) -> Model {
    let shown = shown.as_slice();
    let color = |value: f64| if value.is_nan() { UNKNOWN } else { opaque(scale.color(value)) };
    model.vertex_colors = Some(parallel::collect(shown.len(), |i| color(shown[i])));
    if !matches!(format, Some(Format::Ply | Format::Gltf | Format::Glb)) {
        return model;
    }
    for &quantity in Quantity::ALL {
        let name = quantity.property();
        model.vertex_scalars.retain(|scalars| scalars.name != name);
        let values = values.of_quantity(quantity).into_vec();
        model.vertex_scalars.push(Scalars::new(name, values));
    }
    model
}

/// The colour of a vertex without curvature.
const UNKNOWN: [f32; 4] = [0.5, 0.5, 0.5, 1.0];

impl Results {
    pub(super) fn new(
        options: &Curvature,
        integrals: Integrals,
        totals: &Totals,
        extrinsic: Option<f64>,
        scale: &Scale,
    ) -> Self {
        Self {
            settings: CurvatureOptions { area: options.area.into() },
            integrals,
            extrinsic,
            norm_l1: totals.norm_l1,
            norm_l2_squared: totals.norm_l2_squared,
            clamped_vertices: totals.clamped,
            boundary_vertices: totals.boundary,
            inside_out: None,
            quantity: options.quantity.to_string(),
            range: [scale.low, scale.high],
        }
    }
}

fn summary(report: &Report<Results>) -> String {
    let Integrals { integral_gaussian, integral_abs_mean, f1, f2, f3, willmore, .. } =
        &report.results.integrals;
    let (file, clamped, vertices) =
        (report.subject(), report.results.clamped_vertices, report.vertices);
    format!(
        "{file}: integral of K {integral_gaussian:.6}, integral of |H| {integral_abs_mean:.6}\n  F1 {f1:.6}, F2 {f2:.6}, F3 {f3:.6}, Willmore {willmore:.6}\n  {clamped} of {vertices} vertices have H² < K"
    )
}
