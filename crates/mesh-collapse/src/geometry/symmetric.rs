//! Symmetric 3 × 3 matrices.

use core::ops::{AddAssign, Mul};

use glam::DVec3;

/// A symmetric 3 × 3 matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Symmetric3 {
    /// The entries xx, yy, zz.
    pub diagonal: DVec3,
    /// The entries yz, zx, xy.
    pub mixed: DVec3,
}

impl Symmetric3 {
    /// `weight` times the outer product of a vector with itself.
    #[inline]
    #[must_use]
    pub fn square(v: DVec3, weight: f64) -> Self {
        let scaled = weight * v;
        Self {
            diagonal: scaled * v,
            mixed: DVec3::new(scaled.y * v.z, scaled.z * v.x, scaled.x * v.y),
        }
    }

    /// The matrix times a vector.
    #[inline]
    #[must_use]
    pub fn times(&self, x: DVec3) -> DVec3 {
        let Self { diagonal: d, mixed: m } = *self;
        DVec3::new(
            d.x * x.x + m.z * x.y + m.y * x.z,
            m.z * x.x + d.y * x.y + m.x * x.z,
            m.y * x.x + m.x * x.y + d.z * x.z,
        )
    }

    /// The factors `L D Lᵀ` of this positive semidefinite matrix, with `damping` times its trace added to the diagonal;
    /// `None` if the sum is not positive definite.
    #[inline]
    pub fn factors(&self, damping: f64) -> Option<Factors> {
        let damping = damping * self.diagonal.element_sum();
        let d = self.diagonal + damping;
        let m = self.mixed;
        let p0 = d.x;
        let (l10, l20) = (m.z / p0, m.y / p0);
        let p1 = d.y - l10 * m.z;
        let l21 = (m.x - l10 * m.y) / p1;
        let p2 = d.z - l20 * m.y - l21 * (m.x - l10 * m.y);
        // In exact arithmetic no pivot is below the damping.
        let sound = p0 > 0.0 && p1 > 0.25 * damping && p2 > 0.25 * damping;
        sound.then(|| Factors { inverse_pivots: DVec3::new(p0, p1, p2).recip(), l10, l20, l21 })
    }
}

impl AddAssign for Symmetric3 {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.diagonal += other.diagonal;
        self.mixed += other.mixed;
    }
}

impl Mul<Symmetric3> for f64 {
    type Output = Symmetric3;

    #[inline]
    fn mul(self, m: Symmetric3) -> Symmetric3 {
        Symmetric3 { diagonal: self * m.diagonal, mixed: self * m.mixed }
    }
}

/// A factored matrix, ready to solve equations.
#[derive(Clone, Copy, Debug)]
pub struct Factors {
    inverse_pivots: DVec3,
    l10: f64,
    l20: f64,
    l21: f64,
}

impl Factors {
    /// The solution of `A x = b`.
    #[inline]
    pub fn solve(&self, b: DVec3) -> DVec3 {
        let y1 = b.y - self.l10 * b.x;
        let y2 = b.z - self.l20 * b.x - self.l21 * y1;
        let y = DVec3::new(b.x, y1, y2) * self.inverse_pivots;
        let x1 = y.y - self.l21 * y.z;
        DVec3::new(y.x - self.l10 * x1 - self.l20 * y.z, x1, y.z)
    }
}
