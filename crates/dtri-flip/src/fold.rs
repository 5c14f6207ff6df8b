//! Shape of the two new faces of a flip: turn against the quadrilateral, and degeneracy.

use core::f64::consts::PI;

use glam::DVec3;
use mesh_core::{TriMesh, VertexId, angle_between};

use crate::quad::Quad;

/// Whether a flip would turn a face by more than `limit` and by more than the larger current turn.
///
/// The turn of a face is the angle between its normal and the vector area of the quadrilateral. The
/// vector area is the area-weighted sum of the normals of the two triangles; it is the same for both
/// diagonals.
pub(crate) fn folds(mesh: &TriMesh, quad: &Quad, limit: f64) -> bool {
    let now = quad.triangles().map(|t| twice_vector_area(mesh, t));
    let flipped = quad.flipped_triangles().map(|t| twice_vector_area(mesh, t));
    let direction = now[0] + now[1];
    larger_turn(flipped, direction) > limit.max(larger_turn(now, direction))
}

/// The larger turn of the two faces at an edge.
pub(crate) fn largest_turn(mesh: &TriMesh, quad: &Quad) -> f64 {
    let now = quad.triangles().map(|t| twice_vector_area(mesh, t));
    larger_turn(now, now[0] + now[1])
}

fn larger_turn(faces: [DVec3; 2], direction: DVec3) -> f64 {
    faces.map(|n| turn_of(n, direction)).into_iter().fold(0.0, f64::max)
}

pub(crate) fn twice_vector_area(mesh: &TriMesh, triangle: [VertexId; 3]) -> DVec3 {
    let [a, b, c] = triangle;
    let origin = mesh.position(a);
    (mesh.position(b) - origin).cross(mesh.position(c) - origin)
}

/// The angle between the normal of a face and a direction. A face without area has no normal and counts as folded back.
pub(crate) fn turn_of(normal: DVec3, direction: DVec3) -> f64 {
    if normal == DVec3::ZERO { PI } else { angle_between(normal, direction) }
}

/// Whether a flip would increase the number of degenerate faces.
///
/// A face is degenerate if its height is at most `resolution`, the rounding error of a distance. It has
/// no normal, so costs that depend on angles between normals ignore it and would hide sharp edges in
/// such faces.
pub(crate) fn makes_degenerate(mesh: &TriMesh, quad: &Quad, resolution: f64) -> bool {
    let degenerate = |triangles: [[VertexId; 3]; 2]| {
        triangles.into_iter().filter(|t| is_degenerate(mesh, *t, resolution)).count()
    };
    let flipped = degenerate(quad.flipped_triangles());
    flipped > 0 && flipped > degenerate(quad.triangles())
}

/// Whether a triangle is degenerate; see [`makes_degenerate`].
pub(crate) fn is_degenerate(mesh: &TriMesh, triangle: [VertexId; 3], resolution: f64) -> bool {
    let [a, b, c] = triangle.map(|v| mesh.position(v));
    let longest = (b - a).length_squared().max((c - b).length_squared());
    let longest = longest.max((a - c).length_squared());
    let squared = (b - a).cross(c - a).length_squared();
    squared <= resolution * resolution * longest
}
