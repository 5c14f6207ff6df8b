//! Lengths given by users: in model units, or as shares of the diagonal of the bounding box.

use std::str::FromStr;

use mesh_core::TriMesh;

/// A mesh without a diagonal that lengths could be shares of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the mesh has no extent that lengths could be relative to")]
pub struct NoExtent;

/// A length as given by the user.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// In model units, or a share of the diagonal if lengths are relative.
    Plain(f64),
    /// A share of the diagonal, in percent.
    Percent(f64),
}

impl Length {
    /// The length in model units. `diagonal` is called only if it is needed.
    ///
    /// # Errors
    /// There is no diagonal, and the length is a share of it.
    pub fn in_units(
        self,
        relative: bool,
        diagonal: impl FnOnce() -> Result<f64, NoExtent>,
    ) -> Result<f64, NoExtent> {
        match self {
            Self::Plain(length) if !relative => Ok(length),
            Self::Plain(share) => Ok(share * diagonal()?),
            Self::Percent(share) => Ok(share / 100.0 * diagonal()?),
        }
    }

    /// The length in model units of a mesh.
    ///
    /// # Errors
    /// As [`Length::in_units`].
    pub fn on(self, mesh: &TriMesh, relative: bool) -> Result<f64, NoExtent> {
        self.in_units(relative, || diagonal(mesh.bounding_box().map(|bounds| bounds.diagonal())))
    }

    fn value(self) -> f64 {
        let (Self::Plain(value) | Self::Percent(value)) = self;
        value
    }
}

/// A diagonal that lengths can be relative to.
///
/// # Errors
/// There is none, or it is zero or not finite.
pub fn diagonal(of_box: Option<f64>) -> Result<f64, NoExtent> {
    match of_box {
        Some(diagonal) if diagonal > 0.0 && diagonal.is_finite() => Ok(diagonal),
        _ => Err(NoExtent),
    }
}

impl FromStr for Length {
    type Err = String;

    /// A finite length that is not negative.
    fn from_str(text: &str) -> Result<Self, String> {
        let (number, length): (_, fn(f64) -> Self) = match text.strip_suffix('%') {
            Some(number) => (number.trim_end(), Self::Percent),
            None => (text, Self::Plain),
        };
        match number.parse::<f64>() {
            Ok(value) if value >= 0.0 && value.is_finite() => Ok(length(value)),
            _ => {
                Err("expected a length, like 0.01, or 0.2% of the diagonal of the bounding box"
                    .into())
            }
        }
    }
}

/// Reads a positive length.
///
/// # Errors
/// The text is no number, with or without a percent sign, or not above zero.
pub fn parse_length(text: &str) -> Result<Length, String> {
    match text.parse::<Length>()? {
        length if length.value() > 0.0 => Ok(length),
        _ => Err("expected a length above zero, like 0.01 or 0.2%".into()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_the_diagonal() {
        let resolved = |text: &str, relative| {
            parse_length(text).unwrap().in_units(relative, || Ok(50.0)).unwrap()
        };
        assert_eq!(resolved("0.3", false).to_bits(), 0.3_f64.to_bits());
        assert_eq!(resolved("0.3", true).to_bits(), 15.0_f64.to_bits());
        assert_eq!(resolved("2%", false).to_bits(), 1.0_f64.to_bits());
        assert_eq!(resolved("2 %", true).to_bits(), 1.0_f64.to_bits());
        assert!(parse_length("2%").unwrap().in_units(false, || diagonal(Some(0.0))).is_err());
    }

    #[test]
    fn what_is_no_length_is_refused() {
        for bad in ["", "%", "-1", "nan", "inf", "1e999", "1m", "0", "0%", "2%%"] {
            assert!(parse_length(bad).is_err(), "{bad}");
        }
        assert_eq!("0".parse(), Ok(Length::Plain(0.0)));
    }
}
