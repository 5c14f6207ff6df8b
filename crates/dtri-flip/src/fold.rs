//! How far the faces of a quadrilateral are turned from its direction.

use core::f64::consts::PI;

use glam::DVec3;
use mesh_core::{TriMesh, VertexId, angle_between};

use crate::quad::Quad;

/// Whether a flip would turn a face by more than `limit`, and by more than any is turned now.
///
/// The vector area of the closed polygon a, d, b, c is the sum of the normals of its two triangles,
/// weighted by area, whichever diagonal cuts it. It is what the faces are measured against.
pub(crate) fn folds(mesh: &TriMesh, quad: &Quad, limit: f64) -> bool {
    let now = quad.triangles().map(|t| twice_vector_area(mesh, t));
    let flipped = quad.flipped_triangles().map(|t| twice_vector_area(mesh, t));
    let direction = now[0] + now[1];
    let turn =
        |faces: [DVec3; 2]| faces.map(|n| turn_of(n, direction)).into_iter().fold(0.0, f64::max);
    turn(flipped) > limit.max(turn(now))
}

fn twice_vector_area(mesh: &TriMesh, triangle: [VertexId; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|v| mesh.position(v));
    (b - a).cross(c - a)
}

/// A face without area has no direction and counts as folded back.
fn turn_of(normal: DVec3, direction: DVec3) -> f64 {
    if normal == DVec3::ZERO { PI } else { angle_between(normal, direction) }
}
