//! `curvmesh curvature --estimator vertex`: discrete curvature of every vertex. And `auto`: the same sums and quantities
//! of vertices, with pointwise quantities of fitted surfaces.

use dcurv::{CurvatureOptions, JetFitOptions, Totals};
use mesh_core::{Topology, TriMesh, VertexMap, parallel};
use mesh_io::{Format, Model};
use mesh_render::Scale;
use mesh_view::Page;
use mesh_work::{FrameValues, Integrals, Loaded, Quantity, VertexValues};
use serde::Serialize;

use crate::colormap::opaque;
use crate::commands::curvature::frame::{
    Found, UNKNOWN, add_frames, estimator, frames, has_numbers,
};
use crate::commands::curvature::options::{Curvature, EstimatorName};
use crate::commands::curvature::orientation::load;
use crate::console::Console;
use crate::decimal::Decimal;
use crate::failure::Failure;
use crate::load::Seconds;
use crate::replaced::Replaced;
use crate::task::{Done, Report, Task};
use crate::view::{self, name_of};

#[derive(Serialize)]
pub(super) struct Results {
    estimator: &'static str,
    settings: Settings,
    #[serde(flatten)]
    found: Option<Found>,
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

#[derive(Serialize)]
struct Settings {
    #[serde(flatten)]
    vertex: CurvatureOptions,
    #[serde(flatten)]
    fit: Option<JetFitOptions>,
}

/// What the estimators found.
struct Values {
    vertex: VertexValues,
    /// With `auto`.
    frames: Option<FrameValues>,
}

impl Values {
    fn of(options: &Curvature, mesh: &TriMesh, console: &Console) -> Result<Self, Failure> {
        let vertex = VertexValues::of(mesh, options.area.into());
        let is_auto = options.estimate.estimator == EstimatorName::Auto;
        let frames = is_auto.then(|| frames(mesh, estimator(options, mesh)?, console));
        Ok(Self { vertex, frames: frames.transpose()? })
    }

    /// A quantity of every vertex; NaN where it is unknown.
    fn of_quantity(&self, quantity: Quantity) -> VertexMap<f64> {
        match &self.frames {
            Some(frames) if !quantity.is_of_star() => frames.of_quantity(quantity),
            _ => self.vertex.of_quantity(quantity),
        }
    }
}

pub(crate) fn run(options: &Curvature, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    let (loaded, inside_out) = load(options, task, &mut seconds, console)?;
    let values =
        Seconds::time(&mut seconds.compute, || Values::of(options, &loaded.mesh, console))?;
    let found = values.frames.as_ref().map(|frames| Found::new(frames, &loaded.mesh));
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
        let mut replaced = Replaced::default();
        let model = loaded.into_model().map_err(Failure::model)?;
        let model = colored(model, format, &values, (&shown, &scale), &mut replaced);
        replaced.tell(&task.input, console);
        task.save(&model, &options.job.save, &mut seconds, console)?;
        console.message(options.colors.explain(&scale));
    }
    let totals = values.vertex.curvatures.totals();
    let results = Results::new(options, values.vertex.integrals(), &totals, &scale);
    let mut results = Results {
        extrinsic: Some(values.vertex.total_extrinsic()),
        inside_out: Some(inside_out),
        found,
        ..results
    };
    if let Some(frames) = &values.frames {
        results.estimator = "auto";
        results.settings.fit = frames.fit;
    }
    let report = task.report(console, counts, results, seconds);
    if let Some(page) = page {
        options.look.write(page, &report, console)?;
    }
    done(&report, console)
}

/// Prints the report.
pub(super) fn done(report: &Report<Results>, console: &Console) -> Result<Done, Failure> {
    let Integrals { integral_gaussian, integral_abs_mean, .. } = report.results.integrals;
    let brief =
        format!("integral of K {integral_gaussian:.6}, of |H| {}", Decimal(integral_abs_mean));
    report.done(console, summary(report), brief)
}

/// The page that shows the mesh with every quantity.
fn page(
    options: &Curvature,
    task: &Task,
    loaded: &Loaded,
    values: &Values,
    shown: &VertexMap<f64>,
    scale: &Scale,
) -> Result<Page, Failure> {
    let model = loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
    let format = Some(Format::Ply);
    let model = colored(model, format, values, (shown, scale), &mut Replaced::default());
    let mut exhibit =
        view::content(&name_of(&task.input), &task.input, &model, &options.job.loading)?;
    exhibit.vertex_colors = None;
    exhibit.directions = match &values.frames {
        Some(frames) => view::directions(&frames.of_vertex.map(|v| v.as_ref().map(|v| v.frame))),
        None => view::principal_directions(&loaded.mesh),
    };
    Ok(options.page("curvature", "vertex", exhibit, scale))
}

/// The colours and their range; unknown values are ignored.
fn scale(options: &Curvature, topology: &Topology, shown: &VertexMap<f64>) -> Scale {
    let known = topology.vertices().map(|v| shown[v]).filter(|value| !value.is_nan());
    options.colors.scale(options.quantity.is_signed(), known.collect())
}

/// The content of the output: the mesh, its colours, and every quantity as a named number if the format can store it.
fn colored(
    mut model: Model,
    format: Option<Format>,
    values: &Values,
    (shown, scale): (&VertexMap<f64>, &Scale),
    replaced: &mut Replaced,
) -> Model {
    let shown = shown.as_slice();
    let color = |value: f64| if value.is_nan() { UNKNOWN } else { opaque(scale.color(value)) };
    replaced.take(&mut model.vertex_colors);
    model.vertex_colors = Some(parallel::collect(shown.len(), |i| color(shown[i])));
    if has_numbers(format) {
        for &quantity in Quantity::ALL {
            let values = values.of_quantity(quantity).into_vec();
            replaced.set(&mut model.vertex_scalars, quantity.property(), values);
        }
        if let Some(frames) = &values.frames {
            add_frames(&mut model, frames, replaced);
        }
    }
    model
}

impl Results {
    pub(super) fn new(
        options: &Curvature,
        integrals: Integrals,
        totals: &Totals,
        scale: &Scale,
    ) -> Self {
        let vertex = CurvatureOptions { area: options.area.into() };
        Self {
            estimator: "vertex",
            settings: Settings { vertex, fit: None },
            found: None,
            integrals,
            extrinsic: None,
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
    let mut text = format!(
        "{file}: integral of K {integral_gaussian:.6}, integral of |H| {}\n  F1 {f1:.6}, F2 {}, F3 {}, Willmore {willmore:.6}\n  {clamped} of {vertices} vertices have H² < K",
        Decimal(*integral_abs_mean),
        Decimal(*f2),
        Decimal(*f3),
    );
    if let Some(found) = &report.results.found {
        text += &format!("\n  fitted surfaces: {}", found.line(vertices));
    }
    text
}
