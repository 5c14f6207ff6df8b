//! Bobenko's intersection angle of the circumcircles of two adjacent triangles.

use fearless_simd::{Level, dispatch};
use glam::DVec3;

use crate::angle::unit_scale;
use crate::atan2::atan2;

/// `beta(e)`: the external intersection angle of the circumcircles of the triangles `(i, j, k)` and
/// `(j, i, l)` that share the edge `(i, j)`, in radians, from 0 to pi.
///
/// With the sides `A = l - i`, `B = j - l`, `C = k - j`, `D = i - k` of the closed quadrilateral,
///
/// `cos beta = ((A.C)(B.D) - (A.B)(C.D) - (B.C)(D.A)) / (|A||B||C||D|)`,
///
/// which is minus the real part of the product `ABCD` of imaginary quaternions. The imaginary part gives
/// the sine, so that angles near 0 and pi keep their precision.
///
/// The flipped edge, `(k, l)` with the apexes `i` and `j`, has the same angle. 0 if a side of the
/// quadrilateral has no length. Valid for lengths between 1e-150 and 1e150: sides are scaled where the
/// products would overflow, which does not change the angle.
#[inline]
#[must_use]
pub fn intersection_angle(i: DVec3, j: DVec3, k: DVec3, l: DVec3) -> f64 {
    let sides = [l - i, j - l, k - j, i - k];
    let (minus_real, imaginary) = product(sides);
    if is_in_range(minus_real, imaginary) {
        return atan2(imaginary, minus_real);
    }
    scaled_intersection_angle(sides)
}

/// [`intersection_angle`] of many edges, vectorised, with the same bits. Each row has the four points of
/// one edge.
pub(crate) fn intersection_angles_of<const N: usize>(
    level: Level,
    rows: &[[DVec3; 4]; N],
) -> [f64; N] {
    let mut columns = [[0.0; N]; 12];
    for (i, row) in rows.iter().enumerate() {
        for (point, three) in row.iter().zip(columns.as_chunks_mut::<3>().0) {
            (three[0][i], three[1][i], three[2][i]) = (point.x, point.y, point.z);
        }
    }
    let mut angles = [0.0; N];
    let mut in_range = [false; N];
    dispatch!(level, _ => evaluate(&columns, &mut angles, &mut in_range));
    for (i, [p, q, r, s]) in rows.iter().enumerate() {
        if !in_range[i] {
            angles[i] = intersection_angle(*p, *q, *r, *s);
        }
    }
    angles
}

/// The angles of rows with coordinates in columns. Angles out of range are undefined.
#[inline(always)]
fn evaluate<const N: usize>(
    columns: &[[f64; N]; 12],
    angles: &mut [f64; N],
    in_range: &mut [bool; N],
) {
    let (mut real, mut other) = ([0.0; N], [0.0; N]);
    for n in 0..N {
        let at = |c: usize| DVec3::new(columns[c][n], columns[c + 1][n], columns[c + 2][n]);
        let [i, j, k, l] = [at(0), at(3), at(6), at(9)];
        (real[n], other[n]) = product([l - i, j - l, k - j, i - k]);
    }
    for n in 0..N {
        angles[n] = atan2(other[n], real[n]);
        in_range[n] = is_in_range(real[n], other[n]);
    }
}

/// Whether the square of the product is representable.
#[inline(always)]
pub(crate) fn is_in_range(minus_real: f64, imaginary: f64) -> bool {
    let size = minus_real.abs() + imaginary;
    size > 1e-100 && size < 1e150
}

/// Minus the real part of the product of four imaginary quaternions, and the length of its
/// imaginary part.
#[inline(always)]
pub(crate) fn product([a, b, c, d]: [DVec3; 4]) -> (f64, f64) {
    let (ab, cd) = (a.dot(b), c.dot(d));
    let (a_x_b, c_x_d) = (a.cross(b), c.cross(d));
    let imaginary = a_x_b.cross(c_x_d) - ab * c_x_d - cd * a_x_b;
    (a_x_b.dot(c_x_d) - ab * cd, imaginary.length())
}

