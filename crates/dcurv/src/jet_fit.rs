//! Weighted least-squares fits of polynomial height functions (jets) of degree 2, 3 and 4 at once.
//!
//! The monomials are ordered by degree. So one factorisation has the fits of all degrees: a fit of lower degree uses
//! the leading part of the triangular factor.

use glam::DVec2;

use crate::height_points::HeightPoint;
use crate::principal::Jet;

/// Monomials of degree 0 to 4.
const MONOMIALS: usize = 15;

/// The monomials and the height.
const COLUMNS: usize = MONOMIALS + 1;

/// The degrees of fits, each with the number of its monomials.
const DEGREES: [(u8, usize); 3] = [(2, 6), (3, 10), (4, 15)];

/// Weights are the inverse of distance to this power. The squared error of a fit of degree `p` grows as distance to
/// the power `2p + 2`: from 6 to 10 for the degrees fitted here.
const POWER: i32 = 8;

type Row = [f64; COLUMNS];

/// A fitted jet and its uncertainty.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JetFit {
    pub(crate) jet: Jet,
    pub(crate) degree: u8,
    /// Number of points.
    pub(crate) points: usize,
    /// Variance of the second derivatives (squared Frobenius norm) for independent noise of variance 1 in all heights.
    pub(crate) noise_variance: f64,
    /// Variance of the second derivatives as the residuals tell, if residuals grow with distance. 0 for smoothing
    /// fits.
    pub(crate) model_variance: f64,
}

/// `1, x, y, x², xy, y², x³, ...`, then the height.
fn row(point: &HeightPoint, scale: f64) -> Row {
    let DVec2 { x, y } = point.at / scale;
    let (xx, xy, yy) = (x * x, x * y, y * y);
    let [c0, c1, c2, c3] = [xx * x, xx * y, x * yy, y * yy];
    let z = point.z / scale;
    [1.0, x, y, xx, xy, yy, c0, c1, c2, c3, c0 * x, c0 * y, xx * yy, x * c3, y * c3, z]
}

/// Memory of the fits.
#[derive(Default)]
pub(crate) struct JetSolver {
    rows: Vec<Row>,
    weights: Vec<f64>,
    eliminated: Vec<Row>,
}

/// An upper triangular factor of the matrix of a fit, its right side in the last column, and what the columns were
/// divided by.
struct Triangle {
    rows: [Row; MONOMIALS],
    lengths: Row,
    /// The first column: 1 for fits through the vertex, which have no constant.
    first: usize,
    /// The number of columns from 0 that are linearly independent.
    rank: usize,
}

impl Triangle {
    /// Coefficients of the leading `count` columns.
    fn solve(&self, count: usize) -> Row {
        self.back_substituted(count, |k| self.rows[k][MONOMIALS])
    }

    /// Solves `R x = right side` for the leading columns.
    fn back_substituted(&self, count: usize, right: impl Fn(usize) -> f64) -> Row {
        let mut x = [0.0; COLUMNS];
        for k in (self.first..count).rev() {
            let known: f64 = (k + 1..count).map(|j| self.rows[k][j] * x[j]).sum();
            x[k] = (right(k) - known) / self.rows[k][k];
        }
        x
    }

    /// A column of the inverse of `Rᵀ`, for the leading columns: its squared length is the variance of the
    /// coefficient for residuals of variance 1.
    fn influence(&self, count: usize, column: usize) -> Row {
        let mut z = [0.0; COLUMNS];
        for k in column..count {
            let known: f64 = (column..k).map(|j| self.rows[j][k] * z[j]).sum();
            let unit = if k == column { 1.0 } else { 0.0 };
            z[k] = (unit - known) / self.rows[k][k];
        }
        z
    }

    /// The jet in units of length, from coefficients in units of `scale`.
    fn jet(&self, coefficients: &Row, scale: f64) -> Jet {
        let of = |k: usize| coefficients[k] / self.lengths[k];
        let [xx, xy, yy] = [3, 4, 5].map(|k| second_derivative(k) * of(k) / scale);
        Jet { px: of(1), py: of(2), xx, xy, yy }
    }
}

/// The second derivative of a quadratic monomial.
fn second_derivative(column: usize) -> f64 {
    if column == 4 { 1.0 } else { 2.0 }
}

/// How often the second derivative of a quadratic monomial is in the matrix of second derivatives.
fn multiplicity(column: usize) -> f64 {
    if column == 4 { 2.0 } else { 1.0 }
}

