//! Principal curvatures and disc normal from the sections in several directions.

use glam::{DMat2, DMat3, DVec2, DVec3};

use crate::params::{Params, PrincipalRule};
use crate::section::Section;
use crate::section_curvature::{section_curvature, section_slope};

/// A direction of the tangent plane: cosine and sine of its angle and of the double angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Direction {
    pub(crate) cos: f64,
    pub(crate) sin: f64,
    cos_double: f64,
    sin_double: f64,
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
}

/// Principal curvatures, with the direction of the first one.
pub(crate) struct Principal {
    pub(crate) curvatures: [f64; 2],
    /// Cosine and sine of the angle of the first principal direction.
    pub(crate) cos_sin: DVec2,
}

impl Principal {
    /// Orders the smallest and the largest curvature by absolute value. If these are equal, the
    /// smallest curvature, which is the concave one, is first.
    fn ordered(min: (f64, DVec2), max: (f64, DVec2)) -> Self {
        let (first, second) = if min.0.abs() >= max.0.abs() { (min, max) } else { (max, min) };
        Self { curvatures: [first.0, second.0], cos_sin: first.1 }
    }

    /// The principal curvatures by the rule of `params`. `None` if too few directions have both arcs.
    pub(crate) fn of_sections(
        params: &Params,
        directions: &[Direction],
        sections: &[Section],
        radius: f64,
    ) -> Option<Self> {
        let curvatures = sections.iter().map(|section| section_curvature(params.section, section));
        match params.principal {
            PrincipalRule::SignedExtremes => signed_extremes(directions, curvatures),
            PrincipalRule::EulerFit => {
                let weights = sections.iter().map(|section| section.weight(radius));
                euler_fit(directions, curvatures.zip(weights))
            }
        }
    }
}

/// The smallest and the largest section curvature; the first of equal ones.
fn signed_extremes(
    directions: &[Direction],
    curvatures: impl Iterator<Item = f64>,
) -> Option<Principal> {
    let mut extremes: Option<[(f64, DVec2); 2]> = None;
    for (direction, curvature) in directions.iter().zip(curvatures) {
        let here = (curvature, DVec2::new(direction.cos, direction.sin));
        let [min, max] = extremes.get_or_insert([here; 2]);
        if curvature < min.0 {
            *min = here;
        }
        if curvature > max.0 {
            *max = here;
        }
    }
    extremes.map(|[min, max]| Principal::ordered(min, max))
}

/// Weighted least squares for κ(φ) = p + q cos 2φ + r sin 2φ. `None` if fewer than three directions
/// have a positive weight.
fn euler_fit(
    directions: &[Direction],
    weighted_curvatures: impl Iterator<Item = (f64, f64)>,
) -> Option<Principal> {
    let mut matrix = DMat3::ZERO;
    let mut right = DVec3::ZERO;
    let mut usable = 0;
    for (direction, (curvature, weight)) in directions.iter().zip(weighted_curvatures) {
        if weight > 0.0 {
            usable += 1;
        }
        let row = DVec3::new(1.0, direction.cos_double, direction.sin_double);
        let weighted = weight * row;
        matrix += DMat3::from_cols(weighted, row.y * weighted, row.z * weighted);
        right += curvature * weighted;
    }
    let solvable = usable >= 3 && matrix.determinant() > 1e-12 * matrix.x_axis.x.powi(3);
    let fit = solvable.then(|| matrix.inverse() * right)?;
    let amplitude = fit.y.hypot(fit.z);
    // The angle of the smallest curvature; 0 if all directions are equal. Rounding must not choose
    // between the two ends of the range of atan2, which are opposite directions.
    let sine = if fit.z.abs() > 1e-12 * amplitude { -fit.z } else { 0.0 };
    let angle = if amplitude > 0.0 { 0.5 * sine.atan2(-fit.y) } else { 0.0 };
    let (sin, cos) = angle.sin_cos();
    Some(Principal::ordered(
        (fit.x - amplitude, DVec2::new(cos, sin)),
        (fit.x + amplitude, DVec2::new(-sin, cos)),
    ))
}

/// The gradient g for which slope ≈ g · t holds in the least-squares sense, t being the direction of a
/// section. `None` if the sections do not determine g.
pub(crate) fn slope_gradient(
    directions: &[Direction],
    sections: &[Section],
    radius: f64,
) -> Option<DVec2> {
    let mut matrix = DMat2::ZERO;
    let mut right = DVec2::ZERO;
    for (direction, section) in directions.iter().zip(sections) {
        let weight = section.weight(radius);
        let row = DVec2::new(direction.cos, direction.sin);
        matrix += DMat2::from_cols(weight * row.x * row, weight * row.y * row);
        right += weight * section_slope(section) * row;
    }
    let trace = matrix.x_axis.x + matrix.y_axis.y;
    let solvable = matrix.determinant() > 1e-9 * trace * trace;
    solvable.then(|| matrix.inverse() * right)
}
