//! What the finishing makes small: the mean, the root mean square, or the largest distance.

/// What the finishing makes small of the distances between the mesh and the original.
///
/// All three are found by weighted least squares: a pair of points at the distance d counts
/// `(d / s)^(p - 2)`, where p belongs to the norm and s is the mean of order p of all distances, and the
/// weights are made anew in each round (iteratively reweighted least squares, Lawson 1961). Weights
/// have bounds, so that single pairs do not make the equations singular.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum FitNorm {
    /// The mean distance, p = 1, after a first round with p = 2: some percent less mean, for a little more
    /// root mean square and largest distance.
    L1,
    /// The root mean square distance, p = 2: all pairs count the same.
    #[default]
    L2,
    /// The largest distance: p is 2 in the first round and grows to 8, and steps get shorter as the
    /// equations get less linear. The mean rises.
    Max,
}

impl FitNorm {
    /// All norms.
    pub const ALL: &'static [Self] = &[Self::L1, Self::L2, Self::Max];

    /// The name: `l1`, `l2` or `max`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::L1 => "l1",
            Self::L2 => "l2",
            Self::Max => "max",
        }
    }

    /// The mean that is made small in a round.
    pub(crate) fn power(self, round: usize) -> Power {
        match self {
            Self::L1 => Power(if round == 0 { 2 } else { 1 }),
            Self::L2 => Power(2),
            Self::Max => Power(LARGEST.min(2 + 2 * round as u32)),
        }
    }

    /// The mean that tells which of two meshes is better.
    pub(crate) fn last_power(self) -> Power {
        self.power(LARGEST as usize)
    }
}

/// The order of the mean that stands for the largest distance.
const LARGEST: u32 = 8;

/// The order of a mean of distances: 1, or even.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Power(u32);

impl Power {
    /// That of the root mean square.
    pub(crate) const SQUARE: Self = Self(2);

    /// What a distance adds to the sum, by its square.
    #[inline]
    pub(crate) fn of(self, squared: f64) -> f64 {
        match self.0 {
            1 => squared.sqrt(),
            2 => squared,
            p => squared.powi((p / 2) as i32),
        }
    }

    /// The squared mean of this order of squared distances.
    pub(crate) fn mean(self, squares: &[f64]) -> f64 {
        let largest = squares.iter().copied().fold(0.0, f64::max);
        if largest == 0.0 {
            return 0.0;
        }
        // Relative to the largest, so that no power is out of range.
        let sum: f64 = squares.iter().map(|squared| self.of(squared / largest)).sum();
        largest * (sum / squares.len() as f64).powf(2.0 / f64::from(self.0))
    }

    /// How much a pair at a distance counts whose square is so many times that of the mean distance.
    #[inline]
    pub(crate) fn weight(self, ratio: f64) -> f64 {
        match self.0 {
            1 => ratio.sqrt().recip().min(MOST_L1),
            2 => 1.0,
            p => ratio.powi((p / 2) as i32 - 1).clamp(LEAST, MOST),
        }
    }

    /// The part of a step of the weighted equations that is taken: Newton's method would take
    /// 1 / (p - 1), but far from the minimum that is little.
    pub(crate) fn part_of_step(self) -> f64 {
        (2.0 / f64::from(self.0)).min(1.0)
    }

    /// How many faces per area make the mean of this order least, up to a factor:
    /// |K|^(p / (2 p + 2)). |K| is given as E / a³, for faces with the area a and the integrated squared
    /// distance E.
    pub(crate) fn faces_per_area(self, curvature: f64) -> f64 {
        match self.0 {
            _ if !(curvature > 0.0 && curvature.is_finite()) => 0.0,
            1 => curvature.powf(0.25),
            2 => curvature.cbrt(),
            // As where p is infinite.
            _ => curvature.sqrt(),
        }
    }
}

/// The bounds of weights.
const LEAST: f64 = 0.01;
const MOST: f64 = 10.0;
const MOST_L1: f64 = 4.0;

#[cfg(test)]
mod tests {
    use super::{FitNorm, Power};

    #[test]
    fn orders_of_the_rounds_are_those_of_the_norm() {
        let of = |norm: FitNorm| [0, 1, 2, 3, 4].map(|round| norm.power(round).0);
        assert_eq!(of(FitNorm::L1), [2, 1, 1, 1, 1]);
        assert_eq!(of(FitNorm::L2), [2; 5]);
        assert_eq!(of(FitNorm::Max), [2, 4, 6, 8, 8]);
    }

    #[test]
    fn means_are_those_of_their_order() {
        let squares = [1.0, 4.0, 16.0];
        let of = |norm: FitNorm| norm.last_power().mean(&squares).sqrt();
        assert!((of(FitNorm::L1) - 7.0 / 3.0).abs() < 1e-12);
        assert!((of(FitNorm::L2) - 7_f64.sqrt()).abs() < 1e-12);
        let sum: f64 = [1_f64, 2.0, 4.0].iter().map(|d| d.powi(8)).sum();
        assert!((of(FitNorm::Max) - (sum / 3.0).powf(0.125)).abs() < 1e-12);
        assert_eq!(Power::SQUARE.mean(&[]), 0.0);
        // Squares whose fourth power is out of range.
        assert!((FitNorm::Max.last_power().mean(&[1e200]) / 1e200 - 1.0).abs() < 1e-12);
    }

    /// The gradient of the weighted sum of squares is that of the sum of powers, up to a factor.
    #[test]
    fn weights_are_those_of_least_squares() {
        for norm in [FitNorm::L1, FitNorm::L2, FitNorm::Max] {
            let power = norm.last_power();
            let slope = |d: f64| (power.of((d + 1e-6).powi(2)) - power.of((d - 1e-6).powi(2))) / d;
            let ratio = slope(1.2) / slope(0.9);
            let weights = power.weight(1.2 * 1.2) / power.weight(0.9 * 0.9);
            assert!((ratio / weights - 1.0).abs() < 1e-6, "{norm:?}");
        }
    }

    /// Where the sum of |K| a³ is least for the number of faces, all of them have the same.
    #[test]
    fn faces_of_least_squares_have_the_same_error() {
        let error = |curvature: f64| {
            let area = FitNorm::L2.last_power().faces_per_area(curvature).recip();
            curvature * area.powi(3)
        };
        assert!((error(5.0) / error(0.2) - 1.0).abs() < 1e-12);
        assert_eq!(FitNorm::L1.last_power().faces_per_area(f64::NAN), 0.0);
    }
}
