//! Slabs along bundles of long thin triangles: bounds that are tighter than boxes.
//!
//! The box of a long thin triangle is as wide as the triangle is long, so it meets the boxes of many others. Two
//! parallel planes along the triangles bound them better.

use glam::DVec3;

/// The region between two parallel planes. Its bounds include rounding errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slab {
    /// The unit normal of the planes. Zero for all of space.
    pub normal: DVec3,
    /// The least product of a point of the slab and the normal.
    pub low: f64,
    /// The largest product.
    pub high: f64,
}

impl Slab {
    /// Bound of the rounding error of a dot product with a unit vector, relative to the sum of coordinates.
    pub const ROUNDING: f64 = 8.0 * f64::EPSILON;

    /// The thinnest slab with this normal around some points.
    #[must_use]
    pub fn around(normal: DVec3, points: impl IntoIterator<Item = DVec3>) -> Self {
        let mut slab = Self { normal, low: f64::INFINITY, high: f64::NEG_INFINITY };
        slab.extend(points);
        slab
    }

    /// Moves the planes apart until the slab contains some points.
    pub(crate) fn extend(&mut self, points: impl IntoIterator<Item = DVec3>) {
        for point in points {
            let height = self.normal.dot(point);
            let rounding = Self::ROUNDING * point.abs().element_sum();
            self.low = self.low.min(height - rounding);
            self.high = self.high.max(height + rounding);
        }
    }

    /// Whether a plane between them separates the slab from some points.
    pub(crate) fn is_beside(&self, points: impl IntoIterator<Item = DVec3>) -> bool {
        let other = Self::around(self.normal, points);
        other.high < self.low || self.high < other.low
    }

    /// A unit vector across a triangle: in its plane, at a right angle to its longest side. Zero if there is none.
    #[must_use]
    pub fn across([a, b, c]: [DVec3; 3]) -> DVec3 {
        let longer =
            |p: DVec3, q: DVec3| if q.length_squared() > p.length_squared() { q } else { p };
        let side = longer(longer(b - a, c - b), a - c);
        (b - a).cross(c - a).normalize_or_zero().cross(side).normalize_or_zero()
    }
}
