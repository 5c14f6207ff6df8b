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

/// The columns of `x²`, `xy` and `y²`.
const QUADRATIC: [usize; 3] = [3, 4, 5];

/// The largest factor by which the monomials of third and fourth degree may increase the standard deviations of the
/// quadratic coefficients.
///
/// Around a prism of nine sides, only three columns of vertices are near enough. There, `x²` and `x⁴` differ by little
/// but the places in the columns, and a fit of fourth degree finds 1.9 for the curvature 1. The factor is 1,000 and
/// more there, and below 10 on surfaces with enough vertices in all directions.
const MOST_AMPLIFICATION: f64 = 30.0;

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
    /// Covariance of the second derivatives for independent noise of variance 1 in all heights.
    pub(crate) noise: Covariance,
    /// Covariance of the second derivatives as the residuals tell, if residuals grow with distance. 0 for smoothing
    /// fits.
    pub(crate) model: Covariance,
}

/// The covariance of the second derivatives by `xx`, `xy` and `yy`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Covariance(pub(crate) [[f64; 3]; 3]);

impl Covariance {
    fn of(entry: impl Fn(usize, usize) -> f64) -> Self {
        Self(core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j))))
    }

    /// The variance of the matrix of second derivatives: the mean square of its Frobenius norm.
    pub(crate) fn total(&self) -> f64 {
        (0..3).map(|i| multiplicity(QUADRATIC[i]) * self.0[i][i]).sum()
    }

    /// The covariance of the sum of both errors, each multiplied by a factor.
    pub(crate) fn combined(&self, factor: f64, other: &Self, other_factor: f64) -> Self {
        let [square, other_square] = [factor * factor, other_factor * other_factor];
        Self::of(|i, j| square * self.0[i][j] + other_square * other.0[i][j])
    }

    /// The length of a difference of second derivatives in standard deviations. Infinite if a nonzero difference has
    /// no variance.
    pub(crate) fn deviations(&self, difference: [f64; 3]) -> f64 {
        /// The part of a variance that others do not explain and that still counts.
        const LEAST_REST: f64 = 1e-12;
        let ratio = |rest: f64, root: f64| if rest == 0.0 { 0.0 } else { rest / root };
        let mut triangle = [[0.0; 3]; 3];
        let mut solved = [0.0; 3];
        for i in 0..3 {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| triangle[i][k] * triangle[j][k]).sum();
                let rest = self.0[i][j] - known;
                if j < i {
                    triangle[i][j] = ratio(rest, triangle[j][j]);
                } else {
                    triangle[i][i] = rest.max(LEAST_REST * self.0[i][i]).sqrt();
                }
            }
            let known: f64 = (0..i).map(|k| triangle[i][k] * solved[k]).sum();
            solved[i] = ratio(difference[i] - known, triangle[i][i]);
        }
        let square: f64 = solved.iter().map(|entry| entry * entry).sum();
        if square.is_nan() { f64::INFINITY } else { square.sqrt() }
    }
}

/// `1, x, y, x², xy, y², x³, ...`, then the height.
fn row(point: &HeightPoint, scale: f64) -> Row {
    let DVec2 { x, y } = point.at / scale;
    let (xx, xy, yy) = (x * x, x * y, y * y);
    let [c0, c1, c2, c3] = [xx * x, xx * y, x * yy, y * yy];
    let z = point.z / scale;
    [1.0, x, y, xx, xy, yy, c0, c1, c2, c3, c0 * x, c0 * y, xx * yy, x * c3, y * c3, z]
}

/// The square root of the weight `1/distance^8`, for distances in units of `scale`.
pub(crate) fn near_weight(point: &HeightPoint, scale: f64) -> f64 {
    (point.at.length_squared() / (scale * scale)).powi(POWER / 2).sqrt().recip()
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

    /// Columns of the inverse of `Rᵀ` for the quadratic monomials, as far as the rank goes. The squared length of the
    /// first `count` entries is the variance of the coefficient in a fit of `count` columns, for residuals of
    /// variance 1.
    fn influences(&self) -> [Row; 3] {
        let mut columns = [[0.0; COLUMNS]; 3];
        for k in QUADRATIC[0]..self.rank {
            let mut known = [0.0; 3];
            for j in QUADRATIC[0]..k {
                for (known, column) in known.iter_mut().zip(&columns) {
                    *known += self.rows[j][k] * column[j];
                }
            }
            for ((column, known), unit) in columns.iter_mut().zip(known).zip(QUADRATIC) {
                let unit = if k == unit { 1.0 } else { 0.0 };
                column[k] = (unit - known) / self.rows[k][k];
            }
        }
        columns
    }

    /// Whether the points determine the quadratic coefficients in a fit of the first `count` columns.
    fn determines(&self, influences: &[Row; 3], count: usize) -> bool {
        let limit = MOST_AMPLIFICATION * MOST_AMPLIFICATION;
        let is_known = |row: &Row| square(row, count) <= limit * square(row, DEGREES[0].1);
        self.rank >= count && influences.iter().all(is_known)
    }

    /// The jet in units of length, from coefficients in units of `scale`.
    fn jet(&self, coefficients: &Row, scale: f64) -> Jet {
        let of = |k: usize| coefficients[k] / self.lengths[k];
        let [xx, xy, yy] = QUADRATIC.map(|k| second_derivative(k) * of(k) / scale);
        Jet { px: of(1), py: of(2), xx, xy, yy }
    }
}

