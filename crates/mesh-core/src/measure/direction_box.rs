//! Bounds for directions from a point to a triangle.

use glam::{DVec3, Vec3};

/// An axis-aligned box that contains unit vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DirectionBox {
    pub(crate) low: Vec3,
    pub(crate) high: Vec3,
}

/// An upper bound for the rounding error of a direction.
const ROUNDING: f64 = 1e-6;

impl DirectionBox {
    const ALL: Self = Self { low: Vec3::splat(-2.0), high: Vec3::splat(2.0) };

    /// The directions from a corner of a triangle to its other points.
    pub(crate) fn from_corner([a, b, c]: [DVec3; 3], corner: usize) -> Self {
        let (from, ends) = match corner {
            0 => (a, [b, c]),
            1 => (b, [c, a]),
            _ => (c, [a, b]),
        };
        let [Some(p), Some(q)] = ends.map(|end| direction(from, end)) else { return Self::ALL };
        // The distance of the arc from its chord is 1 - cos(angle / 2), which is less than this.
        let beyond = DVec3::splat(0.25 * p.distance_squared(q) + ROUNDING);
        let (low, high) = (p.min(q) - beyond, p.max(q) + beyond);
        Self { low: low.as_vec3(), high: high.as_vec3() }
    }

    pub(crate) fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub(crate) fn meet(self, other: Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    /// The largest dot product with a vector.
    fn reach(self, normal: DVec3) -> f64 {
        let [low, high] = [self.low, self.high].map(|end| end.as_dvec3() * normal);
        low.max(high).element_sum()
    }

    /// Whether no direction of the box points from `from` to the triangle: a plane through that point and a
    /// side of the triangle separates both.
    pub(crate) fn are_beside(self, from: DVec3, triangle: [DVec3; 3]) -> bool {
        // Rounding error of a product of three unit vectors.
        const ROUNDING: f64 = 1e-13;
        let [Some(a), Some(b), Some(c)] = triangle.map(|corner| direction(from, corner)) else {
            return false;
        };
        let normal = a.cross(b);
        let turn = normal.dot(c).signum();
        if normal.dot(c).abs() <= ROUNDING {
            return false;
        }
        let sides = [normal, b.cross(c), c.cross(a)];
        sides.into_iter().any(|normal| self.reach(turn * normal) < -ROUNDING)
    }
}

/// The unit vector from one point to another; `None` for equal points and on overflow.
fn direction(from: DVec3, to: DVec3) -> Option<DVec3> {
    let direction = (to - from).normalize();
    let error = (direction.length_squared() - 1.0).abs();
    (error < ROUNDING * ROUNDING).then_some(direction)
}
