//! `curvmesh curvature --estimator auto`, `fit`, `ball` and `corrected`: principal curvatures and directions of every
//! vertex, fitted or averaged over balls.

use dcurv::{FitScale, JetFitOptions};
use mesh_core::glam::DVec3;
use mesh_core::{PolygonSoup, TriMesh};
use mesh_io::{Format, Model};
use mesh_render::Scale;
use mesh_work::{FrameEstimator, FrameValue, FrameValues, Integrals, Length, PointKind, Quantity};
use serde::Serialize;

use crate::colormap::opaque;
use crate::commands::curvature::options::{Curvature, EstimatorName, Shown};
use crate::commands::curvature::orientation::load;
use crate::console::Console;
use crate::decimal::Decimal;
use crate::failure::Failure;
use crate::load::Seconds;
use crate::replaced::Replaced;
use crate::task::{Done, Report, Task};
use crate::view::{self, name_of};

/// The property that is 1 for vertices with curvature, and 0 for vertices without. The other properties of such
/// vertices are NaN.
const KNOWN: &str = "curvature_known";

/// The property with the predicted error of k1 and k2.
const ERROR: &str = "curvature_error";

/// The property with what is at a vertex: 0 regular, 1 umbilic, 2 crease, 3 boundary, 4 unknown.
const KIND: &str = "curvature_kind";

/// All settings.
#[derive(Serialize)]
#[serde(untagged)]
enum Settings {
    Fit(JetFitOptions),
    Ball { radius: Option<f64> },
}

#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    integrals: Integrals,
    estimator: &'static str,
    settings: Settings,
    /// Only for `ball`.
    #[serde(skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
    /// Whether the default radius of balls was reduced to limit the time.
    radius_reduced: bool,
    #[serde(flatten)]
    found: Found,
    /// Components that are inside out; unknown for a mesh that does not fit into memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    inside_out: Option<usize>,
    quantity: String,
    range: [f64; 2],
}

/// What was found at the vertices.
#[derive(Serialize)]
pub(super) struct Found {
    /// The standard deviation of the noise that the scale follows, in model units.
    #[serde(skip_serializing_if = "Option::is_none")]
    noise: Option<f64>,
    vertices_without_curvature: usize,
    umbilics: usize,
    creases: usize,
}

impl Found {
    pub(super) fn new(values: &FrameValues, mesh: &TriMesh) -> Self {
        let without = mesh.topology().vertices().filter(|&v| values.of_vertex[v].is_none()).count();
        Self {
            noise: values.noise(),
            vertices_without_curvature: without,
            umbilics: values.count(mesh, PointKind::Umbilic),
            creases: values.count(mesh, PointKind::Crease),
        }
    }

    /// A line of the summary.
    pub(super) fn line(&self, vertices: usize) -> String {
        let noise = self.noise.map_or_else(String::new, |noise| format!("noise {noise:.3e}; "));
        format!(
            "{noise}vertices without curvature: {} of {vertices} ({} on creases); umbilic vertices: {}",
            self.vertices_without_curvature, self.creases, self.umbilics
        )
    }
}

/// How the options say that principal curvatures are estimated.
pub(super) fn estimator(options: &Curvature, mesh: &TriMesh) -> Result<FrameEstimator, Failure> {
    let estimate = &options.estimate;
    let length = |length: Option<Length>| {
        let on = |length: Length| length.on(mesh, options.job.loading.relative);
        length.map(on).transpose().map_err(Failure::refused)
    };
    let (radius, noise) = (length(estimate.radius)?, length(estimate.noise)?);
    Ok(match estimate.estimator {
        EstimatorName::Fit => FrameEstimator::fit(estimate.rings, radius, noise),
        EstimatorName::Ball => FrameEstimator::Ball { radius },
        EstimatorName::Corrected => FrameEstimator::Corrected { radius },
        _ => FrameEstimator::Auto { noise },
    })
}

/// The principal curvatures of all vertices, with a progress bar.
pub(super) fn frames(
    mesh: &TriMesh,
    estimator: FrameEstimator,
    console: &Console,
) -> Result<FrameValues, Failure> {
    let bar = console.progress(mesh.topology().vertex_count() as u64, "estimating");
    let values = FrameValues::of_observed(mesh, estimator, &|| bar.inc(1));
    bar.finish_and_clear();
    values.map_err(Failure::refused)
}