/// The squared length of the leading part.
fn square(row: &Row, count: usize) -> f64 {
    row.iter().take(count).map(|entry| entry * entry).sum()
}

/// The scalar product of the leading parts.
fn product(a: &Row, b: &Row, count: usize) -> f64 {
    a.iter().zip(b).take(count).map(|(a, b)| a * b).sum()
}

/// The scalar product, in four interleaved sums, so that several products are computed at once.
fn dot(a: &Row, b: &Row) -> f64 {
    let mut sums = [0.0; 4];
    for (a, b) in a.as_chunks::<4>().0.iter().zip(b.as_chunks::<4>().0) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
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
        let Some(triangle) = self.eliminate() else { return };
        let influences = triangle.influences();
        for (degree, count) in DEGREES {
            let unknowns = count - 1;
            if points.len() <= unknowns || !triangle.determines(&influences, count) {
                break;
            }
            let rest = self.eliminated.get(unknowns..).unwrap_or_default();
            let squares: f64 = rest.iter().map(|row| row[MONOMIALS] * row[MONOMIALS]).sum();
            // Right sides of the columns that this degree does not have are residuals, too.
            let residual_variance = squares / (points.len() - unknowns) as f64;
            let factors = QUADRATIC
                .map(|column| second_derivative(column) / (triangle.lengths[column] * scale));
            let model = Covariance::of(|i, j| {
                let share = product(&influences[i], &influences[j], count);
                factors[i] * factors[j] * share * residual_variance
            });
            let solved =
                influences.map(|influence| triangle.back_substituted(count, |k| influence[k]));
            let noise = self.noise(count, &solved);
            let noise =
                Covariance::of(|i, j| factors[i] * factors[j] * noise.0[i][j] / (scale * scale));
            fits.push(JetFit {
                jet: triangle.jet(&triangle.solve(count), scale),
                degree,
                points: points.len(),
                noise,
                model,
            });
        }
        fits.retain(JetFit::is_finite);
    }

    /// Sets the rows of points, with weights that grow without limit towards the vertex. Returns the unit of length, the
    /// distance of the farthest point; `None` without points.
    fn weigh(&mut self, points: &[HeightPoint]) -> Option<f64> {
        let scale = points.last()?.at.length();
        self.weights.clear();
        self.weights.extend(points.iter().map(|point| near_weight(point, scale)));
        self.rows.clear();
        for (point, weight) in points.iter().zip(&self.weights) {
            self.rows.push(row(point, scale).map(|entry| entry * weight));
        }
        Some(scale)
    }

    /// The covariance of the quadratic coefficients for noise of variance 1 in the heights. `solved` are the rows of
    /// the coefficients in the inverse of the normal equations.
    fn noise(&self, count: usize, solved: &[Row; 3]) -> Covariance {
        let used = solved.map(|mut row| {
            row[count..].fill(0.0);
            row
        });
        let (mut products, mut sums) = ([[0.0; 3]; 3], [0.0; 3]);
        for (row, weight) in self.rows.iter().zip(&self.weights) {
            let of_height = [0, 1, 2].map(|i| weight * dot(row, &used[i]));
            for i in 0..3 {
                sums[i] += of_height[i];
                for j in 0..3 {
                    products[i][j] += of_height[i] * of_height[j];
                }
            }
        }
        // Heights are measured from the vertex, so its noise is in all of them.
        Covariance::of(|i, j| products[i][j] + sums[i] * sums[j])
    }

    /// Divides the columns of `rows` but the constant by their lengths, and triangulates them by Householder's
    /// reflections. `None` if a column is zero.
    fn eliminate(&mut self) -> Option<Triangle> {
        let first = 1;
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
    /// Cholesky's factorisation of the normal equations, because the weights have a small range. The noise variance is
    /// an upper bound. It is exact if the noise variance of each point is the inverse of its weight, which is at most 1.
    pub(crate) fn smoothing(
        &mut self,
        points: &[HeightPoint],
        radius: f64,
        fits: &mut Vec<JetFit>,
    ) {
        const LEAST_WEIGHT: f64 = 1e-7;
        let mut moments = Moments::default();
        moments.add(&HeightPoint { at: DVec2::ZERO, z: 0.0 }, 1.0, radius);
        let mut used = 1;
        for point in points {
            let relative = point.at.length_squared() / (radius * radius);
            let weight = (1.0 + relative.powi(POWER / 2)).recip();
            if weight < LEAST_WEIGHT && used > MONOMIALS {
                break;
            }
            moments.add(point, weight, radius);
            used += 1;
        }
        let Some(triangle) = cholesky(&moments.normal_equations()) else { return };
        let influences = triangle.influences();
        for (degree, count) in DEGREES {
            if used < count + 2 || !triangle.determines(&influences, count) {
                break;
            }
            let factors = QUADRATIC
                .map(|column| second_derivative(column) / (triangle.lengths[column] * radius));
            let noise = Covariance::of(|i, j| {
                let share = product(&influences[i], &influences[j], count);
                factors[i] * factors[j] * share / (radius * radius)
            });
            let fit = JetFit {
                jet: triangle.jet(&triangle.solve(count), radius),
                degree,
                points: used - 1,
                noise,
                model: Covariance::default(),
            };
            if fit.is_finite() {
                fits.push(fit);
            }
        }
    }
}

