//! `curvmesh curvature`: discrete curvature of every vertex, as numbers and as colours.

use std::path::PathBuf;

use clap::ValueEnum;
use dcurv::{CurvatureOptions, Curvatures, Totals, VertexArea, VertexCurvature};
use mesh_core::{Topology, VertexMap};
use mesh_io::{Model, Scalars};
use serde::Serialize;

use crate::args::{AreaName, RepairOptions};
use crate::colormap::{ColorMap, Range, Scale};
use crate::console::Console;
use crate::face_curvature::{self, Estimate};
use crate::failure::Failure;
use crate::load::{Loaded, Seconds, load};
use crate::save::{SaveOptions, check_target, save};

/// Compute the curvature of every vertex or face, and colour the mesh by it
///
/// PLY output carries every quantity as a named property; PLY, GLB, OBJ and OFF carry the colours.
/// Signed quantities are positive where the surface is convex seen from outside. Curvature of
/// faces is a property of faces; GLB and OBJ get the colours of vertices, which are the mean of the
/// faces around.
///
///     curvmesh curvature scan.ply -o mean.ply --quantity mean
///     curvmesh curvature part.obj -o folds.glb --quantity abs-mean --colormap magma --range 0,2
///     curvmesh curvature scan.ply -o k1.ply --quantity k1 --estimator face --radius 0.3
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Curvature {
    /// The file to read
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// What the colours show
    #[arg(long, value_enum, default_value_t)]
    pub(crate) quantity: Quantity,
    /// The area that belongs to a vertex, by which integrals are divided
    #[arg(long, value_enum, default_value_t)]
    area: AreaName,
    /// The colours [default: viridis for quantities of one sign, red-blue for signed ones]
    #[arg(long, value_enum)]
    pub(crate) colormap: Option<ColorMap>,
    /// The values at the ends of the colours; `auto` leaves out the outer 2 % of the vertices
    #[arg(long, value_name = "LO,HI|auto", default_value = "auto", allow_hyphen_values = true)]
    pub(crate) range: Range,
    #[command(flatten)]
    pub(crate) estimate: Estimate,
    #[command(flatten)]
    pub(crate) save: SaveOptions,
    #[command(flatten)]
    pub(crate) repair: RepairOptions,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Quantity {
    /// K, per area
    Gaussian,
    /// H, per length, signed
    #[default]
    Mean,
    /// |H|, per length
    AbsMean,
    /// The larger principal curvature, per length
    K1,
    /// The smaller principal curvature, per length
    K2,
    /// |k1| + |k2|, per length
    AbsSum,
    /// Bobenko's Willmore energy of the vertex, without unit
    Willmore,
    /// Koenderink's shape index, from -1 (cup) to 1 (cap)
    ShapeIndex,
    /// sqrt((k1² + k2²) / 2), per length
    Curvedness,
}

/// Every quantity with the name of its property in a PLY file.
const PROPERTIES: [(Quantity, &str); 9] = [
    (Quantity::Gaussian, "gaussian_curvature"),
    (Quantity::Mean, "mean_curvature"),
    (Quantity::AbsMean, "abs_mean_curvature"),
    (Quantity::K1, "k1"),
    (Quantity::K2, "k2"),
    (Quantity::AbsSum, "abs_principal_sum"),
    (Quantity::Willmore, "willmore_energy"),
    (Quantity::ShapeIndex, "shape_index"),
    (Quantity::Curvedness, "curvedness"),
];

#[derive(Serialize)]
struct Report {
    command: &'static str,
    input: String,
    output: String,
    vertices: usize,
    faces: usize,
    integral_gaussian: f64,
    integral_abs_gaussian: f64,
    integral_mean: f64,
    integral_abs_mean: f64,
    f1: f64,
    f2: f64,
    f3: f64,
    willmore: f64,
    norm_l1: f64,
    norm_l2_squared: f64,
    clamped_vertices: usize,
    boundary_vertices: usize,
    quantity: String,
    range: [f64; 2],
    seconds: Seconds,
}

/// What is computed of a mesh.
struct Values {
    curvatures: Curvatures,
    willmore: VertexMap<f64>,
}

pub(crate) fn run(options: &Curvature, console: &Console) -> Result<(), Failure> {
    check_target(&options.output, &options.save)?;
    if options.estimate.is_by_face() {
        return face_curvature::run(options, console);
    }
    let mut seconds = Seconds::default();
    let loaded =
        Seconds::time(&mut seconds.load, || load(&options.input, &options.repair, console))?;
    let values = Seconds::time(&mut seconds.compute, || Values::of(&loaded, options.area.into()));
    let shown = values.of_quantity(options.quantity);
    let scale = scale(options, loaded.mesh.topology(), &shown);
    let model = colored(&loaded, &values, &shown, &scale)?;
    Seconds::time(&mut seconds.save, || save(&options.output, &model, &options.save, console))?;
    console.message(format_args!(
        "colours run from {:.4e} to {:.4e} ({})",
        scale.low,
        scale.high,
        options.range.origin()
    ));
    let report = report(options, &loaded, &values, &scale, seconds.summed());
    console.result(&report, summary(&report))
}

impl Values {
    fn of(loaded: &Loaded, area: VertexArea) -> Self {
        Self {
            curvatures: Curvatures::of(&loaded.mesh, &CurvatureOptions { area }),
            willmore: dcurv::willmore_energies(&loaded.mesh),
        }
    }

    fn of_quantity(&self, quantity: Quantity) -> VertexMap<f64> {
        let map = |value: fn(&VertexCurvature) -> f64| self.curvatures.map(value);
        match quantity {
            Quantity::Gaussian => map(|c| c.gaussian().value()),
            Quantity::Mean => map(|c| c.mean().value()),
            Quantity::AbsMean => map(|c| c.abs_mean().value()),
            Quantity::K1 => map(|c| c.principal()[0].value()),
            Quantity::K2 => map(|c| c.principal()[1].value()),
            Quantity::AbsSum => map(|c| c.abs_principal_sum().value()),
            Quantity::Willmore => self.willmore.clone(),
            Quantity::ShapeIndex => map(VertexCurvature::shape_index),
            Quantity::Curvedness => map(|c| c.curvedness().value()),
        }
    }
}

impl Quantity {
    pub(crate) fn is_signed(self) -> bool {
        matches!(self, Self::Gaussian | Self::Mean | Self::K1 | Self::K2 | Self::ShapeIndex)
    }
}

/// The colours and their range; vertices without faces have no say in it.
fn scale(options: &Curvature, topology: &Topology, shown: &VertexMap<f64>) -> Scale {
    let signed = options.quantity.is_signed();
    let colors = options.colormap.unwrap_or(ColorMap::usual(signed));
    let used = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v));
    Scale::new(colors, options.range, signed, used.map(|v| shown[v]).collect())
}

