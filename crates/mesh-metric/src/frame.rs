//! An exact change of coordinates before distances are measured.
//!
//! Far from the origin, coordinates have few digits after the point, and every computed point is rounded to them. With
//! very large or small coordinates, products of lengths overflow or vanish. So surfaces are shifted to the origin and
//! scaled to unit size, both without rounding.

use glam::DVec3;
use mesh_core::BoundingBox;

/// Surfaces whose largest coordinate is up to this multiple of their extent are not shifted.
const NEAR: f64 = 1_048_576.0;
/// Largest binary exponent of coordinates that are not scaled: products of four lengths must not overflow.
const LARGEST_EXPONENT: f64 = 200.0;

/// A shift along each axis, then a scaling by a power of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    origin: DVec3,
    factor: f64,
}

impl Frame {
    /// The frame for surfaces in two boxes; `None` if they can stay as they are.
    pub(crate) fn of(a: BoundingBox, b: BoundingBox) -> Option<Self> {
        let bounds = BoundingBox { min: a.min.min(b.min), max: a.max.max(b.max) };
        let is_far = largest(bounds.min, bounds.max) > NEAR * bounds.extent().max_element();
        let origin = if is_far { exact_origin(bounds) } else { DVec3::ZERO };
        let factor = unit_factor(largest(bounds.min - origin, bounds.max - origin));
        (factor != 1.0 || origin != DVec3::ZERO).then_some(Self { origin, factor })
    }

    /// The frame without a shift for a surface in a box; `None` if it can stay as it is.
    pub(crate) fn of_size(bounds: BoundingBox) -> Option<Self> {
        let factor = unit_factor(largest(bounds.min, bounds.max));
        (factor != 1.0).then_some(Self { origin: DVec3::ZERO, factor })
    }

    pub(crate) fn point(self, original: DVec3) -> DVec3 {
        (original - self.origin) * self.factor
    }

    pub(crate) fn points(self, originals: &[DVec3]) -> Vec<DVec3> {
        originals.iter().map(|&original| self.point(original)).collect()
    }

    pub(crate) fn length(self, original: f64) -> f64 {
        original * self.factor
    }

    pub(crate) fn original_point(self, placed: DVec3) -> DVec3 {
        placed / self.factor + self.origin
    }

    pub(crate) fn original_vector(self, placed: DVec3) -> DVec3 {
        placed / self.factor
    }

    pub(crate) fn original_length(self, placed: f64) -> f64 {
        placed / self.factor
    }
}

fn largest(min: DVec3, max: DVec3) -> f64 {
    min.abs().max(max.abs()).max_element()
}

/// The power of two that brings a size to between 1 and 2, or 1 for ordinary sizes.
fn unit_factor(size: f64) -> f64 {
    let exponent = size.log2().floor();
    let is_extreme = exponent.is_finite() && exponent.abs() > LARGEST_EXPONENT;
    if is_extreme { (-exponent).clamp(-1000.0, 1000.0).exp2() } else { 1.0 }
}

/// The corner of a box next to the origin, along each axis where no coordinate is more than twice another one. Such
/// differences are exact (Sterbenz 1974).
fn exact_origin(BoundingBox { min, max }: BoundingBox) -> DVec3 {
    let along = |min: f64, max: f64| match () {
        () if min > 0.0 && max <= 2.0 * min => min,
        () if max < 0.0 && min >= 2.0 * max => max,
        () => 0.0,
    };
    DVec3::new(along(min.x, max.x), along(min.y, max.y), along(min.z, max.z))
}
