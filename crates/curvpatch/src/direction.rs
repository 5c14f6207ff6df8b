//! Directions of a tangent plane.

use glam::DVec2;

/// A direction: cosine and sine of its angle and of the double angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Direction {
    pub(crate) cos: f64,
    pub(crate) sin: f64,
    pub(crate) cos_double: f64,
    pub(crate) sin_double: f64,
}

impl Direction {
    /// Directions evenly spaced over half a turn.
    pub(crate) fn evenly_spaced(count: u16) -> Vec<Self> {
        let direction = |i: u16| {
            let angle = core::f64::consts::PI * f64::from(i) / f64::from(count);
            let (sin, cos) = angle.sin_cos();
            let (sin_double, cos_double) = (2.0 * angle).sin_cos();
            Self { cos, sin, cos_double, sin_double }
        };
        (0..count).map(direction).collect()
    }

    /// The direction as a unit vector.
    pub(crate) fn unit(&self) -> DVec2 {
        DVec2::new(self.cos, self.sin)
    }
}
