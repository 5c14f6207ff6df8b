//! Closest points of triangles and segments.

use glam::DVec3;

/// A triangle with a sine below this at its first corner is as thin as the rounding of its corners; it is
/// treated as its three sides.
pub const THIN: f64 = 1e-12;

/// The vector from `point` to the closest point of a triangle, which may be degenerate.
///
/// All computations are relative to `point`, so that the precision does not depend on the distance from the
/// origin.
///
/// If the point projects into the triangle, the result is the perpendicular to its plane. Otherwise it ends on
/// one of the sides beyond which the point lies.
///
/// Error: over the interior of a triangle whose smallest angle has the sine `s`, the length is off by up to
/// about `2e-16 / s` times the longest side. The certified bounds of the crate `mesh-metric` account for that.
#[inline]
#[must_use]
pub fn closest_on_triangle(point: DVec3, triangle: &[DVec3; 3]) -> DVec3 {
    // For hot loops: no `map`, which is not always inlined.
    let (a, b, c) = (triangle[0] - point, triangle[1] - point, triangle[2] - point);
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let normal = ab.cross(-ca);
    let squared = normal.length_squared();
    let thin = squared <= THIN * THIN * ab.length_squared() * ca.length_squared();
    // Negative beyond the side, seen from inside.
    let is_beyond = |start: DVec3, along: DVec3| thin || normal.dot(along.cross(start)) > 0.0;
    let beyond = [is_beyond(a, ab), is_beyond(b, bc), is_beyond(c, ca)];
    if beyond == [false; 3] {
        return normal * (normal.dot(a) / squared);
    }
    let mut best = DVec3::INFINITY;
    for (is_beyond, start, along) in [(beyond[0], a, ab), (beyond[1], b, bc), (beyond[2], c, ca)] {
        if is_beyond {
            let candidate = closest_on_segment(start, along);
            if candidate.length_squared() < best.length_squared() {
                best = candidate;
            }
        }
    }
    best
}

/// The perpendicular foot of a point in the plane of a triangle; made by [`foot_inside`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The vector from the point to the foot.
    pub offset: DVec3,
    /// The unit normal of the triangle.
    pub normal: DVec3,
    /// Twice the area of the triangle.
    pub double_area: f64,
}

/// Why a point has no [`Foot`] on a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoFoot {
    /// The foot lies beyond the side opposite to this corner; of several such sides, beyond the one farthest away
    /// relative to the height of the triangle over it.
    Beyond(usize),
    /// The point is too far from the plane, or the triangle has no area.
    Far,
}

/// The perpendicular foot of a point, if it lies inside the triangle and the point is near: at most about a
/// fifth of a side away.
///
/// On a surface that bends little over the length of a side, this is the closest point nearby.
///
/// # Errors
/// There is no such foot. The error names the side beyond which it falls, where a search may continue.
#[inline]
pub fn foot_inside(point: DVec3, triangle: &[DVec3; 3]) -> Result<Foot, NoFoot> {
    let Seen { cross, parts, height } = Seen::new(point, triangle);
    let least = parts.min_position();
    if parts[least] < 0.0 {
        return Err(NoFoot::Beyond(least));
    }
    let length = cross.length();
    let inverse = length.recip();
    let (normal, height) = (cross * inverse, height * inverse);
    // Without area there is no normal, and no point is near.
    let is_near = height * height <= NEAR * length;
    let foot = Foot { offset: height * normal, normal, double_area: length };
    if is_near { Ok(foot) } else { Err(NoFoot::Far) }
}

/// A point is near if its squared height over a triangle is at most this multiple of twice the area.
const NEAR: f64 = 0.05;

/// A triangle and a point projected onto its plane.
struct Seen {
    /// The normal, of the length of twice the area.
    cross: DVec3,
    /// The barycentric coordinates of the foot of the point, times four times the squared area.
    parts: DVec3,
    /// The dot product of the normal and the vector to the plane.
    height: f64,
}

impl Seen {
    #[inline]
    fn new(point: DVec3, triangle: &[DVec3; 3]) -> Self {
        let (a, b, c) = (triangle[0] - point, triangle[1] - point, triangle[2] - point);
        let cross = (b - a).cross(c - a);
        let (bc, ca, ab) = (b.cross(c), c.cross(a), a.cross(b));
        let parts = DVec3::new(cross.dot(bc), cross.dot(ca), cross.dot(ab));
        Self { cross, parts, height: cross.dot(a) }
    }
}

/// Barycentric coordinates of the closest point of a triangle: not negative, with sum one. All are 1/3 for a
/// triangle without area.
#[inline]
#[must_use]
pub fn weights_of_closest(point: DVec3, triangle: &[DVec3; 3]) -> DVec3 {
    if let Some(weights) = weights_inside(point, triangle) {
        return weights;
    }
    let at = point + closest_on_triangle(point, triangle);
    let (a, b, c) = (triangle[0] - at, triangle[1] - at, triangle[2] - at);
    let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    let parts = DVec3::new(b.cross(c).dot(normal), c.cross(a).dot(normal), a.cross(b).dot(normal));
    let parts = parts.max(DVec3::ZERO);
    let sum = parts.element_sum();
    if sum > 0.0 { parts / sum } else { DVec3::splat(1.0 / 3.0) }
}

