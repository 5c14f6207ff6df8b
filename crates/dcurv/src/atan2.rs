//! The arc tangent of a quotient, with the values that curvature wants for degenerate input.

/// The angle of the vector `(x, y)`, in radians, from -pi to pi.
///
/// Unlike [`f64::atan2`] it does not tell the two zeros apart: the angle of the zero vector is 0
/// and that of the negative x-axis is pi, whatever signs the zeros have.
#[inline]
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    // Adding zero turns -0 into +0.
    (y + 0.0).atan2(x + 0.0)
}
