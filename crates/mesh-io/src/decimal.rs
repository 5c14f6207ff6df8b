//! Numbers as text, with the fewest digits that read back as the same number.

use std::fmt;

/// A number as text; powers of ten only where zeros would fill the line.
pub(crate) struct Decimal<T>(pub T);

macro_rules! decimal {
    ($float:ty) => {
        impl fmt::Display for Decimal<$float> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let size = self.0.abs();
                if size == 0.0 || (1e-5..1e16).contains(&size) || !size.is_finite() {
                    write!(f, "{}", self.0)
                } else {
                    write!(f, "{:e}", self.0)
                }
            }
        }
    };
}

decimal!(f32);
decimal!(f64);