/// [`weights_of_closest`] if the foot lies inside and the triangle is not thin: the ratios of areas.
#[inline]
fn weights_inside(point: DVec3, triangle: &[DVec3; 3]) -> Option<DVec3> {
    let Seen { cross, parts, .. } = Seen::new(point, triangle);
    let (ab, ac) = (triangle[1] - triangle[0], triangle[2] - triangle[0]);
    let is_inside = parts.min_element() >= 0.0
        && cross.length_squared() > THIN * THIN * ab.length_squared() * ac.length_squared();
    is_inside.then(|| parts / parts.element_sum())
}

/// The vector from the origin to the closest point of the segment from `start` along `along`.
#[inline]
#[must_use]
pub fn closest_on_segment(start: DVec3, along: DVec3) -> DVec3 {
    let squared = along.length_squared();
    let t = -start.dot(along);
    if t <= 0.0 {
        start
    } else if t >= squared {
        start + along
    } else {
        start + along * (t / squared)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [DVec3; 3] =
        [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 3.0, 0.0)];

    #[test]
    fn each_region_of_a_right_triangle() {
        let cases = [
            // Above the inside.
            (DVec3::new(1.0, 1.0, 2.0), DVec3::new(0.0, 0.0, -2.0)),
            // Beyond the sides.
            (DVec3::new(2.0, -1.0, 0.0), DVec3::new(0.0, 1.0, 0.0)),
            (DVec3::new(-2.0, 1.0, 1.0), DVec3::new(2.0, 0.0, -1.0)),
            (DVec3::new(2.0 + 3.0, 1.5 + 4.0, 0.0), DVec3::new(-3.0, -4.0, 0.0)),
            // Beyond the corners.
            (DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0)),
            (DVec3::new(6.0, -1.0, 0.0), DVec3::new(-2.0, 1.0, 0.0)),
            (DVec3::new(-0.5, 5.0, 0.0), DVec3::new(0.5, -2.0, 0.0)),
        ];
        for (point, expected) in cases {
            let got = closest_on_triangle(point, &TRIANGLE);
            assert!(got.distance(expected) < 1e-15, "{point}: {got}, not {expected}");
        }
    }

    #[test]
    fn the_weights_give_the_closest_point() {
        let far = [(1.0, 1.0, 2.0), (2.0, -1.0, 0.0), (5.0, 5.5, 0.0), (6.0, -1.0, 3.0)];
        for point in far.map(|(x, y, z)| DVec3::new(x, y, z)) {
            let weights = weights_of_closest(point, &TRIANGLE);
            assert!(weights.min_element() >= 0.0);
            assert!((weights.element_sum() - 1.0).abs() < 1e-15);
            let [a, b, c] = TRIANGLE;
            let found = weights.x * a + weights.y * b + weights.z * c;
            let expected = point + closest_on_triangle(point, &TRIANGLE);
            assert!(found.distance(expected) < 1e-14, "{point}: {found}, not {expected}");
        }
        assert_eq!(weights_of_closest(DVec3::Z, &[DVec3::X; 3]), DVec3::splat(1.0 / 3.0));
    }

    #[test]
    fn a_foot_is_found_inside_and_near_only() {
        let at = |x: f64, y: f64, z: f64| foot_inside(DVec3::new(x, y, z), &TRIANGLE);
        let foot = at(1.0, 1.0, -0.5).unwrap();
        assert_eq!((foot.offset, foot.normal, foot.double_area), (0.5 * DVec3::Z, DVec3::Z, 12.0));
        // Beyond a side, at the same distance; above the inside, but farther than the square root of 0.6.
        assert_eq!(at(2.1, 1.5, 0.5), Err(NoFoot::Beyond(0)));
        assert_eq!(at(-0.1, 1.0, 0.0), Err(NoFoot::Beyond(1)));
        assert_eq!(at(1.0, -0.1, 9.0), Err(NoFoot::Beyond(2)));
        // Beyond two sides, and farther beyond the second one.
        assert_eq!(at(-0.2, -0.3, 0.0), Err(NoFoot::Beyond(2)));
        assert_eq!(at(1.0, 1.0, 0.78), Err(NoFoot::Far));
        assert!(at(1.0, 1.0, 0.77).is_ok() && at(1.0, 0.0, 0.5).is_ok());
        let line = [DVec3::ZERO, DVec3::X, 3.0 * DVec3::X];
        assert_eq!(foot_inside(DVec3::ZERO, &line), Err(NoFoot::Far));
        assert_eq!(foot_inside(DVec3::NAN, &TRIANGLE), Err(NoFoot::Far));
    }

    #[test]
    fn degenerate_triangles_are_their_sides() {
        let x = DVec3::X;
        let point = DVec3::new(1.5, 1.0, 0.0);
        assert_eq!(closest_on_triangle(point, &[x; 3]), x - point);
        let collinear = [DVec3::ZERO, 3.0 * x, x];
        assert_eq!(closest_on_triangle(point, &collinear), -DVec3::Y);
        let doubled = [x, x, 2.0 * x];
        assert_eq!(closest_on_triangle(point, &doubled), -DVec3::Y);
    }

    #[test]
    fn far_from_the_origin_the_distance_keeps_its_digits() {
        let shift = DVec3::splat(2.0_f64.powi(30));
        let moved = TRIANGLE.map(|p| p + shift);
        let point = shift + DVec3::new(1.0, 1.0, 0.125);
        assert_eq!(closest_on_triangle(point, &moved), DVec3::new(0.0, 0.0, -0.125));
    }
}
