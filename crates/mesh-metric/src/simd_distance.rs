//! Distances from points to triangles and between boxes, eight side by side.

use fearless_simd::prelude::*;
use fearless_simd::{f64x8, mask64x8};
use glam::DVec3;
use mesh_core::closest_point::THIN;
use mesh_core::simd::Vec3x8;

/// The vectors from points to the closest points of triangles, with the same bits as
/// [`closest_on_triangle`](crate::closest_on_triangle()), and the squares of their lengths.
#[inline(always)]
pub(crate) fn closest_on_triangles<S: Simd>(
    point: Vec3x8<S>,
    triangles: [Vec3x8<S>; 3],
) -> (Vec3x8<S>, f64x8<S>) {
    let [a, b, c] = triangles;
    let (a, b, c) = (a - point, b - point, c - point);
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let normal = ab.cross(Vec3x8 { x: -ca.x, y: -ca.y, z: -ca.z });
    let squared = normal.length_squared();
    let thin = squared.simd_le(ab.length_squared() * (THIN * THIN) * ca.length_squared());
    // Masks are not joined, but given to selections one after the other: builds without link-time optimisation call a
    // function to join two masks.
    let one = f64x8::splat(squared.simd, 1.0);
    let over_ab = thin.select(one, normal.dot(ab.cross(a))).simd_gt(0.0);
    let over_bc = thin.select(one, normal.dot(bc.cross(b))).simd_gt(0.0);
    let over_ca = thin.select(one, normal.dot(ca.cross(c))).simd_gt(0.0);
    let perpendicular = normal * (normal.dot(a) / squared);
    let far = f64x8::splat(squared.simd, f64::INFINITY);
    let above = over_ca.select(far, perpendicular.length_squared());
    let mut best = (perpendicular, over_ab.select(far, over_bc.select(far, above)));
    best = nearer(best, over_ab, closest_on_segments(a, ab));
    best = nearer(best, over_bc, closest_on_segments(b, bc));
    nearer(best, over_ca, closest_on_segments(c, ca))
}

/// The vectors from the origin to the closest points of the segments from `start` along `along`.
#[inline(always)]
fn closest_on_segments<S: Simd>(start: Vec3x8<S>, along: Vec3x8<S>) -> Vec3x8<S> {
    let squared = along.length_squared();
    let t = -start.dot(along);
    let (zero, one) = (f64x8::splat(squared.simd, 0.0), f64x8::splat(squared.simd, 1.0));
    let part = t.simd_ge(squared).select(one, t / squared);
    start + along * t.simd_le(zero).select(zero, part)
}

/// The candidate, with its squared length, where the mask is set and it is shorter than the best.
#[inline(always)]
fn nearer<S: Simd>(
    best: (Vec3x8<S>, f64x8<S>),
    mask: mask64x8<S>,
    candidate: Vec3x8<S>,
) -> (Vec3x8<S>, f64x8<S>) {
    let squared = candidate.length_squared();
    let far = f64x8::splat(squared.simd, f64::INFINITY);
    let is_nearer = mask.select(squared, far).simd_lt(best.1);
    (Vec3x8::select(is_nearer, candidate, best.0), is_nearer.select(squared, best.1))
}

/// The squared distances between boxes, given by their smallest and largest coordinates.
#[inline(always)]
pub(crate) fn squared_gaps<S: Simd>(a: [Vec3x8<S>; 2], b: [Vec3x8<S>; 2]) -> f64x8<S> {
    let zero = Vec3x8::splat(a[0].x.simd, DVec3::ZERO);
    (b[0] - a[1]).max(a[0] - b[1]).max(zero).length_squared()
}
