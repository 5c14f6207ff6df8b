//! Axis-aligned boxes.

use glam::DVec3;

use crate::measure::any_size::power_of_two;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoundingBox {
    /// The corner with the smallest coordinates.
    pub min: DVec3,
    /// The corner with the largest coordinates.
    pub max: DVec3,
}

impl BoundingBox {
    /// The smallest box that contains some points; `None` without points.
    #[must_use]
    pub fn of_points(points: impl IntoIterator<Item = DVec3>) -> Option<Self> {
        let start = |point| Self { min: point, max: point };
        points.into_iter().fold(None, |bounds, point| {
            Some(
                bounds.map_or(start(point), |b| Self {
                    min: b.min.min(point),
                    max: b.max.max(point),
                }),
            )
        })
    }

    /// The bounding box of a triangle.
    #[must_use]
    pub fn of_triangle([a, b, c]: [DVec3; 3]) -> Self {
        Self { min: a.min(b).min(c), max: a.max(b).max(c) }
    }

    /// Whether two boxes have a point in common.
    #[must_use]
    pub fn meets(&self, other: Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// The length of the diagonal.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        length(self.max - self.min)
    }

    /// The midpoint.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// The edge lengths.
    #[must_use]
    pub fn extent(&self) -> DVec3 {
        self.max - self.min
    }
}

/// The squared length at which the sum of squares neither overflows nor loses digits.
const EXACT_SQUARES: core::ops::Range<f64> = 1e-290..1e300;

/// The length of a vector of any size.
#[inline]
pub(crate) fn length(vector: DVec3) -> f64 {
    let squared = vector.length_squared();
    if EXACT_SQUARES.contains(&squared) { squared.sqrt() } else { length_by_parts(vector) }
}

#[cold]
fn length_by_parts(vector: DVec3) -> f64 {
    let largest = vector.abs().max_element();
    if largest > 0.0 && largest.is_finite() {
        let factor = power_of_two(largest);
        // Two factors: the reciprocal of the smallest numbers is infinite.
        (vector / factor).length() * factor
    } else {
        largest
    }
}
