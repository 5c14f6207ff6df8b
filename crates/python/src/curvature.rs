//! `curvmesh.curvature`.

use curvpatch::DiscCurvature;
use dcurv::{Pointwise, PrincipalFrame, VertexCurvature, principal_frames};
use mesh_core::glam::DVec3;
use mesh_work::{
    FaceValues, FrameValue, FrameValues, Integrals, Quantity, VertexValues, disc_quantity,
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
    integrals: Integrals,
    /// Further results.
    totals: Vec<(&'static str, f64)>,
    radius: Option<f64>,
}

/// Curvature of vertices or faces.
#[pyfunction]
#[pyo3(signature = (call, mesh, *, estimator="vertex", area="voronoi", radius=None, relative=false, rings=2, preset="robust"))]
#[allow(clippy::too_many_arguments, reason = "one per option of Python")]
pub(crate) fn curvature<'py>(
    py: Python<'py>,
    call: &Call,
    mesh: &MeshData,
    estimator: &str,
    area: &str,
    radius: Option<Given>,
    relative: bool,
    rings: usize,
    preset: &str,
) -> PyResult<Bound<'py, PyDict>> {
    #[derive(Clone, Copy)]
    enum By {
        Vertex,
        Face,
        Fit,
        Ball,
    }
    let settings = || -> Result<_, Failure> {
        let choices =
            [("vertex", By::Vertex), ("face", By::Face), ("fit", By::Fit), ("ball", By::Ball)];
        if !(1..=16).contains(&rings) {
            return Err(Failure::option(format!("rings is {rings}; it must be from 1 to 16")));
        }
        let by = choose("estimator", estimator, &choices)?;
        Ok((by, self::area(area)?, length("radius", radius)?, sections(preset)?))
    };
    let (by, area, radius, params) = settings().map_err(|failure| failure.raise(py))?;
    let content = mesh.content();
    let columns = run(py, call, move |watch| {
        let whole = content.whole()?;
        watch.check()?;
        let stops = || watch.is_cancelled();
        let mesh = &whole.mesh;
        let radius = units(radius, mesh, relative)?;
        Ok(match by {
            By::Vertex => of_vertices(whole, &VertexValues::of(mesh, area)),
            By::Face => {
                let found = FaceValues::of_until(mesh, params, radius, &stops);
                of_faces(whole, &found.map_err(Failure::from)?.ok_or_else(Ended::interrupted)?)
            }
            By::Fit => {
                let found = FrameValues::fitted_until(mesh, rings, &stops);
                of_frames(whole, &found.ok_or_else(Ended::interrupted)?)
            }
            By::Ball => {
                let found = FrameValues::averaged_until(mesh, radius, &stops);
                of_frames(whole, &found.map_err(Failure::from)?.ok_or_else(Ended::interrupted)?)
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
        totals: Vec::new(),
        radius: Some(values.radius),
    }
}

fn of_frames(whole: &Whole, values: &FrameValues) -> Columns {
    let all = values.of_vertex.as_slice();
    let number = |value: &Option<FrameValue>, quantity| {
        value.as_ref().map_or(f64::NAN, |value| value.quantity(quantity))
    };
    let pointwise = pointwise().map(|quantity| {
        let values = all.iter().map(|value| number(value, quantity)).collect();
        (key(quantity), whole.of_surface(values, f64::NAN))
    });
    let axes = |value: &Option<FrameValue>| {
        value.as_ref().map_or(NO_AXES, |FrameValue { frame, .. }| {
            [frame.direction_max, frame.direction_min].map(|d| d.to_array())
        })
    };
    let principal =
        |value: &Option<FrameValue>| value.as_ref().map_or([f64::NAN; 2], FrameValue::principal);
    let normal = |value: &Option<FrameValue>| value.map_or(DVec3::NAN, |v| v.frame.normal);
    Columns {
        numbers: pointwise.collect(),
        flags: vec![("known", whole.of_surface(all.iter().map(Option::is_some).collect(), false))],
        principal: whole.of_surface(all.iter().map(principal).collect(), [f64::NAN; 2]),
        directions: Some(whole.of_surface(all.iter().map(axes).collect(), NO_AXES)),
        normals: Some(whole.of_surface(all.iter().map(normal).collect(), DVec3::NAN)),
        integrals: values.integrals(&whole.mesh),
        totals: Vec::new(),
        radius: values.radius,
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
