//! Curvature and slope of one normal section at its origin.
//!
//! Curvature is positive if the section bends away from the normal.

use crate::params::SectionRule;
use crate::section::Section;

/// The curvature of a section at its origin.
pub(crate) fn section_curvature(rule: SectionRule, section: &Section) -> f64 {
    match rule {
        SectionRule::ThirdOrderChord => chord_sign(section) * third_order_chord(section),
        SectionRule::ExactChord => chord_sign(section) * exact_chord(section),
        SectionRule::ThreePointCircle => three_point_circle(section),
    }
}

/// The side of the origin on which the chord passes: 1 if below (convex), -1 if above (concave).
fn chord_sign(section: &Section) -> f64 {
    let Section { forward, backward, .. } = section;
    let height = backward.length * forward.y + forward.length * backward.y;
    if height == 0.0 { 0.0 } else { -height.signum() }
}

/// |κ| = √(24 (S - d) / S³): the chord of an arc of length S on a circle is
/// d = S - κ² S³ / 24 + O(κ⁴ S⁵).
fn third_order_chord(section: &Section) -> f64 {
    let length = section.length();
    if length == 0.0 {
        return 0.0;
    }
    (24.0 * (length - section.chord).max(0.0) / length).sqrt() / length
}

/// |κ| = 2X/S with sin X / X = d / S, by Newton's method from the inverted series of sin X / X.
fn exact_chord(section: &Section) -> f64 {
    let length = section.length();
    let ratio = section.chord / length;
    // A length of zero makes the ratio NaN, which also returns here.
    if !(0.0..1.0).contains(&ratio) {
        return 0.0;
    }
    let e = 6.0 * (1.0 - ratio);
    let mut half_angle = (e * (1.0 + e / 20.0 + 2.0 * e * e / 525.0)).sqrt();
    for _ in 0..50 {
        let (sin, cos) = half_angle.sin_cos();
        let step = (sin - ratio * half_angle) / (cos - ratio);
        half_angle = (half_angle - step).clamp(0.0, core::f64::consts::PI);
        if step.abs() <= 1e-15 * half_angle {
            break;
        }
    }
    2.0 * half_angle / length
}

/// Menger curvature: twice the sine of the angle at the origin, over the length of the chord.
fn three_point_circle(section: &Section) -> f64 {
    let Section { forward: p, backward: m, chord } = section;
    let sides = p.x.hypot(p.y) * m.x.hypot(m.y) * chord;
    if sides == 0.0 { 0.0 } else { -2.0 * (p.x * m.y - m.x * p.y) / sides }
}

/// The slope of a section at its origin against the tangent.
///
/// For two full arcs of equal length, this is the slope of the chord. Otherwise it is the slope of the
/// parabola through both ends and the origin.
pub(crate) fn section_slope(section: &Section) -> f64 {
    let Section { forward: p, backward: m, .. } = section;
    let are_full = p.cut_short.is_none() && m.cut_short.is_none();
    let (rise, run) = if are_full && p.length == m.length {
        (p.y - m.y, p.x - m.x)
    } else {
        (p.y * m.x * m.x - m.y * p.x * p.x, p.x * m.x * m.x - m.x * p.x * p.x)
    };
    if run == 0.0 { 0.0 } else { rise / run }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::PlaneArc;

    /// Two arcs of length `s` on a circle of curvature `k`, which is convex for positive `k`.
    fn circle(k: f64, s: f64) -> Section {
        let (x, y) = ((k * s).sin() / k, -(1.0 - (k * s).cos()) / k);
        let arc = |x| PlaneArc { x, y, length: s, cut_short: None };
        Section { forward: arc(x), backward: arc(-x), chord: 2.0 * x.abs() }
    }

    #[test]
    fn exact_rules_are_exact_on_circles() {
        for k in [-1.0, 1.0, 0.3, -0.01] {
            for s in [0.1, 0.5, 1.2] {
                let section = circle(k, s);
                let circle = section_curvature(SectionRule::ThreePointCircle, &section);
                assert!((circle - k).abs() < 1e-12, "{circle} {k}");
                let chord = section_curvature(SectionRule::ExactChord, &section);
                // The chord determines the curvature to half of the digits of S - d.
                assert!((chord - k).abs() < 1e-12 / (k * s * s).abs(), "{chord} {k} {s}");
            }
        }
    }

    #[test]
    fn third_order_bias_agrees_with_its_series() {
        for (a, ratio) in [(0.25, 0.998_439), (0.5, 0.993_768), (0.75, 0.986_027), (1.0, 0.975_282)]
        {
            let third = section_curvature(SectionRule::ThirdOrderChord, &circle(1.0, a));
            assert!((third - ratio).abs() < 1e-6, "{third} {ratio}");
            assert!((third - (1.0 - a * a / 40.0)).abs() < a.powi(4) / 1000.0);
        }
    }
}
