//! Szilvási-Nagy 2010: face-based curvature, patches made from it, and what is said of them.

mod arcs;
mod cow;
mod disc;
mod drawing;
mod half_cylinder;
mod regions;
mod series;
mod sphere;
mod translation;

use curvpatch::{CurvatureEstimator, Params, PatchFit, Shape};
use glam::DVec3;
use mesh_core::{EdgeId, FaceId, TriMesh};

use super::Step;
use crate::failure::Failure;
use mesh_render::Style;

pub(super) const STEPS: [Step; 9] = [
    Step { name: "Fig. 1 to 3", compute: disc::compute },
    Step { name: "Fig. 4 and 5", compute: arcs::compute },
    Step { name: "Fig. 6", compute: translation::compute },
    Step { name: "Fig. 7", compute: half_cylinder::compute },
    Step { name: "Fig. 8", compute: series::compute },
    Step { name: "Fig. 9 and 10", compute: sphere::compute },
    Step { name: "Fig. 11 and 12", compute: regions::compute },
    Step { name: "Fig. 13", compute: cow::figure },
    Step { name: "Covers of whole meshes", compute: cow::covers },
];

/// Flat faces with thin edges: patches and lines are drawn on top.
const STYLE: Style = Style { size: [720, 600], edge_width: 1.0, ..Style::DEFAULT };

/// Both presets, and how they are called.
const PRESETS: [(&str, Params); 2] = [("paper", Params::paper()), ("robust", Params::robust())];

fn estimator(mesh: &TriMesh, params: Params) -> Result<CurvatureEstimator<'_>, Failure> {
    CurvatureEstimator::new(mesh, params).map_err(Failure::mesh)
}

fn patch(
    estimator: &CurvatureEstimator<'_>,
    face: FaceId,
    radius: f64,
    shape: Shape,
) -> Result<PatchFit, Failure> {
    estimator.patch(face, radius, shape).map_err(Failure::mesh)
}

/// The face whose barycentre is nearest to a point, on the side of a direction.
fn face_at(mesh: &TriMesh, point: DVec3, side: DVec3) -> FaceId {
    let center = |face: FaceId| mesh.triangle(face).iter().sum::<DVec3>() / 3.0;
    let faces = mesh.topology().faces().filter(|&f| mesh.face_normal(f).dot(side) > 0.0);
    let nearer = |a: &FaceId, b: &FaceId| {
        center(*a).distance_squared(point).total_cmp(&center(*b).distance_squared(point))
    };
    faces.min_by(nearer).unwrap_or(FaceId::new(0))
}

fn mean_edge(mesh: &TriMesh) -> f64 {
    let topology = mesh.topology();
    let length = |edge: EdgeId| {
        let [a, b] = topology.edge_vertices(edge).map(|v| mesh.position(v));
        a.distance(b)
    };
    topology.edges().map(length).sum::<f64>() / topology.edge_count().max(1) as f64
}

/// The median of some numbers; 0 without any.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}

/// A share in percent.
fn percent(part: f64, whole: f64) -> f64 {
    100.0 * part / whole
}
