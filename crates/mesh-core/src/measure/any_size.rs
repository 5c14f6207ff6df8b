//! Directions, areas and exact orientation tests of points of any size.
//!
//! Products of lengths overflow with coordinates of 1e80, and vanish with 1e-100. A division by a power of two changes no
//! digit, so the functions here give the scaled results for scaled points. At ordinary sizes they divide by nothing.

use core::ops::Range;
use std::borrow::Cow;

use glam::{DVec2, DVec3};
use robust::{Coord, Coord3D};

/// The squared length at which neither it nor its products lose digits.
const ORDINARY_SQUARES: Range<f64> = 1e-290..1e290;
/// The largest coordinate at which all products of exact orientation tests are numbers.
const ORDINARY_COORDINATES: Range<f64> = 1e-60..1e90;

/// The largest coordinate at which all products in this crate are numbers.
const ORDINARY_POINTS: Range<f64> = 1e-30..1e30;

/// The largest power of two up to a positive, finite number.
pub(crate) fn power_of_two(number: f64) -> f64 {
    let leading = f64::from_bits(number.to_bits() & (0x7FF << 52));
    if leading > 0.0 { leading } else { f64::MIN_POSITIVE }
}

/// Vectors divided by the power of two that brings their largest coordinate to between 1 and 2. If that coordinate is
/// zero or not finite, the vectors stay as they are.
///
/// ```
/// use mesh_core::{glam::DVec3, unit_sized};
///
/// let [a, b] = unit_sized([3e200 * DVec3::X, 4e200 * DVec3::Y]);
/// assert!((a.cross(b).length() / (a.length() * b.length()) - 1.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn unit_sized<const N: usize>(vectors: [DVec3; N]) -> [DVec3; N] {
    let largest = largest(&vectors);
    if largest > 0.0 && largest.is_finite() {
        let factor = power_of_two(largest);
        vectors.map(|vector| vector / factor)
    } else {
        vectors
    }
}

fn largest(vectors: &[DVec3]) -> f64 {
    vectors.iter().fold(DVec3::ZERO, |most, vector| most.max(vector.abs())).max_element()
}

/// Points divided by the power of two that brings the median of their largest coordinates to between 1 and 2, and this
/// power. At ordinary sizes, and if a coordinate has no exact quotient, the points stay as they are.
#[must_use]
pub fn unit_sized_points(points: &[DVec3]) -> (Cow<'_, [DVec3]>, f64) {
    let size = |point: &DVec3| point.abs().max_element();
    let counts = |size: &f64| *size > 0.0 && size.is_finite();
    let sizes = points.iter().map(size).filter(counts);
    if sizes.clone().all(|size| ORDINARY_POINTS.contains(&size)) {
        return (points.into(), 1.0);
    }
    let mut sizes: Vec<f64> = sizes.collect();
    let middle = sizes.len() / 2;
    let (_, &mut median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    let factor = power_of_two(median);
    let scaled: Vec<DVec3> = points.iter().map(|&point| point / factor).collect();
    let is_exact =
        |(&scaled, &point): (&DVec3, &DVec3)| scaled * factor == point || !point.is_finite();
    match !ORDINARY_POINTS.contains(&median) && scaled.iter().zip(points).all(is_exact) {
        true => (scaled.into(), factor),
        false => (points.into(), 1.0),
    }
}

/// The unit vector in the direction of a vector; zero for the zero vector and for vectors that are not finite.
#[inline]
#[must_use]
pub fn direction(vector: DVec3) -> DVec3 {
    match ORDINARY_SQUARES.contains(&vector.length_squared()) {
        true => vector.normalize_or_zero(),
        false => unit_sized([vector])[0].normalize_or_zero(),
    }
}

/// The unit normal of a triangle; zero without area. Seen against it, the corners are counter-clockwise.
#[inline]
#[must_use]
pub fn triangle_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let cross = (b - a).cross(c - a);
    match ORDINARY_SQUARES.contains(&cross.length_squared()) {
        true => cross.normalize_or_zero(),
        false => far_normal(b - a, c - a),
    }
}

#[cold]
fn far_normal(u: DVec3, v: DVec3) -> DVec3 {
    let [u, v] = unit_sized([u, v]);
    direction(u.cross(v))
}

/// The sign of the volume of the tetrahedron `a`, `b`, `c`, `d`, decided exactly: positive if `d` is below the plane in
/// which `a`, `b` and `c` are counter-clockwise seen from above.
#[inline]
#[must_use]
pub fn orient3d(points: [DVec3; 4]) -> f64 {
    let points =
        if ORDINARY_COORDINATES.contains(&largest(&points)) { points } else { unit_sized(points) };
    let [a, b, c, d] = points.map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
    robust::orient3d(a, b, c, d)
}

/// The sign of the area of the triangle `a`, `b`, `c`, decided exactly: positive if it is counter-clockwise.
#[inline]
#[must_use]
pub fn orient2d(points: [DVec2; 3]) -> f64 {
    let largest =
        points.iter().fold(DVec2::ZERO, |most, point| most.max(point.abs())).max_element();
    let points = match ORDINARY_COORDINATES.contains(&largest) {
        true => points,
        false => unit_sized(points.map(|p| p.extend(0.0))).map(DVec3::truncate),
    };
    let [a, b, c] = points.map(|p| Coord { x: p.x, y: p.y });
    robust::orient2d(a, b, c)
}
