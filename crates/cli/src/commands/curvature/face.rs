//! `curvmesh curvature --estimator face`: the curvature of every face from normal sections.

use curvpatch::{DiscCurvature, DiscSize, Params};
use mesh_core::{TriMesh, VertexMap};
use mesh_io::{Format, Model};
use mesh_render::Scale;
use mesh_view::Lines;
use mesh_work::{FaceValues, Integrals, Loaded, Quantity, disc_quantity};
use serde::Serialize;

use crate::colormap::opaque;
use crate::commands::curvature::options::Curvature;
use crate::commands::curvature::orientation::load;
use crate::console::Console;
use crate::decimal::Decimal;
use crate::failure::Failure;
use crate::load::Seconds;
use crate::replaced::Replaced;
use crate::task::{Done, Report, Task};
use crate::view::{self, name_of};

/// Properties of faces that are 0 or 1. A face with [`KNOWN`] = 0 has NaN as curvature.
const KNOWN: &str = "curvature_known";
const TRUNCATED: &str = "sections_truncated";
const CLOSED: &str = "sections_closed";

/// All settings, with the preset expanded.
#[derive(Serialize)]
struct Settings {
    params: Params,
    size: DiscSize,
}

/// The results in `--json`: integrals with the names of the vertex estimator, and face counts.
#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    integrals: Integrals,
    estimator: &'static str,
    settings: Settings,
    /// The radius of the discs; the median radius if `local_radius`.
    radius: f64,
    /// Whether the length of sections follows the edges around each face.
    local_radius: bool,
    /// Number of faces with sections that end at the boundary of the mesh.
    truncated_faces: usize,
    /// Number of faces with sections that close on themselves. Their curvature is unknown.
    wrapped_faces: usize,
    /// Number of faces with unknown curvature: no area, no section that leaves the face, or closed
    /// sections.
    faces_without_curvature: usize,
    /// Components that are inside out; unknown for a mesh that does not fit into memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    inside_out: Option<usize>,
    quantity: String,
    range: [f64; 2],
}

pub(crate) fn run(options: &Curvature, task: &Task, console: &Console) -> Result<Done, Failure> {
    let quantity = options.quantity;
    let mut seconds = Seconds::default();
    let (loaded, inside_out) = load(options, task, &mut seconds, console)?;
    let radius = options.estimate.radius;
    let radius = radius
        .map(|r| r.on(&loaded.mesh, options.job.loading.relative))
        .transpose()
        .map_err(Failure::refused)?;
    let bar = console.progress(loaded.mesh.topology().face_count() as u64, "estimating");
    let values = Seconds::time(&mut seconds.compute, || {
        let params = options.estimate.preset.params();
        FaceValues::of_observed(&loaded.mesh, params, radius, &|| bar.inc(1))
    });
    bar.finish_and_clear();
    let values = values.map_err(Failure::refused)?;
    let known = values.discs.as_slice().iter().flatten();
    let scale = options
        .colors
        .scale(quantity.is_signed(), known.map(|d| disc_quantity(d, quantity)).collect());
    if let Some(output) = &task.output {
        let in_faces =
            matches!(options.job.save.format_of(output), Some(Format::Ply | Format::Off));
        let mut replaced = Replaced::default();
        let model = colored(in_faces, &loaded, &values, (quantity, &scale), &mut replaced)?;
        replaced.tell(&task.input, console);
        task.save(&model, &options.job.save, &mut seconds, console)?;
        console.message(options.colors.explain(&scale));
    }
    let results =
        Results { inside_out: Some(inside_out), ..results(options, &loaded, &values, &scale) };
    let report = task.report(console, loaded.counts(), results, seconds);
    if options.look.is_wanted() {
        let shown = (quantity, &scale);
        let model = colored(true, &loaded, &values, shown, &mut Replaced::default())?;
        let mut exhibit =
            view::content(&name_of(&task.input), &task.input, &model, &options.job.loading)?;
        exhibit.face_colors = None;
        exhibit.lines = directions(&values);
        let page = options.page("curvature of faces", "face", exhibit, &scale);
        options.look.write(page, &report, console)?;
    }
    let Integrals { integral_gaussian, integral_abs_mean, .. } = report.results.integrals;
    let brief =
        format!("integral of K {integral_gaussian:.6}, of |H| {}", Decimal(integral_abs_mean));
    report.done(console, summary(&report), brief)
}

/// Both principal directions at the faces. The lines are a tenth of the disc radius long.
fn directions(values: &FaceValues) -> Vec<Lines> {
    let line = |axis: usize| {
        let discs = values.discs.as_slice().iter().flatten();
        let line = |d: &DiscCurvature| {
            let half = 0.05 * d.radius * d.frame[axis];
            [d.center - half, d.center + half]
        };
        discs.map(line).collect()
    };
    let lines = |name: &str, color, segments| Lines {
        name: name.into(),
        color,
        width: 1.4,
        segments,
        shown: false,
    };
    vec![
        lines("Direction of the larger curvature", [200, 30, 40], line(0)),
        lines("Direction of the smaller curvature", [25, 80, 190], line(1)),
    ]
}

