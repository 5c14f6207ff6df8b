//! Arc tangent of a quotient: fast, bit-identical on every platform, defined for degenerate input.
//!
//! Arc tangents dominate the cost of curvature. The standard library calls the C library of the platform,
//! one angle at a time, with bits that differ between platforms. This function has no branches and no
//! tables.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// `tan(pi/8)`: above it, [`atan2`] takes the arc tangent of the difference to `pi/4`.
const TAN_PI_8: f64 = 0.414_213_562_373_095_05;

/// The angle of the vector `(x, y)`, in radians, from -pi to pi, with a relative error below
/// 4.5e-16 (two units in the last place; 2.5e-16 is the usual worst case).
///
/// Unlike [`f64::atan2`], it ignores the sign of zero: the angle of the zero vector is 0, the angle of
/// the negative x-axis is pi. The vector must be finite, and either zero or longer than 1e-300.
#[inline(always)]
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    // All selections compile without branches.
    let (width, height) = (x.abs(), y.abs());
    let (short, long) = if height < width { (height, width) } else { (width, height) };
    // The first octant: atan(t) = pi/4 + atan((t - 1) / (t + 1)).
    let diagonal = TAN_PI_8 * long;
    let numerator = if short > diagonal { short - long } else { short };
    let denominator = if short > diagonal { short + long } else { long };
    let offset = if short > diagonal { FRAC_PI_4 } else { 0.0 };
    // Avoids division by zero for the zero vector.
    let divisor = if denominator > f64::MIN_POSITIVE { denominator } else { f64::MIN_POSITIVE };
    let octant = offset + small_atan(numerator / divisor);
    let quadrant = if width < height { FRAC_PI_2 - octant } else { octant };
    let half_plane = if x < 0.0 { PI - quadrant } else { quadrant };
    // Adding zero turns -0 into +0.
    half_plane.copysign(y + 0.0)
}

/// The arc tangent of `r` with `|r| <= tan(pi/8)`: `r + r³ P(r²)`, where P interpolates
/// `(atan(r)/r - 1)/r²` at the Chebyshev nodes of `0..tan²(pi/8)`. Its error is below 5e-18 `|r|`.
#[inline(always)]
fn small_atan(r: f64) -> f64 {
    let s = r * r;
    let (s2, s4) = (s * s, (s * s) * (s * s));
    let low = (-0.333_333_333_333_333_3 + s * 0.199_999_999_999_955_2)
        + s2 * (-0.142_857_142_846_665_42 + s * 0.111_111_110_152_562_92);
    let middle = (-0.090_909_045_781_210_85 + s * 0.076_921_831_907_606_51)
        + s2 * (-0.066_645_114_464_602_2 + s * 0.058_581_489_047_951_24);
    let high =
        -0.050_854_496_960_392_584 + s * 0.039_231_657_085_083_686 - s2 * 0.019_176_885_636_589_053;
    r + r * s * (low + s4 * (middle + s4 * high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::SplitMix64;

    #[test]
    fn agrees_with_the_standard_library_to_the_last_bits() {
        let mut random = SplitMix64::new(1);
        let mut worst = 0.0_f64;
        for step in 0..4_000_000 {
            let mut coordinate = || match step % 4 {
                0 => random.symmetric(),
                1 => random.symmetric().powi(5),
                // All magnitudes.
                2 => random.symmetric() * 10.0_f64.powf(300.0 * random.symmetric()),
                // Both near the diagonal.
                _ => 1.0 + 1e-3 * random.symmetric(),
            };
            let (x, y) = (coordinate(), coordinate());
            let expected = y.atan2(x);
            if expected.abs() > 1e-290 {
                worst = worst.max(((atan2(y, x) - expected) / expected).abs());
            }
        }
        println!("largest relative difference {worst:e}");
        // The standard library itself is off by up to 1.2e-16.
        assert!(worst < 4.5e-16);
    }

    #[test]
    fn axes_and_diagonals() {
        for (y, x, expected) in [
            (0.0, 1.0, 0.0),
            (-0.0, 1.0, 0.0),
            (0.0, -1.0, PI),
            (-0.0, -1.0, PI),
            (0.0, 0.0, 0.0),
            (-0.0, -0.0, 0.0),
            (2.0, 0.0, FRAC_PI_2),
            (-2.0, -0.0, -FRAC_PI_2),
            (3.0, 3.0, FRAC_PI_4),
            (-3.0, 3.0, -FRAC_PI_4),
            (3.0, -3.0, PI - FRAC_PI_4),
            (1e-300, 1e300, 0.0),
            (1e-200, 1.0, 1e-200),
        ] {
            assert_eq!(atan2(y, x), expected, "{y} {x}");
        }
    }
}
