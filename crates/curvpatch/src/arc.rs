//! The arms of a patch: circle arcs of any curvature, zero included.

/// How far an arc of signed curvature k and length s reaches along the tangent: sin(ks) / k, and
/// the derivative cos(ks). Even in k; s itself for k = 0.
pub(crate) fn reach(k: f64, s: f64) -> (f64, f64) {
    let angle = k * s;
    if angle.abs() < 1e-4 {
        let square = angle * angle;
        return (s * (1.0 - square / 6.0 * (1.0 - square / 20.0)), angle.cos());
    }
    let (sin, cos) = angle.sin_cos();
    (sin / k, cos)
}

/// How far it leaves the tangent on its own side: (1 - cos ks) / k. Odd in k.
pub(crate) fn sagitta(k: f64, s: f64) -> f64 {
    let half = 0.5 * k * s;
    let sinc = if half.abs() < 1e-4 { 1.0 - half * half / 6.0 } else { half.sin() / half };
    0.5 * k * s * s * sinc * sinc
}