impl JetSolver {
    /// Fits through the vertex itself, with weights that grow without limit towards the vertex.
    ///
    /// If heights have no noise, the error of the model is all that there is. It grows with distance, so near points
    /// decide what they can, and far points only what is left: the few neighbours along a thin cylinder decide the
    /// curvature across, even if other neighbours are fifty times farther away.
    ///
    /// Householder's factorisation, because the weights have a large range.
    pub(crate) fn through_vertex(&mut self, points: &[HeightPoint], fits: &mut Vec<JetFit>) {
        fits.clear();
        let Some(scale) = self.weigh(points) else { return };
        let Some(triangle) = self.eliminate(1) else { return };
        for (degree, count) in DEGREES {
            let unknowns = count - 1;
            if triangle.rank < count || points.len() <= unknowns {
                break;
            }
            let rest = self.eliminated.get(unknowns..).unwrap_or_default();
            let squares: f64 = rest.iter().map(|row| row[MONOMIALS] * row[MONOMIALS]).sum();
            // Right sides of the columns that this degree does not have are residuals, too.
            let residual_variance = squares / (points.len() - unknowns) as f64;
            let (mut noise_variance, mut model_variance) = (0.0, 0.0);
            for column in [3, 4, 5] {
                let factor = second_derivative(column) / (triangle.lengths[column] * scale);
                let weight = multiplicity(column) * factor * factor;
                let influence = triangle.influence(count, column);
                model_variance += weight * influence.iter().map(|z| z * z).sum::<f64>();
                let solved = triangle.back_substituted(count, |k| influence[k]);
                let (mut squares, mut sum) = (0.0, 0.0);
                for influence in self.of_heights(count, &solved) {
                    squares += influence * influence;
                    sum += influence;
                }
                // Heights are measured from the vertex, so its noise is in all of them.
                noise_variance += weight * (squares + sum * sum) / (scale * scale);
            }
            fits.push(JetFit {
                jet: triangle.jet(&triangle.solve(count), scale),
                degree,
                points: points.len(),
                noise_variance,
                model_variance: model_variance * residual_variance,
            });
        }
        fits.retain(JetFit::is_finite);
    }

    /// Sets the rows of points, with weights that grow without limit towards the vertex. Returns the unit of length, the
    /// distance of the farthest point; `None` without points.
    fn weigh(&mut self, points: &[HeightPoint]) -> Option<f64> {
        let scale = points.last()?.at.length();
        self.weights.clear();
        self.weights.extend(points.iter().map(|point| {
            let relative = point.at.length_squared() / (scale * scale);
            relative.powi(POWER / 2).sqrt().recip()
        }));
        self.rows.clear();
        for (point, weight) in points.iter().zip(&self.weights) {
            self.rows.push(row(point, scale).map(|entry| entry * weight));
        }
        Some(scale)
    }

    /// How much a coefficient changes with the height of each point. `solved` is the row of the coefficient in the
    /// inverse of the normal equations.
    fn of_heights(&self, count: usize, solved: &Row) -> impl Iterator<Item = f64> {
        let of_height =
            move |(row, w): (&Row, &f64)| w * (0..count).map(|k| row[k] * solved[k]).sum::<f64>();
        self.rows.iter().zip(&self.weights).map(of_height)
    }

    /// Divides the columns of `rows` by their lengths, and triangulates them by Householder's reflections. `None` if
    /// a column is zero.
    fn eliminate(&mut self, first: usize) -> Option<Triangle> {
        let mut lengths = [1.0; COLUMNS];
        for (k, length) in lengths.iter_mut().enumerate().take(MONOMIALS).skip(first) {
            *length = self.rows.iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt();
            if !(*length > 0.0 && length.is_finite()) {
                return None;
            }
        }
        for row in &mut self.rows {
            for (entry, length) in row.iter_mut().zip(lengths) {
                *entry /= length;
            }
        }
        self.eliminated.clear();
        self.eliminated.extend_from_slice(&self.rows);
        let mut triangle =
            Triangle { rows: [[0.0; COLUMNS]; MONOMIALS], lengths, first, rank: MONOMIALS };
        for k in first..MONOMIALS {
            let Some(below) = self.eliminated.get_mut(k - first..).filter(|rows| !rows.is_empty())
            else {
                triangle.rank = k;
                break;
            };
            let length = below.iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt();
            if length <= 1e-9 {
                triangle.rank = k;
                break;
            }
            let diagonal = if below[0][k] > 0.0 { -length } else { length };
            let half_square = -diagonal * (below[0][k] - diagonal);
            let mut projections = [0.0; COLUMNS];
            let reflected = |i: usize, row: &Row| if i == 0 { row[k] - diagonal } else { row[k] };
            for (i, row) in below.iter().enumerate() {
                let v = reflected(i, row) / half_square;
                for (projection, entry) in projections.iter_mut().zip(row) {
                    *projection += v * entry;
                }
            }
            for (i, row) in below.iter_mut().enumerate() {
                let v = reflected(i, row);
                for (entry, projection) in row.iter_mut().zip(projections) {
                    *entry -= v * projection;
                }
            }
            triangle.rows[k] = below[0];
        }
        Some(triangle)
    }