/// [`intersection_angle`] for sides that are very long, very short or without length.
#[cold]
fn scaled_intersection_angle(sides: [DVec3; 4]) -> f64 {
    let (minus_real, imaginary) =
        product(sides.map(|side| side * unit_scale(side.abs().max_element())));
    atan2(imaginary, minus_real)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;
    use mesh_core::SplitMix64;

    fn random_points(random: &mut SplitMix64) -> [DVec3; 4] {
        [(); 4].map(|()| DVec3::new(random.uniform(), random.uniform(), random.uniform()))
    }

    #[test]
    fn agrees_with_the_arc_cosine_and_with_the_flipped_edge() {
        let mut random = SplitMix64::new(3);
        for _ in 0..10_000 {
            let [i, j, k, l] = random_points(&mut random);
            let [a, b, c, d] = [l - i, j - l, k - j, i - k];
            let lengths = a.length() * b.length() * c.length() * d.length();
            let cosine = a.dot(c) * b.dot(d) - a.dot(b) * c.dot(d) - b.dot(c) * d.dot(a);
            let beta = intersection_angle(i, j, k, l);
            assert!((beta.cos() - cosine / lengths).abs() < 1e-12);
            assert!((beta - intersection_angle(j, i, l, k)).abs() < 1e-12);
            assert!((beta - intersection_angle(k, l, i, j)).abs() < 1e-12);
        }
    }

    #[test]
    fn does_not_change_under_inversion() {
        let mut random = SplitMix64::new(4);
        let centre = DVec3::new(-1.0, -2.0, 0.5);
        for _ in 0..1000 {
            let points = random_points(&mut random);
            let inverted = points.map(|p| centre + (p - centre) / p.distance_squared(centre));
            let [before, after] =
                [points, inverted].map(|[i, j, k, l]| intersection_angle(i, j, k, l));
            assert!((before - after).abs() < 1e-10);
        }
    }

    #[test]
    fn is_zero_and_pi_on_one_circle() {
        let at = |angle: f64| DVec3::new(angle.cos(), angle.sin(), 0.0);
        let [p, q, r, s] = [0.1, 1.0, 2.5, 4.0].map(at);
        // A diagonal of the quadrilateral on the circle, then one of its sides.
        assert!((intersection_angle(p, r, s, q) - 0.0).abs() < 1e-15);
        assert!((intersection_angle(p, q, r, s) - PI).abs() < 1e-15);
    }

    #[test]
    fn small_angles_keep_their_digits() {
        // A circle and its copy, turned by a small angle about their common chord.
        let angle = 1e-9_f64;
        let (i, j) = (DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.0, 1.0, 0.0));
        let k = DVec3::new(-1.0, 0.0, 0.0);
        let l = DVec3::new(angle.cos(), 0.0, angle.sin());
        assert!((intersection_angle(i, j, k, l) - angle).abs() < 1e-15 * angle.abs());
    }

    #[test]
    fn scale_changes_nothing() {
        let mut random = SplitMix64::new(5);
        for _ in 0..100 {
            let points = random_points(&mut random);
            let [i, j, k, l] = points;
            let expected = intersection_angle(i, j, k, l);
            for exponent in (-145..=145).step_by(5) {
                let [i, j, k, l] = points.map(|p| p * 10.0_f64.powi(exponent));
                let found = intersection_angle(i, j, k, l);
                assert!((found - expected).abs() < 1e-10 * expected, "1e{exponent}: {found}");
            }
            for exponent in [-500, -300, -120, 120, 300, 500] {
                let [i, j, k, l] = points.map(|p| p * 2.0_f64.powi(exponent));
                let found = intersection_angle(i, j, k, l);
                assert!((found - expected).abs() < 1e-13 * expected, "2^{exponent}: {found}");
            }
        }
        // One short side beside long ones.
        let (i, j) = (DVec3::ZERO, DVec3::X);
        let apex = |height: f64| DVec3::new(0.5, height, 0.0);
        let found = intersection_angle(i * 1e-60, j * 1e-60, apex(1e60), apex(-1e60));
        assert!((found - PI).abs() < 1e-15 || found.abs() < 1e-15, "{found}");
    }

    /// Also out of range, and without length.
    #[test]
    fn many_have_the_bits_of_each() {
        let mut random = SplitMix64::new(6);
        for exponent in [0, 0, 0, -60, 60, -150, 150] {
            let mut rows = [(); 19].map(|()| random_points(&mut random));
            rows[4] = rows[4].map(|p| p * 10.0_f64.powi(exponent));
            rows[7][2] = rows[7][1];
            rows[8] = [DVec3::X; 4];
            let expected = rows.map(|[i, j, k, l]| intersection_angle(i, j, k, l));
            for level in [Level::new(), Level::baseline()] {
                assert_eq!(intersection_angles_of(level, &rows), expected);
            }
        }
    }

    #[test]
    fn coinciding_points_have_no_angle() {
        let [p, q, r] = [DVec3::X, DVec3::Y, DVec3::Z];
        assert_eq!(intersection_angle(p, q, r, p), 0.0);
        assert_eq!(intersection_angle(p, q, p, r), 0.0);
        assert_eq!(intersection_angle(p, p, p, p), 0.0);
    }
}
