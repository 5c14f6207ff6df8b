//! Numbers for people, at any scale of the model.

use core::fmt;

/// A number with six decimals where those show it, and otherwise with six digits and a power of ten: `0.250000`,
/// `1.23608e-8`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decimal(pub(crate) f64);

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value) = self;
        if *value == 0.0 || (1e-3..1e7).contains(&value.abs()) || !value.is_finite() {
            write!(f, "{value:.6}")
        } else {
            write!(f, "{value:.5e}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_scales_are_readable() {
        let shown =
            [0.0, 0.25, -1234.5, 1.236_081e-8, -2.5e12, 1e-3].map(|v| Decimal(v).to_string());
        assert_eq!(
            shown,
            ["0.000000", "0.250000", "-1234.500000", "1.23608e-8", "-2.50000e12", "0.001000"]
        );
    }
}