/// The mesh with every quantity as a property of the faces, NaN where it is unknown.
///
/// Colours are stored in the faces if the format supports it (PLY, OFF). Otherwise each vertex gets the
/// colour of the area-weighted mean of its faces, so that the mesh stays connected.
fn colored(
    in_faces: bool,
    loaded: &Loaded,
    values: &FaceValues,
    (quantity, scale): (Quantity, &Scale),
    replaced: &mut Replaced,
) -> Result<Model, Failure> {
    let mut model = loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
    let discs = values.discs.as_slice();
    let of_faces = Quantity::ALL.iter().filter(|q| !q.is_of_star());
    for &quantity in of_faces {
        let name = quantity.property();
        let of_face = |disc: &Option<DiscCurvature>| {
            disc.map_or(f64::NAN, |disc| disc_quantity(&disc, quantity))
        };
        let values: Vec<f64> = discs.iter().map(of_face).collect();
        replaced.set(&mut model.face_scalars, name, values);
    }
    let flags: [(&str, Vec<bool>); 3] = [
        (KNOWN, discs.iter().map(Option::is_some).collect()),
        (TRUNCATED, discs.iter().map(|disc| disc.is_some_and(|disc| disc.truncated)).collect()),
        (CLOSED, values.closed.as_slice().to_vec()),
    ];
    for (name, flags) in flags {
        let values: Vec<u8> = flags.into_iter().map(u8::from).collect();
        replaced.set(&mut model.face_scalars, name, values);
    }
    replaced.take(&mut model.vertex_colors);
    replaced.take(&mut model.face_colors);
    if in_faces {
        let color = |disc: &Option<DiscCurvature>| {
            disc.map_or(UNKNOWN, |d| opaque(scale.color(disc_quantity(&d, quantity))))
        };
        model.face_colors = Some(discs.iter().map(color).collect());
    } else {
        let means = vertex_means(&loaded.mesh, values, quantity);
        let color = |mean: &Option<f64>| mean.map_or(UNKNOWN, |mean| opaque(scale.color(mean)));
        model.vertex_colors = Some(means.as_slice().iter().map(color).collect());
    }
    Ok(model)
}

/// The colour of unknown curvature.
const UNKNOWN: [f32; 4] = [0.5, 0.5, 0.5, 1.0];

/// The area-weighted mean over the faces of each vertex; `None` if all are unknown.
fn vertex_means(mesh: &TriMesh, values: &FaceValues, quantity: Quantity) -> VertexMap<Option<f64>> {
    let topology = mesh.topology();
    let mut sums = topology.vertex_map(0.0);
    let mut areas = topology.vertex_map(0.0);
    for face in topology.faces() {
        let Some(disc) = &values.discs[face] else { continue };
        let area = mesh.face_area(face);
        for vertex in topology.face_vertices(face) {
            sums[vertex] += area * disc_quantity(disc, quantity);
            areas[vertex] += area;
        }
    }
    let pairs = sums.as_slice().iter().zip(areas.as_slice());
    let means = pairs.map(|(sum, &area)| (area > 0.0).then(|| sum / area));
    VertexMap::from_vec(means.collect())
}

fn results(options: &Curvature, loaded: &Loaded, values: &FaceValues, scale: &Scale) -> Results {
    let topology = loaded.mesh.topology();
    Results {
        integrals: values.integrals(&loaded.mesh),
        estimator: "face",
        settings: Settings { params: options.estimate.preset.params(), size: values.size },
        radius: values.radius,
        local_radius: values.size == DiscSize::Local,
        truncated_faces: values.count(|disc| disc.truncated),
        wrapped_faces: values.closed_count(),
        faces_without_curvature: topology.face_count() - values.count(|_| true),
        inside_out: None,
        quantity: options.quantity.to_string(),
        range: [scale.low, scale.high],
    }
}

fn summary(report: &Report<Results>) -> String {
    let found = &report.results;
    format!(
        "{}: sections of {} to either side{}; integral of K {:.6}, of |H| {}\n  faces with sections that end at the boundary: {} of {}; faces of unknown curvature (NaN): {}, of these with sections that close on themselves: {}",
        report.subject(),
        Decimal(found.radius),
        if found.local_radius {
            " (median; at least four local edge lengths in each direction)"
        } else {
            ""
        },
        found.integrals.integral_gaussian,
        Decimal(found.integrals.integral_abs_mean),
        found.truncated_faces,
        report.faces,
        found.faces_without_curvature,
        found.wrapped_faces
    )
}
