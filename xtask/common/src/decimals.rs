//! Decimal notation of numbers.

/// A number without a printed reference: an integer, or six digits.
pub fn plain(x: f64) -> String {
    if x.fract() == 0.0 && x.abs() < 1e15 {
        return grouped(x);
    }
    digits(x, 6)
}

/// A number with `digits` significant digits, without exponent unless it is very small or large.
pub fn digits(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let magnitude = x.abs().log10().floor() as i32;
    if !(-5..15).contains(&magnitude) {
        return format!("{x:.*e}", digits.saturating_sub(1));
    }
    format!("{x:.*}", (digits as i32 - 1 - magnitude).max(0) as usize)
}

/// A whole number with grouped thousands.
fn grouped(x: f64) -> String {
    let plain = format!("{:.0}", x.abs());
    let mut text = String::new();
    for (i, digit) in plain.chars().enumerate() {
        if i > 0 && (plain.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    if x < 0.0 { format!("-{text}") } else { text }
}

/// A number with `decimals` decimals; with 0, as short as possible.
pub fn with_decimals(x: f64, decimals: usize) -> String {
    match decimals {
        0 if x.fract() == 0.0 => grouped(x),
        0 => digits(x, 6),
        _ => format!("{x:.decimals$}"),
    }
}

/// The number of decimals of a number as printed.
pub fn decimals_of(x: f64) -> usize {
    x.to_string().split_once('.').map_or(0, |(_, decimals)| decimals.len())
}

#[cfg(test)]
mod tests {
    use super::{decimals_of, digits, plain};

    #[test]
    fn numbers_are_written_for_people() {
        assert_eq!(plain(268_686.0), "268,686");
        assert_eq!(plain(-12.0), "-12");
        assert_eq!(plain(0.25), "0.250000");
        assert_eq!(digits(24.475_301, 6), "24.4753");
        assert_eq!(digits(1.5e-9, 3), "1.50e-9");
        assert_eq!(decimals_of(0.2342743546), 10);
        assert_eq!(decimals_of(30.0), 0);
    }
}
