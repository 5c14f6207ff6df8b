//! Round numbers along an axis or a colour bar.

/// Multiples of 1, 2 or 5 times a power of ten from `low` to `high`, about `about` of them.
#[must_use]
pub fn linear(low: f64, high: f64, about: usize) -> Vec<f64> {
    let extent = high - low;
    if !(extent.is_finite() && extent > 0.0) {
        return if low.is_finite() { vec![low] } else { Vec::new() };
    }
    let rough = extent / about.max(1) as f64;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|f| f * power).into_iter().find(|&s| s >= rough);
    let step = step.unwrap_or(rough);
    let (first, last) = ((low / step).ceil(), (high / step).floor());
    // Far from zero, neighbouring multiples are the same number; then only the ends are used.
    if !(step > 0.0 && last - first < 1000.0 && low + step > low) {
        return vec![low, high];
    }
    let count = (last - first) as usize;
    (0..=count).map(|i| (first + i as f64) * step).collect()
}

/// Powers of ten from `low` to `high`, both positive; with two and five times them if there are few.
#[must_use]
pub fn log(low: f64, high: f64) -> Vec<f64> {
    if !(low > 0.0 && high >= low && high.is_finite()) {
        return Vec::new();
    }
    #[expect(clippy::cast_possible_truncation, reason = "exponents of finite numbers")]
    let powers = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let all = |factors: &[f64]| -> Vec<f64> {
        let values = powers.clone().flat_map(|p| {
            factors
                .iter()
                .map(move |f| if p < 0 { f / 10_f64.powi(-p) } else { f * 10_f64.powi(p) })
        });
        values.filter(|v| (low..=high).contains(v)).collect()
    };
    let decades = all(&[1.0]);
    if decades.len() >= 4 { decades } else { all(&[1.0, 2.0, 5.0]) }
}

/// A tick in a few characters, without rounding noise in the last digits.
#[must_use]
pub fn label(tick: f64) -> String {
    let rounded: f64 = format!("{tick:.6e}").parse().unwrap_or(tick);
    if rounded != 0.0 && !(1e-4..1e6).contains(&rounded.abs()) {
        return format!("{rounded:e}");
    }
    rounded.to_string()
}

#[cfg(test)]
mod tests {
    use super::{label, linear, log};

    fn labels(ticks: &[f64]) -> Vec<String> {
        ticks.iter().map(|&t| label(t)).collect()
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(labels(&linear(0.0, 0.53, 6)), ["0", "0.1", "0.2", "0.3", "0.4", "0.5"]);
        assert_eq!(labels(&linear(-3.0, 3.0, 6)), ["-3", "-2", "-1", "0", "1", "2", "3"]);
        assert_eq!(
            labels(&log(0.003, 0.9)),
            ["0.005", "0.01", "0.02", "0.05", "0.1", "0.2", "0.5"]
        );
        assert_eq!(label(2e-7), "2e-7");
    }

    #[test]
    fn any_two_numbers_have_few_ticks() {
        let ends = [0.0, -1.0, 1e300, 5e-324, f64::MAX, f64::NAN, f64::INFINITY, 1e16, 1e16 + 2.0];
        for low in ends {
            for high in ends {
                assert!(linear(low, high, 6).len() < 30, "{low} {high}");
                assert!(log(low, high).len() < 700, "{low} {high}");
            }
        }
    }
}
