//! `curvmesh curvature --estimator fit` and `ball`: principal curvatures and directions of every
//! vertex, from fitted quadratic surfaces or averaged over balls.

use clap::ValueEnum;
use dcurv::{BallCurvature, FitOptions, PrincipalFrame, ball_curvatures, fitted_frames};
use mesh_core::glam::DVec3;
use mesh_core::{PolygonSoup, TriMesh, VertexMap};
use mesh_io::{Format, Model, Scalars};
use mesh_render::Scale;
use serde::Serialize;

use crate::colormap::opaque;
use crate::commands::curvature::options::{Curvature, EstimatorName, Integrals, Quantity, Shown};
use crate::console::Console;
use crate::failure::Failure;
use crate::load::Seconds;
use crate::task::{Done, Report, Task};
use crate::view::{self, name_of};

/// The property that is 1 for vertices with curvature, and 0 for those without, whose other numbers
/// are 0.
const KNOWN: &str = "curvature_known";

#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    integrals: Integrals,
    estimator: &'static str,
    /// With `ball`.
    #[serde(skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
    /// With `fit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    rings: Option<usize>,
    vertices_without_curvature: usize,
    quantity: String,
    range: [f64; 2],
}

/// What is known of a vertex.
#[derive(Clone, Copy)]
struct Value {
    frame: PrincipalFrame,
    gaussian: f64,
    mean: f64,
    abs_mean: f64,
}

struct Values {
    of_vertex: VertexMap<Option<Value>>,
    radius: Option<f64>,
    rings: Option<usize>,
}

pub(crate) fn run(options: &Curvature, task: &Task, console: &Console) -> Result<Done, Failure> {
    let quantity = options.quantity;
    let mut seconds = Seconds::default();
    let loaded = task.load(&options.job.loading, &mut seconds, console)?;
    let radius = options.estimate.radius;
    let radius = radius.map(|r| r.on(&loaded.mesh, options.job.loading.relative)).transpose()?;
    let values = Seconds::time(&mut seconds.compute, || Values::of(&loaded.mesh, options, radius))?;
    let known = values.of_vertex.as_slice().iter().flatten();
    let scale =
        options.colors.scale(quantity.is_signed(), known.map(|v| v.quantity(quantity)).collect());
    if let Some(output) = &task.output {
        let model = match options.estimate.shown {
            Shown::Mesh => {
                let format = options.job.save.format_of(output);
                let model = loaded.to_model(&loaded.provenance.corner_source)?;
                colored(model, format, &values, quantity, &scale)
            }
            Shown::Arrows => arrows(&loaded.mesh, &values)?,
        };
        task.save(&model, &options.job.save, &mut seconds, console)?;
        if options.estimate.shown == Shown::Mesh {
            console.message(options.colors.explain(&scale));
        }
    }
    let name = quantity.to_possible_value();
    let results = Results {
        integrals: values.integrals(&loaded.mesh),
        estimator: if values.radius.is_some() { "ball" } else { "fit" },
        radius: values.radius,
        rings: values.rings,
        vertices_without_curvature: loaded
            .mesh
            .topology()
            .vertices()
            .filter(|&v| values.of_vertex[v].is_none())
            .count(),
        quantity: name.map(|value| value.get_name().to_owned()).unwrap_or_default(),
        range: [scale.low, scale.high],
    };
    let report = task.report(console, loaded.counts(), results, seconds);
    if options.look.is_wanted() {
        let model = loaded.to_model(&loaded.provenance.corner_source)?;
        let model = colored(model, Some(Format::Ply), &values, quantity, &scale);
        let mut exhibit = view::content(&name_of(&task.input), &task.input, &model)?;
        exhibit.vertex_colors = None;
        exhibit.directions =
            view::directions(&values.of_vertex.map(|v| v.as_ref().map(|v| v.frame)));
        let page = options.page("curvature", "vertex", exhibit, &scale);
        options.look.write(page, &report, console)?;
    }
    let Integrals { integral_gaussian, integral_abs_mean, .. } = report.results.integrals;
    let brief = format!("integral of K {integral_gaussian:.6}, of |H| {integral_abs_mean:.6}");
    report.done(console, summary(&report), brief)
}

impl Values {
    fn of(mesh: &TriMesh, options: &Curvature, radius: Option<f64>) -> Result<Self, Failure> {
        if options.estimate.estimator == EstimatorName::Fit {
            let rings = options.estimate.rings;
            let frames = fitted_frames(mesh, &FitOptions { rings, ..FitOptions::default() });
            let of_vertex = frames.map(|frame| frame.map(Value::of_fit));
            return Ok(Self { of_vertex, radius: None, rings: Some(rings) });
        }
        let mean_edge = mesh.mean_edge_length().filter(|&length| length > 0.0);
        let radius = radius.or_else(|| Some(SPAN * mean_edge?)).unwrap_or(1.0);
        let balls = ball_curvatures(mesh, radius).map_err(Failure::refused)?;
        let of_vertex = balls.map(|ball| Some(Value::of_ball(ball, ball.principal()?)));
        Ok(Self { of_vertex, radius: Some(radius), rings: None })
    }