pub(crate) fn run(options: &Curvature, task: &Task, console: &Console) -> Result<Done, Failure> {
    let quantity = options.quantity;
    let mut seconds = Seconds::default();
    let (loaded, inside_out) = load(options, task, &mut seconds, console)?;
    let estimator = estimator(options, &loaded.mesh)?;
    let values = Seconds::time(&mut seconds.compute, || frames(&loaded.mesh, estimator, console))?;
    let known = values.of_vertex.as_slice().iter().flatten();
    let scale =
        options.colors.scale(quantity.is_signed(), known.map(|v| v.quantity(quantity)).collect());
    if let Some(output) = &task.output {
        let model = match options.estimate.shown {
            Shown::Mesh => {
                let format = options.job.save.format_of(output);
                let model =
                    loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
                let mut replaced = Replaced::default();
                let model = colored(model, format, &values, (quantity, &scale), &mut replaced);
                replaced.tell(&task.input, console);
                model
            }
            Shown::Arrows => arrows(&loaded.mesh, &values)?,
        };
        task.save(&model, &options.job.save, &mut seconds, console)?;
        if options.estimate.shown == Shown::Mesh {
            console.message(options.colors.explain(&scale));
        }
    }
    let results = Results {
        integrals: values.integrals(&loaded.mesh),
        estimator: match estimator {
            FrameEstimator::Auto { .. } => "auto",
            FrameEstimator::Fit(_) => "fit",
            FrameEstimator::Ball { .. } => "ball",
            _ => "corrected",
        },
        settings: values.fit.map_or(Settings::Ball { radius: values.radius }, Settings::Fit),
        radius: values.radius,
        radius_reduced: values.radius_reduced,
        found: Found::new(&values, &loaded.mesh),
        inside_out: Some(inside_out),
        quantity: quantity.to_string(),
        range: [scale.low, scale.high],
    };
    let report = task.report(console, loaded.counts(), results, seconds);
    if options.look.is_wanted() {
        let model = loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
        let format = Some(Format::Ply);
        let shown = (quantity, &scale);
        let model = colored(model, format, &values, shown, &mut Replaced::default());
        let mut exhibit =
            view::content(&name_of(&task.input), &task.input, &model, &options.job.loading)?;
        exhibit.vertex_colors = None;
        exhibit.directions =
            view::directions(&values.of_vertex.map(|v| v.as_ref().map(|v| v.frame)));
        let page = options.page("curvature", "vertex", exhibit, &scale);
        options.look.write(page, &report, console)?;
    }
    let Integrals { integral_gaussian, integral_abs_mean, .. } = report.results.integrals;
    let brief =
        format!("integral of K {integral_gaussian:.6}, of |H| {}", Decimal(integral_abs_mean));
    report.done(console, summary(&report), brief)
}

/// The mesh with its colours, and every quantity and the directions as named numbers if the format can store them.
fn colored(
    mut model: Model,
    format: Option<Format>,
    values: &FrameValues,
    (quantity, scale): (Quantity, &Scale),
    replaced: &mut Replaced,
) -> Model {
    let known = values.of_vertex.as_slice();
    let color =
        |v: &Option<FrameValue>| v.map_or(UNKNOWN, |v| opaque(scale.color(v.quantity(quantity))));
    replaced.take(&mut model.vertex_colors);
    model.vertex_colors = Some(known.iter().map(color).collect());
    if has_numbers(format) {
        for &quantity in Quantity::ALL.iter().filter(|q| !q.is_of_star()) {
            let values = values.of_quantity(quantity).into_vec();
            replaced.set(&mut model.vertex_scalars, quantity.property(), values);
        }
        add_frames(&mut model, values, replaced);
    }
    model
}

/// Whether a format can store named numbers.
pub(super) fn has_numbers(format: Option<Format>) -> bool {
    matches!(format, Some(Format::Ply | Format::Gltf | Format::Glb))
}