impl JetFit {
    fn is_finite(&self) -> bool {
        let Jet { px, py, xx, xy, yy } = self.jet;
        let entries = [px, py, xx, xy, yy].into_iter();
        let variances = [self.noise, self.model].into_iter().flat_map(|of| of.0).flatten();
        entries.chain(variances).all(f64::is_finite)
    }
}

/// Weighted sums of products of monomials: each entry of the normal equations is one of them.
#[derive(Default)]
struct Moments {
    /// Of `x^i y^j` in row `j`, column `i`. The last columns only fill whole vectors.
    powers: [[f64; 10]; 9],
    /// Of the height and each monomial.
    heights: Row,
}

impl Moments {
    fn add(&mut self, point: &HeightPoint, weight: f64, scale: f64) {
        let DVec2 { x, y } = point.at / scale;
        let mut powers = [1.0; 10];
        for i in 1..powers.len() {
            powers[i] = powers[i - 1] * x;
        }
        let mut factor = weight;
        for sums in &mut self.powers {
            for (sum, power) in sums.iter_mut().zip(powers) {
                *sum += factor * power;
            }
            factor *= y;
        }
        let height = weight * point.z / scale;
        for (sum, monomial) in self.heights.iter_mut().zip(row(point, scale)) {
            *sum += height * monomial;
        }
    }

    fn normal_equations(&self) -> [Row; COLUMNS] {
        /// Exponents of the monomials.
        const EXPONENTS: [(usize, usize); MONOMIALS] = [
            (0, 0),
            (1, 0),
            (0, 1),
            (2, 0),
            (1, 1),
            (0, 2),
            (3, 0),
            (2, 1),
            (1, 2),
            (0, 3),
            (4, 0),
            (3, 1),
            (2, 2),
            (1, 3),
            (0, 4),
        ];
        let mut normal = [[0.0; COLUMNS]; COLUMNS];
        for (k, (i, j)) in EXPONENTS.into_iter().enumerate() {
            for (entry, (other_i, other_j)) in normal[k].iter_mut().zip(EXPONENTS) {
                *entry = self.powers[j + other_j][i + other_i];
            }
            normal[k][MONOMIALS] = self.heights[k];
        }
        normal
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

#[cfg(test)]
mod tests {
    use super::Covariance;

    #[test]
    fn differences_are_measured_by_the_covariance() {
        let variances = [4.0, 1.0, 0.25];
        let diagonal = Covariance::of(|i, j| if i == j { variances[i] } else { 0.0 });
        assert_eq!(diagonal.total(), 4.0 + 2.0 + 0.25);
        assert_eq!(diagonal.deviations([2.0, 0.0, 0.0]), 1.0);
        assert_eq!(diagonal.deviations([0.0, 3.0, 2.0]), 5.0);
        let doubled = diagonal.combined(2.0, &Covariance::default(), 1.0);
        assert_eq!(doubled.deviations([0.0, 3.0, 2.0]), 2.5);
        // Both entries err together, so their difference is certain.
        let common = Covariance([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0]]);
        assert_eq!(common.deviations([1.0, 0.0, 1.0]), 1.0);
        assert!(common.deviations([1.0, 0.0, 0.0]) > 1e5);
        // Without any variance, only equal values agree.
        assert_eq!(Covariance::default().deviations([0.0; 3]), 0.0);
        assert_eq!(Covariance::default().deviations([1.0, 0.0, 0.0]), f64::INFINITY);
    }
}