/// The content of the output: the mesh, its colours, and every quantity as a named number.
fn colored(
    loaded: &Loaded,
    values: &Values,
    shown: &VertexMap<f64>,
    scale: &Scale,
) -> Result<Model, Failure> {
    let mut model = loaded.to_model(&loaded.provenance.corner_source)?;
    model.vertex_colors = Some(shown.as_slice().iter().map(|&value| scale.color(value)).collect());
    for (quantity, name) in PROPERTIES {
        model.vertex_scalars.retain(|scalars| scalars.name != name);
        model.vertex_scalars.push(Scalars {
            name: name.to_owned(),
            values: values.of_quantity(quantity).into_vec(),
        });
    }
    Ok(model)
}

fn report(
    options: &Curvature,
    loaded: &Loaded,
    values: &Values,
    scale: &Scale,
    seconds: Seconds,
) -> Report {
    let totals: Totals = values.curvatures.totals();
    let quantity = options.quantity.to_possible_value();
    Report {
        command: "curvature",
        input: loaded.input(),
        output: options.output.display().to_string(),
        vertices: loaded.mesh.topology().vertex_count(),
        faces: loaded.mesh.topology().face_count(),
        integral_gaussian: totals.gaussian.value(),
        integral_abs_gaussian: totals.abs_gaussian.value(),
        integral_mean: totals.mean.value(),
        integral_abs_mean: totals.abs_mean.value(),
        f1: totals.f1,
        f2: totals.f2(),
        f3: totals.f3,
        willmore: values.willmore.as_slice().iter().sum(),
        norm_l1: totals.norm_l1,
        norm_l2_squared: totals.norm_l2_squared,
        clamped_vertices: totals.clamped,
        boundary_vertices: totals.boundary,
        quantity: quantity.map(|value| value.get_name().to_owned()).unwrap_or_default(),
        range: [scale.low, scale.high],
        seconds,
    }
}

fn summary(report: &Report) -> String {
    format!(
        "{}: integral of K {:.6}, integral of |H| {:.6}\n  F1 {:.6}, F2 {:.6}, F3 {:.6}, Willmore {:.6}\n  {} of {} vertices have H² < K",
        report.output,
        report.integral_gaussian,
        report.integral_abs_mean,
        report.f1,
        report.f2,
        report.f3,
        report.willmore,
        report.clamped_vertices,
        report.vertices
    )
}
