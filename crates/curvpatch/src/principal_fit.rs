//! Principal curvatures and disc normal from the sections in several directions.

use glam::{DMat2, DMat3, DVec2, DVec3};

use crate::direction::Direction;
use crate::params::{Params, PrincipalRule};
use crate::section::Section;
use crate::section_curvature::{section_curvature, section_slope};

/// A section and its weight in least-squares fits.
pub(crate) type WeightedSection<'s> = (&'s Section, f64);

/// Principal curvatures, the larger one first, with the direction of the first one.
pub(crate) struct Principal {
    pub(crate) curvatures: [f64; 2],
    /// Cosine and sine of the angle of the first principal direction.
    pub(crate) cos_sin: DVec2,
}

impl Principal {
    /// Orders two curvatures, given with their directions. The first of equal ones stays first.
    pub(crate) fn ordered(first: (f64, DVec2), second: (f64, DVec2)) -> Self {
        let (max, min) = if second.0 > first.0 { (second, first) } else { (first, second) };
        Self { curvatures: [max.0, min.0], cos_sin: max.1 }
    }

    /// The principal curvatures by the rule of `params`. `None` if too few directions have a weight.
    pub(crate) fn of_sections<'s>(
        params: &Params,
        directions: &[Direction],
        sections: impl Iterator<Item = WeightedSection<'s>>,
    ) -> Option<Self> {
        let rows = sections
            .map(|(section, weight)| ([section_curvature(params.section, section)], weight));
        match params.principal {
            PrincipalRule::SignedExtremes => {
                signed_extremes(directions, rows.map(|([curvature], _)| curvature))
            }
            PrincipalRule::EulerFit => {
                let [fit] = euler_fit(directions, rows)?;
                let [min, max] = extremes(fit);
                Some(Self::ordered(min, max))
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
        let here = (curvature, direction.unit());
        let [min, max] = extremes.get_or_insert([here; 2]);
        if curvature < min.0 {
            *min = here;
        }
        if curvature > max.0 {
            *max = here;
        }
    }
    // The direction of the curvature with the larger absolute value is the measured one.
    extremes.map(|[min, max]| {
        let cos_sin = if min.0.abs() < max.0.abs() {
            max.1
        } else if min.0 < max.0 {
            // Orthogonal to the direction of the smallest curvature.
            DVec2::new(min.1.y, -min.1.x)
        } else {
            min.1
        };
        Principal { curvatures: [max.0, min.0], cos_sin }
    })
}

/// Weighted least squares for values v(φ) = p + q cos 2φ + r sin 2φ, for several values at once. Returns
/// (p, q, r). `None` if fewer than three directions have a positive weight.
fn euler_fit<const N: usize>(
    directions: &[Direction],
    rows: impl Iterator<Item = ([f64; N], f64)>,
) -> Option<[DVec3; N]> {
    let mut matrix = DMat3::ZERO;
    let mut right = [DVec3::ZERO; N];
    let mut usable = 0;
    for (direction, (values, weight)) in directions.iter().zip(rows) {
        if weight > 0.0 {
            usable += 1;
        }
        let row = DVec3::new(1.0, direction.cos_double, direction.sin_double);
        let weighted = weight * row;
        matrix += DMat3::from_cols(weighted, row.y * weighted, row.z * weighted);
        for (right, value) in right.iter_mut().zip(values) {
            *right += value * weighted;
        }
    }
    let solvable = usable >= 3 && matrix.determinant() > 1e-12 * matrix.x_axis.x.powi(3);
    solvable.then(|| {
        let inverse = matrix.inverse();
        right.map(|right| inverse * right)
    })
}

/// The smallest and the largest value of p + q cos 2φ + r sin 2φ, with their directions.
pub(crate) fn extremes(fit: DVec3) -> [(f64, DVec2); 2] {
    let amplitude = fit.y.hypot(fit.z);
    // The angle of the smallest value; 0 if all directions are equal. Rounding must not choose between
    // the two ends of the range of atan2, which are opposite directions.
    let sine = if fit.z.abs() > 1e-12 * amplitude { -fit.z } else { 0.0 };
    let angle = if amplitude > 0.0 { 0.5 * sine.atan2(-fit.y) } else { 0.0 };
    let (sin, cos) = angle.sin_cos();
    [(fit.x - amplitude, DVec2::new(cos, sin)), (fit.x + amplitude, DVec2::new(-sin, cos))]
}

/// The gradient g for which slope ≈ g · t holds in the least-squares sense, t being the direction of a
/// section. `None` if the sections do not determine g.
pub(crate) fn slope_gradient<'s>(
    directions: &[Direction],
    sections: impl Iterator<Item = WeightedSection<'s>>,
) -> Option<DVec2> {
    let mut matrix = DMat2::ZERO;
    let mut right = DVec2::ZERO;
    for (direction, (section, weight)) in directions.iter().zip(sections) {
        let row = direction.unit();
        matrix += DMat2::from_cols(weight * row.x * row, weight * row.y * row);
        right += weight * section_slope(section) * row;
    }
    let trace = matrix.x_axis.x + matrix.y_axis.y;
    let solvable = matrix.determinant() > 1e-9 * trace * trace;
    solvable.then(|| matrix.inverse() * right)
}
