//! Lower and upper bounds of the height of a patch over a point, without trigonometric functions.
//!
//! With w = u² and αᵢ = (κᵢ Lᵢ)², the equation (x / A₁)² + (y / A₂)² = 1 for u is
//!
//! ```text
//! w = (x / L₁)² g(α₁ w) + (y / L₂)² g(α₂ w),   g(t²) = (t / sin t)²,
//! ```
//!
//! and the height is τ - κ₁ x² f(α₁ w) - κ₂ y² f(α₂ w) with f(t²) = 1 / (1 + cos t). All coefficients of
//! the power series of f and g are positive. Partial sums are therefore lower bounds, and the right side
//! increases with w. Substituting a lower (upper) bound of the root for w gives a better lower (upper)
//! bound.

use fearless_simd::f64x8;
use fearless_simd::prelude::*;
use glam::{DVec2, DVec3};

use crate::patch::Patch;
use crate::vec3x8::Vec3x8;

/// Terms of g(s) up to s⁵; the rest is less than [`REST_OF_G`] s⁶ up to s = [`MAX_TURN`].
const G: [f64; 6] = [1.0, 1.0 / 3.0, 1.0 / 15.0, 2.0 / 189.0, 1.0 / 675.0, 2.0 / 10_395.0];
const REST_OF_G: f64 = 3.2e-5;

/// Terms of f(s) up to s⁵; the rest is less than [`REST_OF_F`] s⁶.
const F: [f64; 6] = [0.5, 0.125, 1.0 / 48.0, 17.0 / 5760.0, 31.0 / 80_640.0, 691.0 / 14_515_200.0];
const REST_OF_F: f64 = 8e-6;

/// The largest squared angle, in square radians, for which the remainders hold.
const MAX_TURN: f64 = 1.5;

/// Bound of the rounding errors, relative to the sum of the absolute terms.
const ROUNDING: f64 = 1e-9;

/// Number of times that an undecided bracket is narrowed.
const NARROWINGS: usize = 2;

/// The terms of the height that do not depend on the point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeightBracket {
    curvatures: DVec2,
    /// 1 / Lᵢ².
    inverse_arcs: DVec2,
    /// (κᵢ Lᵢ)².
    turns: DVec2,
    translation: f64,
    /// An upper bound of g(αᵢ w) for w ≤ 1.
    growth: f64,
}

impl HeightBracket {
    /// `None` if an arc of the patch turns by more than √[`MAX_TURN`].
    pub(crate) fn new(patch: &Patch) -> Option<Self> {
        let curvatures = DVec2::from_array(patch.curvatures());
        let arcs = DVec2::from_array(patch.arcs());
        let turns = curvatures * curvatures * arcs * arcs;
        (turns.max_element() <= MAX_TURN).then(|| Self {
            curvatures,
            inverse_arcs: (arcs * arcs).recip(),
            turns,
            translation: patch.translation(),
            growth: above(&G, REST_OF_G, turns).max_element(),
        })
    }

    /// Whether a point over or under the footprint is within a distance of the patch, measured along its
    /// normal. `None` if the bracket does not decide.
    #[inline]
    pub(crate) fn is_within(&self, local: DVec3, distance: f64) -> Option<bool> {
        let squares = DVec2::new(local.x * local.x, local.y * local.y);
        let weights = squares * self.inverse_arcs;
        let start = weights.element_sum();
        let [mut low, mut high] = [start, (start * self.growth).min(1.0)];
        let bend = self.curvatures * squares;
        let height = local.z - self.translation;
        let size = bend.abs().element_sum() + local.z.abs() + self.translation.abs();
        for narrowing in 0..=NARROWINGS {
            // κᵢ xᵢ² f at both ends of the bracket, for both arms.
            let ends = [
                bend * below(&F, self.turns * low),
                bend * above(&F, REST_OF_F, self.turns * high),
            ];
            let [least, most] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            let slack = ROUNDING * size;
            let lowest = height + least.element_sum() - slack;
            let highest = height + most.element_sum() + slack;
            if -distance <= lowest && highest <= distance {
                return Some(true);
            }
            if highest < -distance || lowest > distance {
                return Some(false);
            }
            if narrowing < NARROWINGS {
                low = weights.dot(below(&G, self.turns * low)).min(1.0);
                high = weights.dot(above(&G, REST_OF_G, self.turns * high)).min(1.0);
            }
        }
        None
    }

