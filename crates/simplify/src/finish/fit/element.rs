//! What the pairs of one face add to the normal equations.

use glam::DVec3;

use crate::collapse::symmetric::Symmetric3;
use crate::finish::fit::targets::Target;
use crate::finish::norm::Power;

/// Pairs count as though there were so many samples of a face, however many there are: so much as a
/// point of a line counts one.
pub(super) const USUAL_SAMPLES: usize = 30;

/// How much a pair counts.
#[derive(Clone, Copy)]
pub(crate) struct Weighting {
    pub(crate) pull: f64,
    pub(crate) tail: f64,
    /// The largest squared distance of a pair.
    pub(crate) largest: f64,
    pub(crate) power: Power,
    /// The mean of that order, squared.
    pub(crate) typical: f64,
}

impl Weighting {
    fn of(&self, squared: f64) -> f64 {
        let by_norm = match self.power {
            Power::SQUARE => 1.0,
            power if self.typical > 0.0 => power.weight(squared / self.typical),
            _ => 1.0,
        };
        if self.tail == 0.0 {
            return by_norm;
        }
        let ratio = if self.largest > 0.0 { squared / self.largest } else { 0.0 };
        by_norm + self.tail * ratio.powi(6)
    }
}

/// The part of one face in the normal equations: blocks of three by three.
#[derive(Clone, Copy, Default)]
pub(super) struct Element {
    /// For each corner.
    pub(super) of_corner: [Symmetric3; 3],
    /// For each side, from a corner to the next one.
    pub(super) of_side: [Symmetric3; 3],
    /// Minus the gradient, for each corner.
    pub(super) residual: [DVec3; 3],
    pub(super) tally: Tally,
}

impl Element {
    /// Adds a pair: the point with these weights of the corners, and its target, which stands for
    /// so much of the area.
    #[inline]
    pub(super) fn add(
        &mut self,
        corners: &[DVec3; 3],
        weights: DVec3,
        target: &Target,
        weighting: &Weighting,
    ) {
        let [a, b, c] = *corners;
        let from = |corner: DVec3| corner - target.point;
        let gap = from(a) * weights.x + from(b) * weights.y + from(c) * weights.z;
        let squared = gap.length_squared();
        let weight = target.share * weighting.of(squared);
        let mut matrix = Symmetric3::square(target.normal, weight);
        matrix.diagonal += weight * weighting.pull;
        let force = matrix.times(gap);
        for i in 0..3 {
            self.of_corner[i] += weights[i] * weights[i] * matrix;
            self.of_side[i] += weights[i] * weights[(i + 1) % 3] * matrix;
            self.residual[i] -= weights[i] * force;
        }
        self.tally.squares += target.share * squared;
        self.tally.shares += target.share;
    }
}

/// A mean square in the making.
#[derive(Clone, Copy, Default)]
pub(super) struct Tally {
    squares: f64,
    shares: f64,
}

impl Tally {
    pub(super) fn join(&mut self, other: Self) {
        self.squares += other.squares;
        self.shares += other.shares;
    }

    pub(super) fn rms(&self) -> f64 {
        if self.shares > 0.0 { (self.squares / self.shares).sqrt() } else { 0.0 }
    }
}