    /// Curvatures of vertices times a third of the areas of their faces.
    fn integrals(&self, mesh: &TriMesh) -> Integrals {
        let mut sums = Integrals::default();
        for face in mesh.topology().faces() {
            let third = mesh.face_area(face) / 3.0;
            for vertex in mesh.topology().face_vertices(face) {
                let Some(value) = &self.of_vertex[vertex] else { continue };
                let [k1, k2] = value.principal();
                sums.integral_gaussian += third * value.gaussian;
                sums.integral_abs_gaussian += third * value.gaussian.abs();
                sums.integral_mean += third * value.mean;
                sums.integral_abs_mean += third * value.abs_mean;
                sums.f1 += third * value.mean * value.mean;
                sums.f3 += third * (k1.abs() + k2.abs());
            }
        }
        Integrals { f2: sums.integral_abs_mean, willmore: sums.f1 - sums.integral_gaussian, ..sums }
    }
}

/// The radius of balls, unless it is given: in mean edges.
const SPAN: f64 = 4.0;

impl Value {
    fn of_fit(frame: PrincipalFrame) -> Self {
        let (gaussian, mean) = (frame.gaussian().value(), frame.mean().value());
        Self { frame, gaussian, mean, abs_mean: mean.abs() }
    }

    fn of_ball(ball: &BallCurvature, frame: PrincipalFrame) -> Self {
        let (gaussian, mean) = (ball.gaussian().value(), ball.mean().value());
        Self { frame, gaussian, mean, abs_mean: ball.abs_mean().value() }
    }

    fn principal(&self) -> [f64; 2] {
        [self.frame.k_max.value(), self.frame.k_min.value()]
    }

    fn quantity(&self, quantity: Quantity) -> f64 {
        let [k1, k2] = self.principal();
        match quantity {
            Quantity::Gaussian => self.gaussian,
            Quantity::Mean => self.mean,
            Quantity::AbsMean => self.abs_mean,
            Quantity::K1 => k1,
            Quantity::K2 => k2,
            Quantity::AbsSum => k1.abs() + k2.abs(),
            Quantity::ShapeIndex => (k1 + k2).atan2(k1 - k2) * core::f64::consts::FRAC_2_PI,
            Quantity::Curvedness => (0.5 * (k1 * k1 + k2 * k2)).sqrt(),
            // Refused before anything is computed.
            Quantity::Willmore => 0.0,
        }
    }
}

/// The mesh with its colours, and every quantity and the directions as named numbers where the format
/// has a place for them.
fn colored(
    mut model: Model,
    format: Option<Format>,
    values: &Values,
    quantity: Quantity,
    scale: &Scale,
) -> Model {
    let known = values.of_vertex.as_slice();
    let color =
        |v: &Option<Value>| v.map_or(UNKNOWN, |v| opaque(scale.color(v.quantity(quantity))));
    model.vertex_colors = Some(known.iter().map(color).collect());
    if !matches!(format, Some(Format::Ply | Format::Gltf | Format::Glb)) {
        return model;
    }
    let mut add = |name: &str, of: &dyn Fn(&Value) -> f64| {
        model.vertex_scalars.retain(|scalars| scalars.name != name);
        let values = known.iter().map(|v| v.as_ref().map_or(0.0, of)).collect();
        model.vertex_scalars.push(Scalars { name: name.to_owned(), values });
    };
    let pointwise = Quantity::value_variants().iter().filter(|&&q| q != Quantity::Willmore);
    for &quantity in pointwise {
        add(quantity.property(), &|v| v.quantity(quantity));
    }
    for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
        add(&format!("k1_{letter}"), &|v| v.frame.direction_max[axis]);
        add(&format!("k2_{letter}"), &|v| v.frame.direction_min[axis]);
    }
    add(KNOWN, &|_| 1.0);
    model
}

/// The colour of what has no curvature.
const UNKNOWN: [f32; 4] = [0.5, 0.5, 0.5, 1.0];

/// The colours of the directions of the larger and the smaller curvature.
const DIRECTION_COLORS: [[f32; 4]; 2] = [[0.8, 0.15, 0.1, 1.0], [0.1, 0.25, 0.8, 1.0]];

/// A mesh of thin diamonds along the principal directions of every vertex, a third of a mean edge to
/// either side, just above the surface.
fn arrows(mesh: &TriMesh, values: &Values) -> Result<Model, Failure> {
    let length = mesh.mean_edge_length().unwrap_or(0.0) / 3.0;
    let mut soup = PolygonSoup::default();
    let mut colors = Vec::new();
    for v in mesh.topology().vertices() {
        let Some(Value { frame, .. }) = &values.of_vertex[v] else { continue };
        let center = mesh.position(v) + 0.05 * length * frame.normal;
        let [max, min] = [frame.direction_max, frame.direction_min];
        for ([along, across], color) in [[max, min], [min, max]].into_iter().zip(DIRECTION_COLORS) {
            let first = u32::try_from(soup.vertex_count()).map_err(Failure::refused)?;
            // Turned so that the normal is that of the surface.
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
    let way = match (found.radius, found.rings) {
        (Some(radius), _) => format!("averages over balls of radius {radius:.6}"),
        (None, rings) => format!("quadratic surfaces fitted to {} rings", rings.unwrap_or(0)),
    };
    format!(
        "{}: {way}; integral of K {:.6}, of |H| {:.6}\n  {} of {} vertices have no curvature",
        report.subject(),
        found.integrals.integral_gaussian,
        found.integrals.integral_abs_mean,
        found.vertices_without_curvature,
        report.vertices,
    )
}