    /// As [`HeightBracket::is_within`] for eight points: the points within and the points beyond, as bits.
    ///
    /// Only the lanes of `asked` are tested. Lanes in neither result are undecided.
    #[inline(always)]
    pub(crate) fn are_within<S: Simd>(
        &self,
        simd: S,
        local: &Vec3x8<S>,
        distance: f64,
        asked: u64,
    ) -> [u64; 2] {
        // No closures: they would not be compiled for the instruction set of `simd`.
        let inverse_arcs = splat_pair(simd, self.inverse_arcs);
        let turns = splat_pair(simd, self.turns);
        let curvatures = splat_pair(simd, self.curvatures);
        let one = f64x8::splat(simd, 1.0);
        let squares = [local.x * local.x, local.y * local.y];
        let weights = times(squares, inverse_arcs);
        let start = weights[0] + weights[1];
        let [mut low, mut high] = [start, (start * f64x8::splat(simd, self.growth)).min(one)];
        let bend = times(curvatures, squares);
        let height = local.z - f64x8::splat(simd, self.translation);
        let size = (bend[0].abs() + bend[1].abs())
            + local.z.abs()
            + f64x8::splat(simd, self.translation.abs());
        let slack = f64x8::splat(simd, ROUNDING) * size;
        let (nearest, farthest) = (f64x8::splat(simd, -distance), f64x8::splat(simd, distance));
        let (mut within, mut beyond) = (0, 0);
        for narrowing in 0..=NARROWINGS {
            let ends = [
                times(bend, above_x8(simd, &F, 0.0, times(turns, [low; 2]))),
                times(bend, above_x8(simd, &F, REST_OF_F, times(turns, [high; 2]))),
            ];
            let least = ends[0][0].min(ends[1][0]) + ends[0][1].min(ends[1][1]);
            let most = ends[0][0].max(ends[1][0]) + ends[0][1].max(ends[1][1]);
            let lowest = height + least - slack;
            let highest = height + most + slack;
            let is_within = nearest.simd_le(lowest) & highest.simd_le(farthest);
            let is_beyond = highest.simd_lt(nearest) | lowest.simd_gt(farthest);
            let open = asked & !(within | beyond);
            within |= open & is_within.to_bitmask();
            beyond |= open & is_beyond.to_bitmask();
            if asked & !(within | beyond) == 0 {
                break;
            }
            if narrowing < NARROWINGS {
                let at_low = times(weights, above_x8(simd, &G, 0.0, times(turns, [low; 2])));
                let at_high =
                    times(weights, above_x8(simd, &G, REST_OF_G, times(turns, [high; 2])));
                low = (at_low[0] + at_low[1]).min(one);
                high = (at_high[0] + at_high[1]).min(one);
            }
        }
        [within, beyond]
    }
}

#[inline(always)]
fn splat_pair<S: Simd>(simd: S, numbers: DVec2) -> [f64x8<S>; 2] {
    [f64x8::splat(simd, numbers.x), f64x8::splat(simd, numbers.y)]
}

#[inline(always)]
fn times<S: Simd>(a: [f64x8<S>; 2], b: [f64x8<S>; 2]) -> [f64x8<S>; 2] {
    [a[0] * b[0], a[1] * b[1]]
}

