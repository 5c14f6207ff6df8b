//! `curvmesh.curvature`.

use curvpatch::DiscCurvature;
use dcurv::{Pointwise, PrincipalFrame, VertexCurvature, principal_frames};
use mesh_core::UnitScale;
use mesh_core::glam::DVec3;
use mesh_work::{
    FaceValues, FrameEstimator, FrameValue, FrameValues, Integrals, PointKind, Quantity,
    VertexValues, disc_quantity,
};
use numpy::{IntoPyArray, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::content::Whole;
use crate::failure::{Ended, Failure, choose};
use crate::host::{Call, run};
use crate::length::{Given, length, units};
use crate::mesh::MeshData;
use crate::options::{area, sections};
use crate::views::{frames, matrix, points};

/// Columns of a result.
#[derive(Default)]
struct Columns {
    numbers: Vec<(&'static str, Vec<f64>)>,
    flags: Vec<(&'static str, Vec<bool>)>,
    principal: Vec<[f64; 2]>,
    /// Directions of the larger and of the smaller curvature.
    directions: Option<Vec<[[f64; 3]; 2]>>,
    normals: Option<Vec<DVec3>>,
    /// What is at each vertex.
    kinds: Option<Vec<&'static str>>,
    /// The noise that scales follow.
    noise: Option<f64>,
    integrals: Integrals,
    /// Further results.
    totals: Vec<(&'static str, f64)>,
    radius: Option<f64>,
}

/// Curvature of vertices or faces.
#[pyfunction]
#[pyo3(signature = (call, mesh, *, estimator="auto", area="voronoi", radius=None, noise=None, relative=false, rings=None, preset="robust"))]
#[allow(clippy::too_many_arguments, reason = "one per option of Python")]
pub(crate) fn curvature<'py>(
    py: Python<'py>,
    call: &Call,
    mesh: &MeshData,
    estimator: &str,
    area: &str,
    radius: Option<Given>,
    noise: Option<Given>,
    relative: bool,
    rings: Option<usize>,
    preset: &str,
) -> PyResult<Bound<'py, PyDict>> {
    #[derive(Clone, Copy, PartialEq)]
    enum By {
        Auto,
        Vertex,
        Face,
        Fit,
        Ball,
        Corrected,
    }
    let settings = || -> Result<_, Failure> {
        let choices = [
            ("auto", By::Auto),
            ("vertex", By::Vertex),
            ("face", By::Face),
            ("fit", By::Fit),
            ("ball", By::Ball),
            ("corrected", By::Corrected),
        ];
        let by = choose("estimator", estimator, &choices)?;
        if let Some(rings) = rings.filter(|rings| !(1..=16).contains(rings)) {
            return Err(Failure::option(format!("rings is {rings}; it must be from 1 to 16")));
        }
        let refuse = |what: &str, cure: &str| {
            Err(Failure::option(format!(
                "{what} has no effect with estimator={estimator:?}; {cure}"
            )))
        };
        if rings.is_some() && by != By::Fit {
            return refuse("rings", "use estimator=\"fit\"");
        }
        if noise.is_some() && !matches!(by, By::Auto | By::Fit) {
            return refuse("noise", "use estimator=\"auto\" or \"fit\"");
        }
        if radius.is_some() && matches!(by, By::Auto | By::Vertex) {
            return refuse("radius", "use estimator=\"fit\", \"face\", \"ball\" or \"corrected\"");
        }
        if [rings.is_some(), radius.is_some(), noise.is_some()].iter().filter(|&&is| is).count() > 1
        {
            return refuse("more than one of radius, noise and rings", "leave all but one out");
        }
        let (radius, noise) = (length("radius", radius)?, length("noise", noise)?);
        Ok((by, self::area(area)?, radius, noise, sections(preset)?))
    };
    let (by, area, radius, noise, params) = settings().map_err(|failure| failure.raise(py))?;
    let content = mesh.content();
    let columns = run(py, call, move |watch| {
        let whole = content.whole()?;
        watch.check()?;
        let stops = || watch.is_cancelled();
        let mesh = &whole.mesh;
        UnitScale::with_areas(mesh).map_err(Failure::from)?;
        let (radius, noise) = (units(radius, mesh, relative)?, units(noise, mesh, relative)?);
        Ok(match by {
            By::Vertex => of_vertices(whole, &VertexValues::of(mesh, area)),
            By::Face => {
                let found = FaceValues::of_until(mesh, params, radius, &stops);
                of_faces(whole, &found.map_err(Failure::from)?.ok_or_else(Ended::interrupted)?)
            }
            By::Auto | By::Fit | By::Ball | By::Corrected => {
                let estimator = match by {
                    By::Fit => FrameEstimator::fit(rings, radius, noise),
                    By::Ball => FrameEstimator::Ball { radius },
                    By::Corrected => FrameEstimator::Corrected { radius },
                    _ => FrameEstimator::Auto { noise },
                };
                let found = FrameValues::of_until(mesh, estimator, &stops);
                let frames = of_frames(
                    whole,
                    &found.map_err(Failure::from)?.ok_or_else(Ended::interrupted)?,
                );
                if by == By::Auto {
                    of_vertices(whole, &VertexValues::of(mesh, area)).replaced_by(frames)
                } else {
                    frames
                }
            }
        })
    })?;
    columns.dictionary(py)
}

/// Both principal directions of every vertex, from quadratic surfaces fitted to its neighbours; NaN
/// where there are none.
#[pyfunction]
pub(crate) fn principal_directions<'py>(
    py: Python<'py>,
    call: &Call,
    mesh: &MeshData,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let content = mesh.content();
    let rows = run(py, call, move |_| {
        let whole = content.whole()?;
        let found = principal_frames(&whole.mesh);
        let axes = |frame: &Option<PrincipalFrame>| match frame {
            Some(frame) => [frame.direction_max, frame.direction_min].map(|d| d.to_array()),
            None => NO_AXES,
        };
        Ok(whole.of_surface(found.as_slice().iter().map(axes).collect(), NO_AXES))
    })?;
    frames(py, rows)
}

const NO_AXES: [[f64; 3]; 2] = [[f64::NAN; 3]; 2];

fn of_vertices(whole: &Whole, values: &VertexValues) -> Columns {
    let numbers = |of: &(dyn Fn(&VertexCurvature) -> f64 + Sync)| {
        whole.of_surface(values.curvatures.map(of).into_vec(), f64::NAN)
    };
    let pointwise = Quantity::ALL.iter().map(|&quantity| {
        (key(quantity), whole.of_surface(values.of_quantity(quantity).into_vec(), f64::NAN))
    });
    let mut columns = Columns { integrals: values.integrals(), ..Columns::default() };
    columns.numbers = pointwise.collect();
    columns.numbers.extend([
        ("area", numbers(&|c| c.integrals().area.value())),
        ("integral_gaussian", numbers(&|c| c.integrals().angle_defect.value())),
        ("integral_mean", numbers(&|c| c.integrals().mean.value())),
        ("integral_abs_mean", numbers(&|c| c.integrals().mean.abs().value())),
        ("integral_abs_dihedral", numbers(&|c| c.integrals().abs_dihedral.value())),
    ]);
    let all = values.curvatures.vertices().as_slice();
    let flags =
        |of: fn(&VertexCurvature) -> bool| whole.of_surface(all.iter().map(of).collect(), false);
    columns.flags = vec![
        ("boundary", flags(VertexCurvature::is_boundary)),
        ("clamped", flags(VertexCurvature::is_clamped)),
    ];
    let principal = all.iter().map(|c| c.principal().map(Pointwise::value)).collect();
    columns.principal = whole.of_surface(principal, [f64::NAN; 2]);
    let totals = values.curvatures.totals();
    columns.totals = vec![
        ("extrinsic", values.total_extrinsic()),
        ("norm_l1", totals.norm_l1),
        ("norm_l2_squared", totals.norm_l2_squared),
        ("area", totals.area.value()),
        ("clamped_vertices", totals.clamped as f64),
        ("boundary_vertices", totals.boundary as f64),
    ];
    columns
}

fn of_faces(whole: &Whole, values: &FaceValues) -> Columns {
    let discs = values.discs.as_slice();
    let number = |disc: &Option<DiscCurvature>, quantity| {
        disc.as_ref().map_or(f64::NAN, |disc| disc_quantity(disc, quantity))
    };
    let pointwise = pointwise()
        .map(|quantity| (key(quantity), discs.iter().map(|disc| number(disc, quantity)).collect()));
    let is =
        |of: fn(&DiscCurvature) -> bool| discs.iter().map(|d| d.as_ref().is_some_and(of)).collect();
    let axes = |disc: &Option<DiscCurvature>| match disc {
        None => NO_AXES,
        Some(disc) => {
            let [a, b, _] = disc.frame.map(|axis| axis.to_array());
            [a, b]
        }
    };
    let principal =
        |disc: &Option<DiscCurvature>| [number(disc, Quantity::K1), number(disc, Quantity::K2)];
    let normal =
        |disc: &Option<DiscCurvature>| disc.as_ref().map_or(DVec3::NAN, DiscCurvature::normal);
    let mesh = &whole.mesh;
    let mut numbers: Vec<(&'static str, Vec<f64>)> = pointwise.collect();
    numbers.push(("area", mesh.topology().faces().map(|f| mesh.face_area(f)).collect()));
    Columns {
        numbers,
        flags: vec![
            ("known", is(|_| true)),
            ("truncated", is(|d| d.truncated)),
            ("wrapped", values.closed.as_slice().to_vec()),
        ],
        principal: discs.iter().map(principal).collect(),
        directions: Some(discs.iter().map(axes).collect()),
        normals: Some(discs.iter().map(normal).collect()),
        integrals: values.integrals(mesh),
        radius: Some(values.radius),
        ..Columns::default()
    }
}

fn of_frames(whole: &Whole, values: &FrameValues) -> Columns {
    let all = values.of_vertex.as_slice();
    let pointwise = pointwise().map(|quantity| {
        (key(quantity), whole.of_surface(values.of_quantity(quantity).into_vec(), f64::NAN))
    });
    let axes = |value: &Option<FrameValue>| {
        value.as_ref().map_or(NO_AXES, |FrameValue { frame, .. }| {
            [frame.direction_max, frame.direction_min].map(|d| d.to_array())
        })
    };
    let principal =
        |value: &Option<FrameValue>| value.as_ref().map_or([f64::NAN; 2], FrameValue::principal);
    let normal = |value: &Option<FrameValue>| value.map_or(DVec3::NAN, |v| v.frame.normal);
    let mut numbers: Vec<(&'static str, Vec<f64>)> = pointwise.collect();
    if values.fit.is_some() {
        let errors = all.iter().map(|value| value.map_or(f64::NAN, |value| value.error)).collect();
        numbers.push(("error", whole.of_surface(errors, f64::NAN)));
    }
    let kinds = values.kinds.as_slice().iter().map(|kind| kind.name()).collect();
    Columns {
        numbers,
        kinds: Some(whole.of_surface(kinds, PointKind::Unknown.name())),
        noise: values.noise(),
        flags: vec![("known", whole.of_surface(all.iter().map(Option::is_some).collect(), false))],
        principal: whole.of_surface(all.iter().map(principal).collect(), [f64::NAN; 2]),
        directions: Some(whole.of_surface(all.iter().map(axes).collect(), NO_AXES)),
        normals: Some(whole.of_surface(all.iter().map(normal).collect(), DVec3::NAN)),
        integrals: values.integrals(&whole.mesh),
        radius: values.radius,
        ..Columns::default()
    }
}

/// Quantities that a surface has at a point.
fn pointwise() -> impl Iterator<Item = Quantity> {
    Quantity::ALL.iter().copied().filter(|&q| !q.is_of_star())
}

fn key(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::AbsMean => "abs_mean",
        Quantity::AbsDihedral => "abs_dihedral",
        Quantity::KPlus => "k_plus",
        Quantity::KMinus => "k_minus",
        Quantity::AbsSum => "abs_sum",
        Quantity::ShapeIndex => "shape_index",
        other => other.name(),
    }
}

impl Columns {
    /// These columns, with those of the same name and the directions of another estimator.
    fn replaced_by(mut self, other: Self) -> Self {
        self.numbers.retain(|(name, _)| other.numbers.iter().all(|(newer, _)| newer != name));
        self.numbers.extend(other.numbers);
        self.flags.extend(other.flags);
        let Self { integrals, totals, .. } = self;
        Self { integrals, totals, numbers: self.numbers, flags: self.flags, ..other }
    }

    fn dictionary(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let found = PyDict::new(py);
        for (name, values) in self.numbers {
            found.set_item(name, values.into_pyarray(py))?;
        }
        for (name, values) in self.flags {
            found.set_item(name, values.into_pyarray(py))?;
        }
        found.set_item("principal", matrix(py, self.principal)?)?;
        found.set_item("directions", self.directions.map(|d| frames(py, d)).transpose()?)?;
        found.set_item("normals", self.normals.map(|n| points(py, n)).transpose()?)?;
        found.set_item("kinds", self.kinds)?;
        found.set_item("noise", self.noise)?;
        found.set_item("radius", self.radius)?;
        let totals = PyDict::new(py);
        let Integrals {
            integral_gaussian,
            integral_abs_gaussian,
            integral_mean,
            integral_abs_mean,
            f1,
            f2,
            f3,
            willmore,
        } = self.integrals;
        let sums = [
            ("gaussian", integral_gaussian),
            ("abs_gaussian", integral_abs_gaussian),
            ("mean", integral_mean),
            ("abs_mean", integral_abs_mean),
            ("f1", f1),
            ("f2", f2),
            ("f3", f3),
            ("willmore", willmore),
        ];
        for (name, value) in sums.into_iter().chain(self.totals) {
            totals.set_item(name, value)?;
        }
        found.set_item("totals", totals)?;
        Ok(found)
    }
}
