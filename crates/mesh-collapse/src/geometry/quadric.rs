//! Quadrics: weighted sums of squared distances to planes, as functions of a point.

use core::ops::{Add, AddAssign, Mul};

use glam::DVec3;

use crate::geometry::symmetric::Symmetric3;

/// The function `x ↦ x·A x + 2 b·x + c` with a symmetric, positive semidefinite `A` (Garland and
/// Heckbert 1997).
///
/// `x` is measured from an origin that the caller chooses. It should be close to the points of interest, so that no
/// digits are lost far from the origin of the model. [`Quadric::moved_by`] changes the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Quadric {
    /// `A`.
    pub matrix: Symmetric3,
    /// `b`.
    pub linear: DVec3,
    /// `c`: the value at the origin.
    pub constant: f64,
}

/// Damping relative to the trace of `A`. It pulls the minimum towards the origin in directions in which the quadric is
/// constant, and moves it by a relative amount of 1e-9.
pub(crate) const DAMPING: f64 = 1e-9;

impl Quadric {
    /// `weight` times the squared distance to the plane `normal·x = offset`. The normal need not be a unit vector; the
    /// distance is scaled by its length.
    #[inline]
    #[must_use]
    pub fn plane(normal: DVec3, offset: f64, weight: f64) -> Self {
        Self {
            matrix: Symmetric3::square(normal, weight),
            linear: normal * (-offset * weight),
            constant: weight * offset * offset,
        }
    }

    /// The value at a point.
    #[inline]
    #[must_use]
    pub fn value(&self, x: DVec3) -> f64 {
        x.dot(self.matrix.times(x) + 2.0 * self.linear) + self.constant
    }

    /// The same function about another origin, at `shift` from the old one.
    #[inline]
    #[must_use]
    pub fn moved_by(&self, shift: DVec3) -> Self {
        Self {
            linear: self.linear + self.matrix.times(shift),
            constant: self.value(shift),
            ..*self
        }
    }

    /// The sum of this quadric and another one, about the point halfway between their origins. The origin of the other
    /// lies at 2 `half` from this one.
    #[inline]
    pub(crate) fn joined(&self, other: &Self, half: DVec3) -> Self {
        let mut matrix = self.matrix;
        matrix += other.matrix;
        let mut difference = self.matrix;
        difference += -1.0 * other.matrix;
        let slope = 2.0 * (self.linear - other.linear);
        Self {
            matrix,
            linear: self.linear + other.linear + difference.times(half),
            constant: self.constant + other.constant + half.dot(matrix.times(half) + slope),
        }
    }

    /// The point with the smallest value, within the plane `normal·x = offset` if given. In directions in which the
    /// quadric is constant, the point is as close to the origin as possible. `None` if the quadric is zero.
    #[inline]
    #[must_use]
    pub fn minimizer(&self, plane: Option<(DVec3, f64)>) -> Option<DVec3> {
        let factor = self.matrix.factors(DAMPING)?;
        let free = factor.solve(-self.linear);
        let Some((normal, offset)) = plane else { return Some(free) };
        let towards = factor.solve(normal);
        let slope = normal.dot(towards);
        let step = (offset - normal.dot(free)) / slope;
        Some(if step.is_finite() { free + step * towards } else { free })
    }
}

impl Add for Quadric {
    type Output = Self;

    #[inline]
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl AddAssign for Quadric {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.matrix += other.matrix;
        self.linear += other.linear;
        self.constant += other.constant;
    }
}

impl Mul<Quadric> for f64 {
    type Output = Quadric;

    #[inline]
    fn mul(self, q: Quadric) -> Quadric {
        Quadric { matrix: self * q.matrix, linear: self * q.linear, constant: self * q.constant }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Quadric {
        // Three oblique planes through (1, 2, 3).
        let at = DVec3::new(1.0, 2.0, 3.0);
        [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.3, -0.2, 1.0)]
            .into_iter()
            .map(|n| Quadric::plane(n, n.dot(at), 0.5))
            .fold(Quadric::default(), Quadric::add)
    }

    #[test]
    fn the_value_is_the_weighted_squared_distance() {
        let x = DVec3::new(0.3, -4.0, 2.0);
        let n = DVec3::new(2.0, -1.0, 2.0);
        let value = Quadric::plane(n, 5.0, 0.25).value(x);
        assert!((value - 0.25 * (n.dot(x) - 5.0).powi(2)).abs() < 1e-12);
    }

    #[test]
    fn three_planes_meet_at_the_minimizer() {
        let x = corner().minimizer(None).unwrap();
        assert!(x.distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-6, "{x}");
        let on_plane = corner().minimizer(Some((DVec3::Z, 4.0))).unwrap();
        assert!((on_plane.z - 4.0).abs() < 1e-12);
        // In the plane, the gradient is parallel to its normal.
        let gradient = corner().matrix.times(on_plane) + corner().linear;
        assert!(gradient.truncate().length() < 1e-7);
    }

    #[test]
    fn open_directions_stay_at_the_origin() {
        let flat = Quadric::plane(DVec3::Z, 2.0, 3.0);
        assert!(flat.minimizer(None).unwrap().distance(2.0 * DVec3::Z) < 1e-8);
        assert_eq!(Quadric::default().minimizer(None), None);
    }

    #[test]
    fn moving_the_origin_keeps_the_values() {
        let (shift, x) = (DVec3::new(0.2, 0.7, -3.0), DVec3::new(5.0, 1.0, 2.0));
        let moved = corner().moved_by(shift);
        assert!((moved.value(x - shift) - corner().value(x)).abs() < 1e-10);
        let other = Quadric::plane(DVec3::new(0.4, 2.0, -1.0), 0.3, 0.7);
        let joined = corner().joined(&other, shift);
        let apart = corner().value(x + shift) + other.value(x - shift);
        assert!((joined.value(x) - apart).abs() < 1e-10);
    }
}