    /// Adds fits that smooth within about `radius`: with weights `1 / (1 + (distance / radius)^8)`, a free constant,
    /// and the vertex as a point like the others.
    ///
    /// Cholesky's factorisation of the normal equations, because the weights have a small range.
    pub(crate) fn smoothing(
        &mut self,
        points: &[HeightPoint],
        radius: f64,
        fits: &mut Vec<JetFit>,
    ) {
        const LEAST_WEIGHT: f64 = 1e-7;
        let mut normal = [[0.0; COLUMNS]; COLUMNS];
        let vertex = HeightPoint { at: DVec2::ZERO, z: 0.0 };
        self.rows.clear();
        self.weights.clear();
        for point in core::iter::once(&vertex).chain(points) {
            let relative = point.at.length_squared() / (radius * radius);
            let weight = (1.0 + relative.powi(POWER / 2)).recip();
            if weight < LEAST_WEIGHT && self.rows.len() > MONOMIALS {
                break;
            }
            let row = row(point, radius);
            for (i, entries) in normal.iter_mut().enumerate().take(MONOMIALS) {
                let weighted = weight * row[i];
                for (entry, other) in entries[i..].iter_mut().zip(&row[i..]) {
                    *entry += weighted * other;
                }
            }
            self.rows.push(row);
            self.weights.push(weight);
        }
        let used = self.rows.len();
        let Some(triangle) = cholesky(&normal) else { return };
        for (degree, count) in DEGREES {
            if triangle.rank < count || used < count + 2 {
                break;
            }
            let mut noise_variance = 0.0;
            for column in [3, 4, 5] {
                let factor = second_derivative(column) / (triangle.lengths[column] * radius);
                let influence = triangle.influence(count, column);
                let mut solved = triangle.back_substituted(count, |k| influence[k]);
                for (entry, length) in solved.iter_mut().zip(triangle.lengths) {
                    *entry /= length;
                }
                let variance: f64 = self.of_heights(count, &solved).map(|l| l * l).sum();
                noise_variance +=
                    multiplicity(column) * factor * factor * variance / (radius * radius);
            }
            let fit = JetFit {
                jet: triangle.jet(&triangle.solve(count), radius),
                degree,
                points: used - 1,
                noise_variance,
                model_variance: 0.0,
            };
            if fit.is_finite() {
                fits.push(fit);
            }
        }
    }

    /// The difference between the vertex and a surface of degree 4 or less, fitted to the points around it, in
    /// standard deviations of noise 1. `None` where there are too few points.
    pub(crate) fn prediction_error(&mut self, points: &[HeightPoint], degree: u8) -> Option<f64> {
        let (_, count) = DEGREES.into_iter().find(|entry| entry.0 == degree)?;
        if points.len() < count + 2 {
            return None;
        }
        let scale = self.weigh(points)?;
        let triangle = self.eliminate(0).filter(|triangle| triangle.rank >= count)?;
        let constant = triangle.solve(count)[0] / triangle.lengths[0] * scale;
        let influence = triangle.influence(count, 0);
        let solved = triangle.back_substituted(count, |k| influence[k]);
        let of_heights = self.of_heights(count, &solved).map(|l| l / triangle.lengths[0]);
        let squares: f64 = of_heights.map(|l| l * l).sum();
        let error = constant.abs() / (1.0 + squares).sqrt();
        error.is_finite().then_some(error)
    }
}

impl JetFit {
    fn is_finite(&self) -> bool {
        let Jet { px, py, xx, xy, yy } = self.jet;
        let entries = [px, py, xx, xy, yy, self.noise_variance, self.model_variance];
        entries.iter().all(|entry| entry.is_finite())
    }
}

/// The triangular factor of normal equations. `None` if a monomial is zero everywhere.
fn cholesky(normal: &[Row; COLUMNS]) -> Option<Triangle> {
    let mut lengths = [1.0; COLUMNS];
    for k in 0..MONOMIALS {
        lengths[k] = normal[k][k].sqrt();
        if !(lengths[k] > 0.0 && lengths[k].is_finite()) {
            return None;
        }
    }
    let mut triangle =
        Triangle { rows: [[0.0; COLUMNS]; MONOMIALS], lengths, first: 0, rank: MONOMIALS };
    for k in 0..MONOMIALS {
        for j in k..COLUMNS {
            let entry = normal[k][j] / (lengths[k] * lengths[j]);
            let known: f64 = (0..k).map(|i| triangle.rows[i][k] * triangle.rows[i][j]).sum();
            let rest = entry - known;
            if j > k {
                triangle.rows[k][j] = rest / triangle.rows[k][k];
            } else if rest > 1e-10 {
                triangle.rows[k][k] = rest.sqrt();
            } else {
                triangle.rank = k;
                return Some(triangle);
            }
        }
    }
    Some(triangle)
}
