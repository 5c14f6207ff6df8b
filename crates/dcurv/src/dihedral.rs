//! The signed dihedral angle at an edge.

use glam::DVec3;
use mesh_core::unit_sized;

use crate::atan2::atan2;

/// The signed dihedral angle at the edge from `a` to `b`, in radians, from -pi to pi.
///
/// `c` is the apex of the face `(a, b, c)` to the left of the edge, `d` the apex of the face `(b, a, d)`
/// to its right, seen from outside. The angle is measured between the face normals: 0 for coplanar
/// faces, positive where convex, negative where concave, pi for a face folded onto the other. Reversing
/// the edge, `(b, a, d, c)`, changes rounding only. Reversing the orientation, `(b, a, c, d)`, changes
/// the sign.
///
/// The arc tangent of sine and cosine keeps the relative precision of small angles, where the arc
/// cosine of the normals loses it.
///
/// 0 if a face has no area. Valid at any size, if the lengths differ by at most a factor of 1e50.
#[inline]
#[must_use]
pub fn dihedral_angle(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let sides = [b - a, c - a, d - a];
    let length = sides[0].length();
    // Products have up to four lengths.
    if length > 1e-60 && length < 1e60 { angle_between(sides) } else { far_angle(sides) }
}

/// The dihedral angle at the first of three vectors from its origin, between the faces to the others.
#[inline(always)]
fn angle_between([edge, left, right]: [DVec3; 3]) -> f64 {
    hinge_angle(edge.length(), edge.cross(left), right.cross(edge), right)
}

#[cold]
fn far_angle(sides: [DVec3; 3]) -> f64 {
    angle_between(unit_sized(sides))
}

/// The dihedral angle from the length of an edge, the normals of its left and right face (of any length)
/// and the vector from its origin to the right apex.
///
/// For an edge `e` with left normal `m = e x c` and right normal `n = d x e`, the cross product
/// `m x n` is `-(m . d) e`: the sine is a product of three vectors, not of four.
#[inline(always)]
#[must_use]
pub fn hinge_angle(edge_length: f64, left_normal: DVec3, right_normal: DVec3, right: DVec3) -> f64 {
    let sine = -edge_length * left_normal.dot(right);
    let cosine = left_normal.dot(right_normal);
    atan2(sine, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, PI};
    use glam::DQuat;

    /// An edge from `a` to `b` whose right face is turned downwards by `angle`, in some position.
    fn hinge(angle: f64, frame: DQuat, offset: DVec3) -> [DVec3; 4] {
        let left = DVec3::new(-1.3, 0.4, 0.0);
        let right = DVec3::new(0.7 * angle.cos(), 0.9, -0.7 * angle.sin());
        [DVec3::ZERO, DVec3::new(0.0, 1.7, 0.0), left, right].map(|p| frame * p + offset)
    }

    #[test]
    fn trap_10_tiny_dihedral_angles_keep_their_digits() {
        // Without rotation the coordinates hold the angle exactly.
        for angle in [1e-2, 1e-8, 1e-12, -1e-8, -1e-3] {
            let [a, b, c, d] = hinge(angle, DQuat::IDENTITY, DVec3::ZERO);
            let found = dihedral_angle(a, b, c, d);
            println!("angle {angle:e}: found {found:e}");
            assert!((found - angle).abs() <= 1e-15 * angle.abs());
        }
        // In general position the rounded points themselves are off by 1e-16 / 1e-8.
        for turn in 1..50 {
            let axis = DVec3::new(1.0, f64::from(turn), 3.0).normalize();
            let frame = DQuat::from_axis_angle(axis, 0.37 * f64::from(turn));
            for angle in [1e-8, -1e-8] {
                let [a, b, c, d] = hinge(angle, frame, DVec3::ZERO);
                assert!((dihedral_angle(a, b, c, d) - angle).abs() < 1e-6 * 1e-8);
                assert!((dihedral_angle(b, a, d, c) - angle).abs() < 1e-6 * 1e-8);
                assert!((dihedral_angle(b, a, c, d) + angle).abs() < 1e-6 * 1e-8);
            }
        }
    }

    #[test]
    fn large_angles_and_folds() {
        for angle in [FRAC_PI_2, 3.0, PI, -FRAC_PI_2, -3.1] {
            let [a, b, c, d] = hinge(angle, DQuat::IDENTITY, DVec3::new(1.0, 2.0, 3.0));
            assert!((dihedral_angle(a, b, c, d) - angle).abs() < 1e-14);
        }
        let [a, b, c, _] = hinge(0.0, DQuat::IDENTITY, DVec3::ZERO);
        assert_eq!(dihedral_angle(a, b, c, c), PI);
        assert_eq!(dihedral_angle(b, a, c, c), PI);
    }

    #[test]
    fn faces_without_area_have_no_dihedral_angle() {
        let [a, b, c, d] = hinge(0.5, DQuat::IDENTITY, DVec3::ZERO);
        for (left, right) in [(a, d), (c, b), (0.5 * (a + b), d), (c, a), (b, b)] {
            assert_eq!(dihedral_angle(a, b, left, right), 0.0);
            assert_eq!(dihedral_angle(b, a, right, left), 0.0);
        }
        assert_eq!(dihedral_angle(a, a, c, d), 0.0);
    }

    #[test]
    fn scale_changes_nothing() {
        let [a, b, c, d] = hinge(0.3, DQuat::from_rotation_x(0.4), DVec3::ZERO);
        for scale in [1e-70, 1e-6, 1e6, 1e70] {
            let [a, b, c, d] = [a, b, c, d].map(|p| scale * p);
            assert!((dihedral_angle(a, b, c, d) - 0.3).abs() < 1e-14);
        }
    }
}
