//! What a flip does to the shape of the two faces: how far they are turned, and whether they keep
//! an area.

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
    larger_turn(flipped, direction) > limit.max(larger_turn(now, direction))
}

/// The larger angle by which one of the faces at an edge is turned now.
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

/// A face without area has no direction and counts as folded back.
fn turn_of(normal: DVec3, direction: DVec3) -> f64 {
    if normal == DVec3::ZERO { PI } else { angle_between(normal, direction) }
}

/// Whether a flip would leave more faces without area than there are now.
///
/// A face has none when its height is no more than `resolution`, what coordinates of that size can
/// tell apart. It has no normal either, so a cost that looks at angles between normals could not
/// see what is wrong with it and would hide sharp edges behind such faces.
pub(crate) fn flattens(mesh: &TriMesh, quad: &Quad, resolution: f64) -> bool {
    let without_area = |triangles: [[VertexId; 3]; 2]| {
        triangles.into_iter().filter(|t| is_flat(mesh, *t, resolution)).count()
    };
    let flipped = without_area(quad.flipped_triangles());
    flipped > 0 && flipped > without_area(quad.triangles())
}

/// Whether a triangle has no area; see [`flattens`].
pub(crate) fn is_flat(mesh: &TriMesh, triangle: [VertexId; 3], resolution: f64) -> bool {
    let [a, b, c] = triangle.map(|v| mesh.position(v));
    let longest = (b - a).length_squared().max((c - b).length_squared());
    let longest = longest.max((a - c).length_squared());
    let squared = (b - a).cross(c - a).length_squared();
    squared <= resolution * resolution * longest
}
