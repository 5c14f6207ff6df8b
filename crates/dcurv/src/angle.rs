//! Corner angles of triangles and their sums.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};

use glam::{DVec2, DVec3};
use mesh_core::unit_sized;

use crate::atan2::atan2;

/// The interior angle of the triangle `(a, b, c)` at `a`, in radians, from 0 to pi.
///
/// The three angles of a triangle add up to pi, also in degenerate triangles: if two corners coincide,
/// their angles are right angles and the third is 0; if all three coincide, each angle is pi/3. So the
/// Gauss-Bonnet theorem holds on meshes with degenerate faces.
#[inline]
#[must_use]
pub fn corner_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (u, w) = (b - a, c - a);
    let (cosine, sine) = (u.dot(w), u.cross(w).length());
    let size = sine.max(cosine.abs());
    let is_ordinary = size > 1e-140 && size < 1e140;
    let corner = if is_ordinary { corner_direction(u, w, sine) } else { far_corner(u, w) };
    atan2(corner.y, corner.x)
}

/// [`corner_direction`] of sides whose products may overflow or vanish.
#[cold]
fn far_corner(u: DVec3, w: DVec3) -> DVec2 {
    let [u, w] = unit_sized([u, w]);
    corner_direction(u, w, u.cross(w).length())
}

/// The three interior angles of the triangle with the sides `u` and `w` from one corner, in radians: at
/// that corner, at the end of `u` and at the end of `w`. `cross` is the length of the cross product of
/// the sides.
///
/// Degenerate triangles as in [`corner_angle`]. The last angle is pi minus the other two. The code has no
/// branches, so that loops over triangles vectorise.
#[inline(always)]
#[must_use]
pub fn triangle_angles(u: DVec3, w: DVec3, cross: f64) -> [f64; 3] {
    let size = u.length_squared() + w.length_squared();
    let collapsed = if size > 0.0 { FRAC_PI_2 } else { FRAC_PI_3 };
    let first = angle_or(collapsed, u.dot(w), cross);
    let second = angle_or(collapsed, u.dot(u - w), cross);
    [first, second, PI - first - second]
}

/// The angle of a vector in the upper half-plane, or `collapsed` when it is zero.
#[inline(always)]
fn angle_or(collapsed: f64, x: f64, y: f64) -> f64 {
    let angle = atan2(y, x);
    if y + x.abs() > 0.0 { angle } else { collapsed }
}

/// A vector in the upper half-plane that makes the angle between `u` and `w` with the x-axis;
/// `cross` is the length of their cross product. For [`AngleSum`].
#[inline]
#[must_use]
pub(crate) fn corner_direction(u: DVec3, w: DVec3, cross: f64) -> DVec2 {
    let corner = DVec2::new(u.dot(w), cross);
    if corner == DVec2::ZERO { collapsed_corner(u, w) } else { corner }
}

/// The value of [`corner_direction`] for an edge without length.
#[cold]
pub(crate) fn collapsed_corner(u: DVec3, w: DVec3) -> DVec2 {
    if u == w { DVec2::new(0.5, 0.75_f64.sqrt()) } else { DVec2::Y }
}

/// The vector scaled by a power of two so that its longer coordinate is between 1 and 2. Exact: the angle
/// keeps its bits.
#[inline]
#[must_use]
pub(crate) fn unit_scaled(vector: DVec2) -> DVec2 {
    let (width, height) = (vector.x.abs(), vector.y.abs());
    let longer = if width < height { height } else { width };
    let exponent = longer.to_bits() >> 52;
    vector * f64::from_bits(2046_u64.wrapping_sub(exponent) << 52)
}

/// The power of two that scales a positive number to between 1 and 2, if it exists.
#[inline]
#[must_use]
pub(crate) fn unit_scale(size: f64) -> f64 {
    let exponent = size.to_bits() >> 52;
    f64::from_bits(2046_u64.saturating_sub(exponent).max(1) << 52)
}

/// A sum of angles between 0 and pi with a single arc tangent.
///
/// Products of complex numbers add angles. The product stays in the upper half-plane; half turns are
/// counted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AngleSum {
    /// The angle of this vector, from 0 to pi, is the sum modulo pi.
    direction: DVec2,
    half_turns: i32,
    terms: u32,
}

impl AngleSum {
    /// The empty sum.
    pub(crate) const ZERO: Self = Self { direction: DVec2::X, half_turns: 0, terms: 0 };

    /// Adds the angle of a vector in the upper half-plane, of [`unit_scaled`] length; see
    /// [`corner_direction`].
    #[inline(always)]
    pub(crate) fn add(&mut self, corner: DVec2) {
        let product = self.direction.rotate(corner);
        // In the lower half-plane: turn by pi. Unlike a comparison, the sign bit also distinguishes pi + pi, whose sine
        // is -0, from 0 + 0, whose sine is +0.
        let sign = product.y.to_bits() & (1 << 63);
        self.half_turns += i32::from(sign != 0);
        self.direction = DVec2::new(f64::from_bits(product.x.to_bits() ^ sign), product.y.abs());
        self.terms += 1;
        // Each term multiplies the length of the product by at most 2 sqrt(2).
        if self.terms.is_multiple_of(512) {
            self.direction = unit_scaled(self.direction);
        }
    }

    /// The sum, in radians.
    #[inline]
    #[must_use]
    pub(crate) fn radians(self) -> f64 {
        PI * f64::from(self.half_turns) + atan2(self.direction.y, self.direction.x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::SplitMix64;

    #[test]
    fn angles_of_degenerate_triangles_add_up_to_pi() {
        let [p, q, r] = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 6.0, 3.0), DVec3::ZERO];
        let half = DVec3::new(2.5, 4.0, 3.0);
        for [a, b, c] in [[p, p, p], [p, p, q], [p, q, p], [q, p, p], [p, half, q], [p, q, r]] {
            let angles = [corner_angle(a, b, c), corner_angle(b, c, a), corner_angle(c, a, b)];
            assert!((angles.iter().sum::<f64>() - PI).abs() < 1e-15, "{angles:?}");
            let (u, w) = (b - a, c - a);
            let together = triangle_angles(u, w, u.cross(w).length());
            assert!(together.iter().zip(angles).all(|(a, b)| (a - b).abs() < 1e-15));
        }
        assert_eq!(corner_angle(half, p, q), PI);
        assert_eq!(corner_angle(p, half, q), 0.0);
    }

    #[test]
    fn angle_sum_agrees_with_adding_the_angles() {
        let mut random = SplitMix64::new(7);
        for scale in [1e-40, 1.0, 1e40] {
            let (mut by_product, mut by_sum) = (AngleSum::ZERO, 0.0);
            for step in 0..2000 {
                let angle = match step % 4 {
                    0 => 1e-9 * random.uniform(),
                    1 => PI - 1e-9 * random.uniform(),
                    2 => PI,
                    _ => PI * random.uniform(),
                };
                let corner = scale * DVec2::new(angle.cos(), angle.sin().abs());
                by_product.add(unit_scaled(corner));
                by_sum += corner.y.atan2(corner.x);
                assert!((by_product.radians() - by_sum).abs() < 1e-12 * (1.0 + by_sum));
            }
        }
    }
}
