//! Certified upper and lower bounds of the distance from a point to a triangle, rounding errors included.
//!
//! The closest point that [`closest_on_triangle`] computes is not enough for a proof. Over the interior of a
//! triangle whose smallest angle has the sine `s`, the error of the normal is `ε / s`, and the error of the
//! distance `ε / s` times the longest side, in either direction. The bounds here need no accurate normal.
//!
//! - **Upper bound.** Any convex combination of the corners is a point of the triangle, so the distance to it
//!   is an upper bound. Weights from rounded cross products are valid as long as none is negative.
//! - **Lower bound.** For any unit vector `w`, the triangle lies in the half-space `w · x >= min w · corner`,
//!   so that a point is not closer to it than `min w · (corner - point)`. With `w` towards the closest point
//!   this is the distance itself; with another one it is less, but a lower bound.
//!
//! The remaining error is the rounding of short sums of products. It grows with the distances from the point to
//! the corners, but does not depend on the shape of the triangle. [`Rounding`] bounds it.

use glam::DVec3;
use mesh_core::BoundingBox;
use mesh_core::closest_point::{closest_on_segment, closest_on_triangle};

/// Bounds of the rounding errors for two surfaces.
///
/// Let u = ε/2, let `A` be the largest distance from the point to a corner, and let the weights be non-negative with a
/// sum of 1 up to 3u. All errors are relative to `A`. The differences to the point have an error of u each, products
/// and sums of the combination 6u, and its length 3u. With the radius of a piece about its centre, which may be added,
/// the total is below 16u. A lower bound uses a vector `w` that is a unit vector up to 5u, and a product with it that
/// has an error of 4u: the total is below 16u, and below 20u with the boxes of the tree that the search for the closest
/// triangle skips. `A` is at most the diagonal of the box around both surfaces.
///
/// A point between others, where a piece is divided, is rounded: by u times the largest coordinate along each axis, and
/// by 2u times the length of the side. So the parts cover the piece only up to that distance. In a round, corners are
/// made from corners up to three times.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounding {
    /// Error of one distance.
    distance: f64,
    /// Error of the positions of pieces, per round.
    places: f64,
}

impl Rounding {
    pub(crate) fn between(a: BoundingBox, b: BoundingBox) -> Self {
        let (min, max) = (a.min.min(b.min), a.max.max(b.max));
        // An upper bound of the diagonal.
        let size = 2.0 * (max - min).max_element();
        let largest = min.abs().max(max.abs()).max_element();
        Self {
            distance: 16.0 * f64::EPSILON * size + SMALLEST,
            places: 4.0 * f64::EPSILON * (size + largest),
        }
    }

    /// The error of a bound for a piece after a number of divisions, or for its centre.
    pub(crate) fn after(self, rounds: usize) -> f64 {
        self.distance + (rounds + 1) as f64 * self.places
    }
}

/// The squares of shorter lengths underflow.
const SMALLEST: f64 = 1e-140;

/// Weights with a smaller sum underflow.
const SMALLEST_SUM: f64 = 1e-280;

/// With a smaller sine at the first corner, the weights over the interior are so inaccurate that the sides are
/// tested as well.
const SLIM: f64 = 1e-6;

/// An upper bound of the distance from a point to a triangle, up to [`Rounding`].
#[inline]
pub(crate) fn upper_bound(point: DVec3, triangle: &[DVec3; 3]) -> f64 {
    let squared = to_some_point(point, triangle).length_squared();
    if squared.is_nan() { f64::INFINITY } else { squared.sqrt() }
}

/// A lower bound of the distance from a point to a triangle, up to [`Rounding`].
pub(crate) fn lower_bound(point: DVec3, triangle: &[DVec3; 3]) -> f64 {
    let corners = triangle.map(|corner| corner - point);
    let beyond = |towards: DVec3| {
        let length = towards.length();
        if !(length > SMALLEST && length.is_finite()) {
            return 0.0;
        }
        let unit = towards / length;
        let [a, b, c] = corners.map(|corner| unit.dot(corner));
        let nearest = a.min(b).min(c);
        if nearest.is_finite() { nearest } else { 0.0 }
    };
    let by_normal = beyond(closest_on_triangle(point, triangle));
    by_normal.max(beyond(to_some_point(point, triangle))).max(0.0)
}

/// The vector from `point` to a convex combination of the corners that is close to the closest one.
#[inline]
fn to_some_point(point: DVec3, triangle: &[DVec3; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|corner| corner - point);
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let normal = ab.cross(-ca);
    // For the corners across ab, bc and ca: twice the areas that the foot of the perpendicular spans with the sides,
    // times the length of the normal.
    let [of_c, of_a, of_b] = [ab.cross(a), bc.cross(b), ca.cross(c)].map(|m| -normal.dot(m));
    let sum = of_a + of_b + of_c;
    let is_inside = of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0 && sum > SMALLEST_SUM;
    let mut best = DVec3::INFINITY;
    let mut all_sides = !(of_a < 0.0 || of_b < 0.0 || of_c < 0.0);
    if is_inside && sum.is_finite() {
        let share = 1.0 / sum;
        best = a * (of_a * share) + b * (of_b * share) + c * (of_c * share);
        all_sides =
            normal.length_squared() <= SLIM * SLIM * ab.length_squared() * ca.length_squared();
    }
    for (weight, start, along) in [(of_c, a, ab), (of_a, b, bc), (of_b, c, ca)] {
        if all_sides || weight < 0.0 {
            let candidate = closest_on_segment(start, along);
            if candidate.length_squared() < best.length_squared() {
                best = candidate;
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_bounds_are_the_distance_where_nothing_is_rounded() {
        let triangle = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 4.0, 0.0)];
        for (point, distance) in [
            (DVec3::new(1.0, 1.0, 2.0), 2.0),
            (DVec3::new(1.0, -3.0, 4.0), 5.0),
            (DVec3::new(-2.0, -2.0, 1.0), 3.0),
        ] {
            assert_eq!(upper_bound(point, &triangle), distance);
            assert!((lower_bound(point, &triangle) - distance).abs() < 1e-15);
        }
    }

    #[test]
    fn without_an_area_the_sides_tell() {
        let line = [DVec3::ZERO, DVec3::X, 3.0 * DVec3::X];
        let point = DVec3::new(2.0, 2.0, 0.0);
        assert_eq!((upper_bound(point, &line), lower_bound(point, &line)), (2.0, 2.0));
        let dot = [DVec3::ONE; 3];
        assert_eq!((upper_bound(DVec3::ONE, &dot), lower_bound(DVec3::ONE, &dot)), (0.0, 0.0));
    }

    #[test]
    fn numbers_that_overflow_prove_nothing() {
        let triangle = [DVec3::ZERO, 1e200 * DVec3::X, 1e200 * DVec3::Y];
        let point = DVec3::new(1e199, 1e199, 1e160);
        assert_eq!(
            (upper_bound(point, &triangle), lower_bound(point, &triangle)),
            (f64::INFINITY, 0.0)
        );
    }
}
