//! Medians and shares.

/// The median of some numbers; 0 without any.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}

/// A share in percent.
pub(super) fn percent(part: f64, whole: f64) -> f64 {
    100.0 * part / whole
}
