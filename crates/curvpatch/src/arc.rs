//! Circular arcs of any signed curvature, zero included: the arms of a patch.

/// Extent sin(ks) / k of an arc along its tangent, and its derivative cos(ks) by s.
///
/// `k` is the signed curvature, `s` the arc length. Even in k. The extent is s for k = 0.
pub(crate) fn reach(k: f64, s: f64) -> (f64, f64) {
    let angle = k * s;
    if angle.abs() < 1e-4 {
        let square = angle * angle;
        return (s * (1.0 - square / 6.0 * (1.0 - square / 20.0)), angle.cos());
    }
    let (sin, cos) = angle.sin_cos();
    (sin / k, cos)
}

/// Distance (1 - cos ks) / k of the end of an arc from its tangent. Odd in k.
pub(crate) fn sagitta(k: f64, s: f64) -> f64 {
    let half = 0.5 * k * s;
    let sinc = if half.abs() < 1e-4 { 1.0 - half * half / 6.0 } else { half.sin() / half };
    0.5 * k * s * s * sinc * sinc
}
