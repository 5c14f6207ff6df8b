//! The norm that refinement minimises: the mean, the root mean square, or the largest distance.

use core::str::FromStr;

/// The norm of the distances between mesh and original that refinement minimises.
///
/// All three use weighted least squares. A pair of points at the distance d has the weight `(d / s)^(p - 2)`, where p
/// depends on the norm and s is the mean of order p of all distances. The weights are computed again in each round
/// (iteratively reweighted least squares, Lawson 1961). They are bounded, so that single pairs do not make the
/// equations singular.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum FitNorm {
    /// The mean distance, p = 1, after a first round with p = 2. The mean is a few percent lower, and the root mean
    /// square and the largest distance are slightly higher.
    L1,
    /// The root mean square distance, p = 2: all pairs have the same weight.
    #[default]
    L2,
    /// The largest distance: p is 2 in the first round and grows to 8. Steps become shorter as the equations become
    /// less linear. The mean rises.
    Max,
}

/// A name that is no norm.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no norm {0:?}; there are l1, l2, max")]
pub struct UnknownNorm(pub String);

impl FromStr for FitNorm {
    type Err = UnknownNorm;

    fn from_str(name: &str) -> Result<Self, UnknownNorm> {
        let found = Self::ALL.iter().find(|norm| norm.name() == name);
        found.copied().ok_or_else(|| UnknownNorm(name.to_owned()))
    }
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

    /// The mean that a round minimises.
    pub(crate) fn power(self, round: usize) -> Power {
        let round = u32::try_from(round).unwrap_or(LARGEST);
        match self {
            Self::L1 => Power(if round == 0 { 2 } else { 1 }),
            Self::L2 => Power(2),
            Self::Max => Power(LARGEST.min(2 + 2 * round.min(LARGEST))),
        }
    }

    /// The mean that decides which of two meshes is better.
    pub(crate) fn last_power(self) -> Power {
        self.power(LARGEST as usize)
    }
}

/// The order of the mean that approximates the largest distance.
const LARGEST: u32 = 8;

/// The order of a mean of distances: 1, or even.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Power(u32);

impl Power {
    /// The order of the root mean square.
    pub(crate) const SQUARE: Self = Self(2);

    /// The term of a distance in the sum, from its square.
    #[inline]
    pub(crate) fn of(self, squared: f64) -> f64 {
        match self.0 {
            1 => squared.sqrt(),
            2 => squared,
            p => squared.powi((p / 2).cast_signed()),
        }
    }

    /// The squared mean of this order of squared distances.
    pub(crate) fn mean(self, squares: &[f64]) -> f64 {
        let largest = squares.iter().copied().fold(0.0, f64::max);
        if largest == 0.0 {
            return 0.0;
        }
        // Relative to the largest square, so that no power overflows.
        let sum: f64 = squares.iter().map(|squared| self.of(squared / largest)).sum();
        largest * (sum / squares.len() as f64).powf(2.0 / f64::from(self.0))
    }

    /// The weight of a pair whose squared distance is `ratio` times the square of the mean distance.
    #[inline]
    pub(crate) fn weight(self, ratio: f64) -> f64 {
        match self.0 {
            1 => ratio.sqrt().recip().min(MOST_L1),
            2 => 1.0,
            p => ratio.powi((p / 2).cast_signed() - 1).clamp(LEAST, MOST),
        }
    }

    /// The fraction of a step of the weighted equations that is taken. Newton's method would use 1 / (p - 1), which is
    /// too little far from the minimum.
    pub(crate) fn part_of_step(self) -> f64 {
        (2.0 / f64::from(self.0)).min(1.0)
    }

    /// The number of faces per area that minimises the mean of this order, up to a factor: |K|^(p / (2 p + 2)). |K| is
    /// given as E / a³, for faces with the area a and the integrated squared distance E.
    pub(crate) fn faces_per_area(self, curvature: f64) -> f64 {
        match self.0 {
            _ if !(curvature > 0.0 && curvature.is_finite()) => 0.0,
            1 => curvature.powf(0.25),
            2 => curvature.cbrt(),
            // As for infinite p.
            _ => curvature.sqrt(),
        }
    }
}

/// Bounds of the weights.
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
        // Squares whose fourth power overflows.
        assert!((FitNorm::Max.last_power().mean(&[1e200]) / 1e200 - 1.0).abs() < 1e-12);
    }

    /// The gradient of the weighted sum of squares is the gradient of the sum of powers, up to a factor.
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

    /// If the sum of |K| a³ is least for a number of faces, all faces have the same term.
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