/// As [`above`], for eight pairs.
#[inline(always)]
fn above_x8<S: Simd>(
    simd: S,
    coefficients: &[f64; 6],
    last: f64,
    at: [f64x8<S>; 2],
) -> [f64x8<S>; 2] {
    let mut sums = [f64x8::splat(simd, last); 2];
    let mut place = coefficients.len();
    while place > 0 {
        place -= 1;
        let coefficient = f64x8::splat(simd, coefficients[place]);
        sums = [sums[0] * at[0] + coefficient, sums[1] * at[1] + coefficient];
    }
    sums
}

/// The polynomial with these coefficients, ascending, at two numbers.
#[inline]
fn below(coefficients: &[f64; 6], at: DVec2) -> DVec2 {
    above(coefficients, 0.0, at)
}

/// As [`below`], with one more coefficient.
#[inline]
fn above([c0, c1, c2, c3, c4, c5]: &[f64; 6], c6: f64, at: DVec2) -> DVec2 {
    (((((c6 * at + *c5) * at + *c4) * at + *c3) * at + *c2) * at + *c1) * at + *c0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::PatchData;
    use fearless_simd::{Level, dispatch};
    use mesh_core::SplitMix64;

    #[test]
    fn the_series_bound_their_functions() {
        for step in 1..=1000 {
            let square = MAX_TURN * f64::from(step) / 1000.0;
            let (sin, cos) = square.sqrt().sin_cos();
            let (g, f) = (square / (sin * sin), 1.0 / (1.0 + cos));
            let tiny = 1e-14;
            let at = DVec2::splat(square);
            assert!(below(&G, at).x <= g + tiny && g <= above(&G, REST_OF_G, at).y + tiny);
            assert!(below(&F, at).y <= f + tiny && f <= above(&F, REST_OF_F, at).x + tiny);
        }
    }

    /// Against the heights by Newton's method, for curvatures of all signs: never a wrong answer, and
    /// undecided in less than 5 % of the cases.
    #[test]
    fn agrees_with_the_height_or_is_undecided() {
        let mut random = SplitMix64::new(11);
        let (mut asked, mut open) = (0, 0);
        for _ in 0..400 {
            let mut draw = |limit: f64| limit * random.symmetric();
            let arcs = [1.0 + draw(0.9), 1.0 + draw(0.9)];
            let curvatures = arcs.map(|arc| draw(1.2) / arc);
            let translation = draw(0.1);
            let frame = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let data = PatchData { origin: [0.0; 3], frame, curvatures, arcs, translation };
            let patch = Patch::try_from(data).unwrap();
            let bracket = HeightBracket::new(&patch).unwrap();
            let tolerance = 0.02;
            for _ in 0..200 {
                let [x, y] = patch.semi_axes().map(|axis| axis * random.symmetric());
                let Some(height) = patch.height_in_footprint(x, y) else { continue };
                let off = 2.0 * tolerance * random.symmetric();
                let answer = bracket.is_within(DVec3::new(x, y, height + off), tolerance);
                asked += 1;
                open += usize::from(answer.is_none());
                let wide = dispatch!(Level::new(), simd => {
                    let local = Vec3x8::splat(simd, DVec3::new(x, y, height + off));
                    bracket.are_within(simd, &local, tolerance, 0b1001_0110)
                });
                let bits = |is_so: bool| if is_so { 0b1001_0110 } else { 0 };
                assert_eq!(wide, [bits(answer == Some(true)), bits(answer == Some(false))]);
                assert!(answer.is_none_or(|within| within == (off.abs() <= tolerance)));
            }
        }
        assert!(asked > 50_000 && open * 20 < asked, "{open} of {asked}");
    }

    #[test]
    fn does_not_apply_to_patches_that_turn_far() {
        let frame = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let data = PatchData {
            origin: [0.0; 3],
            frame,
            curvatures: [1.4, 0.0],
            arcs: [1.0, 1.0],
            translation: 0.0,
        };
        assert!(HeightBracket::new(&Patch::try_from(data).unwrap()).is_none());
    }
}
