//! The contribution of the pairs of one face to the normal equations.

use glam::DVec3;
use mesh_collapse::Symmetric3;

use crate::norm::Power;

/// The number of samples that every face seems to have: the weights of its pairs are scaled accordingly. A point of a
/// line has weight 1.
pub(super) const USUAL_SAMPLES: usize = 30;

/// The weight of a point if a face has this many points.
pub(crate) fn share_of_one(points_per_face: usize) -> f64 {
    USUAL_SAMPLES as f64 / points_per_face.max(1) as f64
}

/// Parameters of the weight of a pair.
#[derive(Clone, Copy)]
pub(crate) struct Weighting {
    pub(crate) pull: f64,
    pub(crate) tail: f64,
    /// The largest squared distance of a pair.
    pub(crate) largest: f64,
    pub(crate) power: Power,
    /// The mean of the order `power`, squared.
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

/// A point of a face and its partner on the original.
pub(super) struct Pair {
    /// The barycentric weights of the point in its face.
    pub(super) weights: DVec3,
    /// The vector from the point of the original to the point of the face.
    pub(super) gap: DVec3,
    /// The normal of the original.
    pub(super) normal: DVec3,
    /// The share of the area that the pair represents.
    pub(super) share: f64,
}

/// The contribution of one face to the normal equations, in blocks of three by three.
#[derive(Clone, Copy, Default)]
pub(super) struct Element {
    /// For each corner.
    pub(super) of_corner: [Symmetric3; 3],
    /// For each side, from a corner to the next one.
    pub(super) of_side: [Symmetric3; 3],
    /// The negative gradient at each corner.
    pub(super) residual: [DVec3; 3],
    pub(super) tally: Tally,
}

impl Element {
    /// Adds a pair.
    #[inline]
    pub(super) fn add(&mut self, pair: &Pair, weighting: &Weighting) {
        let Pair { weights, gap, normal, share } = *pair;
        let squared = gap.length_squared();
        let weight = share * weighting.of(squared);
        let mut matrix = Symmetric3::square(normal, weight);
        matrix.diagonal += weight * weighting.pull;
        let force = matrix.times(gap);
        let weights = weights.to_array();
        for i in 0..3 {
            self.of_corner[i] += weights[i] * weights[i] * matrix;
            self.of_side[i] += weights[i] * weights[(i + 1) % 3] * matrix;
            self.residual[i] -= weights[i] * force;
        }
        self.tally.squares += share * squared;
        self.tally.shares += share;
    }
}

/// Sums for a mean square.
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
