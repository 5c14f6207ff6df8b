//! Patches at chosen faces, by both presets.

use curvpatch::{CurvatureEstimator, Params, PatchFit, Shape};
use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_render::Style;

use xtask_common::Failure;

/// Flat faces with thin edges: patches and lines are drawn on top.
pub(super) const STYLE: Style = Style { size: [720, 600], edge_width: 1.0, ..Style::DEFAULT };

/// Both presets, and how they are called.
pub(super) const PRESETS: [(&str, Params); 2] =
    [("paper", Params::paper()), ("robust", Params::robust())];

pub(super) fn estimator(mesh: &TriMesh, params: Params) -> Result<CurvatureEstimator<'_>, Failure> {
    CurvatureEstimator::new(mesh, params).map_err(Failure::mesh)
}

pub(super) fn patch(
    estimator: &CurvatureEstimator<'_>,
    face: FaceId,
    radius: f64,
    shape: Shape,
) -> Result<PatchFit, Failure> {
    estimator.patch(face, radius, shape).map_err(Failure::mesh)
}

/// The principal axes in the order of SN10: the axis whose curvature has the larger absolute value first.
/// (`curvpatch` has the larger curvature first.)
pub(super) fn axes_of_paper(curvatures: [f64; 2]) -> [usize; 2] {
    let [k1, k2] = curvatures.map(f64::abs);
    if k1 >= k2 { [0, 1] } else { [1, 0] }
}

/// The face whose barycentre is nearest to a point, on the side of a direction.
pub(super) fn face_at(mesh: &TriMesh, point: DVec3, side: DVec3) -> FaceId {
    let center = |face: FaceId| mesh.triangle(face).iter().sum::<DVec3>() / 3.0;
    let faces = mesh.topology().faces().filter(|&f| mesh.face_normal(f).dot(side) > 0.0);
    let nearer = |a: &FaceId, b: &FaceId| {
        center(*a).distance_squared(point).total_cmp(&center(*b).distance_squared(point))
    };
    faces.min_by(nearer).unwrap_or(FaceId::new(0))
}
