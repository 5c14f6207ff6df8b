//! Bobenko's intersection angle: how the circumcircles of two triangles meet.

use glam::DVec3;

use crate::atan2::atan2;

/// `beta(e)`: the external intersection angle of the circumcircles of the triangles `(i, j, k)` and
/// `(j, i, l)` that share the edge `(i, j)`, in radians, from 0 to pi.
///
/// With the sides `A = l - i`, `B = j - l`, `C = k - j`, `D = i - k` of the closed quadrilateral,
///
/// `cos beta = ((A.C)(B.D) - (A.B)(C.D) - (B.C)(D.A)) / (|A||B||C||D|)`,
///
/// which is minus the real part of the product `ABCD` of imaginary quaternions. Its imaginary part
/// gives the sine, so that angles near 0 and pi keep their digits.
///
/// It is the same for the flipped edge, `(k, l)` with the apexes `i` and `j`. 0 where a side of the
/// quadrilateral has no length. Right for edge lengths between 1e-70 and 1e70.
#[inline]
#[must_use]
pub fn intersection_angle(i: DVec3, j: DVec3, k: DVec3, l: DVec3) -> f64 {
    let [a, b, c, d] = [l - i, j - l, k - j, i - k];
    let (ab, cd) = (a.dot(b), c.dot(d));
    let (a_x_b, c_x_d) = (a.cross(b), c.cross(d));
    let imaginary = a_x_b.cross(c_x_d) - ab * c_x_d - cd * a_x_b;
    let minus_real = a_x_b.dot(c_x_d) - ab * cd;
    atan2(imaginary.length(), minus_real)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;
    use mesh_core::shapes::SplitMix64;

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
    fn coinciding_points_have_no_angle() {
        let [p, q, r] = [DVec3::X, DVec3::Y, DVec3::Z];
        assert_eq!(intersection_angle(p, q, r, p), 0.0);
        assert_eq!(intersection_angle(p, q, p, r), 0.0);
        assert_eq!(intersection_angle(p, p, p, p), 0.0);
    }
}