/// Sets directions, errors and kinds.
pub(super) fn add_frames(model: &mut Model, values: &FrameValues, replaced: &mut Replaced) {
    let mut set = |name: &str, values: Vec<f64>| {
        replaced.set(&mut model.vertex_scalars, name, values);
    };
    let known = values.of_vertex.as_slice();
    let mut add = |name: &str, of: &dyn Fn(&FrameValue) -> f64| {
        let values = known.iter().map(|v| v.as_ref().map_or(f64::NAN, of)).collect();
        set(name, values);
    };
    for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
        add(&format!("k1_{letter}"), &|v| v.frame.direction_max[axis]);
        add(&format!("k2_{letter}"), &|v| v.frame.direction_min[axis]);
    }
    if values.fit.is_some() {
        add(ERROR, &|v| v.error);
    }
    set(KNOWN, known.iter().map(|v| f64::from(u8::from(v.is_some()))).collect());
    let code = |kind: &PointKind| {
        let place = PointKind::ALL.iter().position(|other| other == kind);
        place.unwrap_or_default() as f64
    };
    set(KIND, values.kinds.as_slice().iter().map(code).collect());
}

/// The colour of vertices without curvature.
pub(super) const UNKNOWN: [f32; 4] = [0.5, 0.5, 0.5, 1.0];

/// The colours of the directions of the larger and the smaller curvature.
const DIRECTION_COLORS: [[f32; 4]; 2] = [[0.8, 0.15, 0.1, 1.0], [0.1, 0.25, 0.8, 1.0]];

/// A mesh of thin diamonds along the principal directions of every vertex, a third of a mean edge to
/// either side, just above the surface.
fn arrows(mesh: &TriMesh, values: &FrameValues) -> Result<Model, Failure> {
    let length = mesh.mean_edge_length().unwrap_or(0.0) / 3.0;
    let mut soup = PolygonSoup::default();
    let mut colors = Vec::new();
    for v in mesh.topology().vertices() {
        // Umbilics have no directions.
        let Some(FrameValue { frame, .. }) =
            values.of_vertex[v].as_ref().filter(|v| v.frame.direction_max.is_finite())
        else {
            continue;
        };
        let center = mesh.position(v) + 0.05 * length * frame.normal;
        let [max, min] = [frame.direction_max, frame.direction_min];
        for ([along, across], color) in [[max, min], [min, max]].into_iter().zip(DIRECTION_COLORS) {
            let first = u32::try_from(soup.vertex_count()).map_err(Failure::refused)?;
            // Turned so that the diamond has the normal of the surface.
            let side = if along.cross(across).dot(frame.normal) < 0.0 { -across } else { across };
            let corners: [DVec3; 4] = [along, 0.12 * side, -along, -0.12 * side];
            for corner in corners {
                soup.push_vertex(center + length * corner);
                colors.push(color);
            }
            for triangle in [[0, 1, 2], [0, 2, 3]] {
                soup.push_face(&triangle.map(|i| first + i)).map_err(Failure::refused)?;
            }
        }
    }
    Ok(Model { soup, vertex_colors: Some(colors), ..Model::default() })
}

fn summary(report: &Report<Results>) -> String {
    let found = &report.results;
    let reduced = if found.radius_reduced {
        " (less than 4 mean edge lengths, because such balls contain more than 1,000 faces)"
    } else {
        ""
    };
    let way = match (&found.settings, found.radius) {
        (Settings::Ball { .. }, radius) => {
            let normals = if found.estimator == "ball" { "" } else { " with interpolated normals" };
            let radius = Decimal(radius.unwrap_or(0.0));
            format!("averages over balls of radius {radius}{reduced}{normals}")
        }
        (Settings::Fit(JetFitOptions { scale: FitScale::Rings(rings), .. }), _) => {
            format!("quadratic surfaces fitted to {rings} rings")
        }
        (Settings::Fit(JetFitOptions { scale: FitScale::Radius(radius), .. }), _) => {
            format!("surfaces fitted within a radius of {}", Decimal(*radius))
        }
        _ => "surfaces fitted to the nearest points".to_owned(),
    };
    format!(
        "{}: {way}; integral of K {:.6}, of |H| {}\n  {}",
        report.subject(),
        found.integrals.integral_gaussian,
        Decimal(found.integrals.integral_abs_mean),
        found.found.line(report.vertices),
    )
}
