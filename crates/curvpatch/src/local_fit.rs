//! The quadric through points of sections whose lengths differ.

use glam::{DMat2, DMat3, DVec2, DVec3};

use crate::direction::Direction;
use crate::local_section::{LocalSection, SectionPoint};
use crate::principal_fit::{Principal, extremes};

/// The least-squares fit of a surface to the points of all sections. For the depth h below the tangent plane at the
/// position x in the plane, the surface is
///
/// 2h = xᵀ E x + 2 g · x + κ₂ h² + (κ₁ - κ₂) c².
///
/// κ₁ is the eigenvalue of E with the larger absolute value, κ₂ is the other one, and c is the depth of the circle of
/// curvature κ₁ at the position along the direction of κ₁. Spheres and cylinders fulfil the equation exactly, tori
/// at their equators up to the fourth order in x.
///
/// The residual of a point counts in units of the squared intended length of its section: a point at half of the
/// length counts a sixteenth as much as the end. The fit needs no pairs of equal arcs, so a boundary close to the
/// point hardly matters.
pub(crate) struct LocalFit {
    /// E as (p, q, r): xᵀ E x = |x|² (p + q cos 2φ + r sin 2φ) in the direction φ.
    euler: DVec3,
    slope: DVec2,
}

/// The largest c/|x|, so that the iteration converges. An arc that turns by 75° ends at such a point.
const MAX_SLOPE: f64 = 1.0;

/// Steps of the iteration for the last two terms. A step multiplies their error by a mean of h²/|x|², which is
/// below 0.6 where arcs turn by at most 75°.
const STEPS: usize = 10;

/// The relative change of E at which the iteration ends.
const TOLERANCE: f64 = 1e-4;

/// The largest relative change of E in the last step. It is larger where the points hardly determine the fit, as at the
/// corner of a boundary, and the iteration does not converge.
const MAX_LAST_CHANGE: f64 = 0.02;

impl LocalFit {
    /// The fit to the points of the sections in `directions`. `None` if the points do not determine it, or hardly.
    pub(crate) fn new(directions: &[Direction], sections: &[LocalSection]) -> Option<Self> {
        let rows = directions.iter().zip(sections).flat_map(|(direction, section)| {
            let is_beyond_first_face = |point: &&SectionPoint| point.along != 0.0;
            let points = section.points.iter().filter(is_beyond_first_face);
            points.map(|point| Row::new(direction, point, section.intended.recip()))
        });
        let mut rows: Vec<Row> = rows.collect();
        // The unknown slope has the unit of E, so that neither over- nor underflows.
        let unit = rows.iter().map(|row| row.unit).fold(0.0, f64::max);
        rows.iter_mut().for_each(|row| row.linear *= row.unit / unit);
        let equations = NormalEquations::new(&rows)?;
        let mut fit = equations.solve(&rows, |row| 2.0 * row.depth * row.unit);
        let mut change = f64::INFINITY;
        for _ in 0..STEPS {
            let [min, max] = extremes(fit.euler);
            let [(first, axis), (second, _)] =
                if min.0.abs() > max.0.abs() { [min, max] } else { [max, min] };
            let next = equations.solve(&rows, |row| {
                let limit = MAX_SLOPE * row.at.length();
                let across = row.at.perp_dot(axis);
                let bend = row.depth - 0.5 * second / row.unit * across * across;
                let bend = bend.clamp(-limit, limit);
                let squares = second * row.depth * row.depth + (first - second) * bend * bend;
                2.0 * row.depth * row.unit - squares
            });
            if !(next.euler.is_finite() && next.slope.is_finite()) {
                return None;
            }
            let difference = (next.euler - fit.euler).abs().max_element();
            let size = next.euler.abs().max_element();
            fit = next;
            change = if difference > 0.0 { difference / size } else { 0.0 };
            if change <= TOLERANCE {
                break;
            }
        }
        fit.slope /= unit;
        (change <= MAX_LAST_CHANGE).then_some(fit)
    }

    /// The gradient of the surface over the plane of the sections.
    pub(crate) fn gradient(&self) -> DVec2 {
        -self.slope
    }

    /// The principal curvatures with their directions in the plane of the sections.
    pub(crate) fn curvatures(&self) -> [(f64, DVec2); 2] {
        extremes(self.euler)
    }

    /// The principal curvatures.
    pub(crate) fn principal(&self) -> Principal {
        let [min, max] = self.curvatures();
        Principal::ordered(min, max)
    }
}

/// The equation of a point. Lengths are in units of the intended length of its section.
struct Row {
    at: DVec2,
    depth: f64,
    /// The inverse of the intended length.
    unit: f64,
    /// The coefficients of E and g.
    quadratic: DVec3,
    linear: DVec2,
}

impl Row {
    fn new(direction: &Direction, point: &SectionPoint, unit: f64) -> Self {
        let at = point.along * direction.unit();
        let euler = DVec3::new(1.0, direction.cos_double, direction.sin_double);
        Self {
            at,
            depth: point.depth,
            unit,
            quadratic: point.along * point.along * euler,
            linear: 2.0 * at,
        }
    }
}

/// The matrix of the least-squares problem, with the slope eliminated.
struct NormalEquations {
    inverse: DMat3,
    inverse_slopes: DMat2,
    mixed: [DVec3; 2],
    eliminated: [DVec3; 2],
}

impl NormalEquations {
    fn new(rows: &[Row]) -> Option<Self> {
        let mut squares = DMat3::ZERO;
        let mut mixed = [DVec3::ZERO; 2];
        let mut slopes = DMat2::ZERO;
        for &Row { quadratic, linear, .. } in rows {
            squares += outer(quadratic, quadratic);
            mixed[0] += linear.x * quadratic;
            mixed[1] += linear.y * quadratic;
            slopes += DMat2::from_cols(linear.x * linear, linear.y * linear);
        }
        let trace = slopes.x_axis.x + slopes.y_axis.y;
        let is_determined = slopes.determinant() > 1e-9 * trace * trace;
        let inverse_slopes = is_determined.then(|| slopes.inverse())?;
        let eliminated = [inverse_slopes.x_axis, inverse_slopes.y_axis]
            .map(|row| row.x * mixed[0] + row.y * mixed[1]);
        let reduced = squares - outer(eliminated[0], mixed[0]) - outer(eliminated[1], mixed[1]);
        let is_determined = reduced.determinant() > 1e-9 * squares.x_axis.x.powi(3);
        let inverse = is_determined.then(|| reduced.inverse())?;
        Some(Self { inverse, inverse_slopes, mixed, eliminated })
    }

    /// The fit for the right-hand sides of all rows.
    fn solve(&self, rows: &[Row], right: impl Fn(&Row) -> f64) -> LocalFit {
        let (mut of_euler, mut of_slope) = (DVec3::ZERO, DVec2::ZERO);
        for row in rows {
            let value = right(row);
            of_euler += value * row.quadratic;
            of_slope += value * row.linear;
        }
        let [first, second] = self.eliminated;
        let euler = self.inverse * (of_euler - of_slope.x * first - of_slope.y * second);
        let known = DVec2::new(self.mixed[0].dot(euler), self.mixed[1].dot(euler));
        LocalFit { euler, slope: self.inverse_slopes * (of_slope - known) }
    }
}

/// a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(b.x * a, b.y * a, b.z * a)
}
