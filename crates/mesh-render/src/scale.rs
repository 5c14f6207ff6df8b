//! Numbers to colours: a colour map with the values at its ends.

use core::fmt;
use core::str::FromStr;

use crate::colormap::ColorMap;

/// The colour of missing values: NaN, or not positive on a logarithmic scale.
pub const MISSING: [u8; 3] = [140, 140, 140];

/// The values at the ends of the colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Range {
    /// The 2nd to 98th percentile of the values, made symmetric for signed quantities.
    #[default]
    Auto,
    /// The smallest to the largest value, made symmetric for signed quantities.
    Full,
    /// Between two percentiles from 0 to 100, made symmetric for signed quantities.
    Percentiles(f64, f64),
    /// The given values.
    Given(f64, f64),
}

/// A range that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected `auto`, `full`, two growing numbers, like -1,1, or two growing percentiles, like 5%,95%"
)]
pub struct BadRange;

impl Range {
    /// Description of the origin of the range.
    #[must_use]
    pub fn origin(self) -> String {
        match self {
            Self::Auto => "2nd to 98th percentile".into(),
            Self::Full => "all values".into(),
            Self::Percentiles(low, high) => format!("percentiles {low} to {high}"),
            Self::Given(..) => "as given".into(),
        }
    }

    /// The percentiles of the range, if it is made from the values.
    #[must_use]
    pub fn percentiles(self) -> Option<[f64; 2]> {
        match self {
            Self::Auto => Some([2.0, 98.0]),
            Self::Full => Some([0.0, 100.0]),
            Self::Percentiles(low, high) => Some([low, high]),
            Self::Given(..) => None,
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Full => f.write_str("full"),
            Self::Percentiles(low, high) => write!(f, "{low}%,{high}%"),
            Self::Given(low, high) => write!(f, "{low},{high}"),
        }
    }
}

impl FromStr for Range {
    type Err = BadRange;

    fn from_str(text: &str) -> Result<Self, BadRange> {
        match text {
            "auto" => return Ok(Self::Auto),
            "full" => return Ok(Self::Full),
            _ => {}
        }
        let (low, high) = text.split_once(',').ok_or(BadRange)?;
        let (low, high) = (low.trim(), high.trim());
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| BadRange);
        if let (Some(low), Some(high)) = (low.strip_suffix('%'), high.strip_suffix('%')) {
            let (low, high) = (number(low)?, number(high)?);
            let is_growing = 0.0 <= low && low < high && high <= 100.0;
            return if is_growing { Ok(Self::Percentiles(low, high)) } else { Err(BadRange) };
        }
        let (low, high) = (number(low)?, number(high)?);
        let is_growing = low.is_finite() && high.is_finite() && low < high;
        if is_growing { Ok(Self::Given(low, high)) } else { Err(BadRange) }
    }
}

/// Options for the conversion of numbers to colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ScaleOptions {
    /// The colour map; `None` for the usual map of the quantity: [`ColorMap::usual`].
    pub colors: Option<ColorMap>,
    /// The values at the ends.
    pub range: Range,
    /// Whether the quantity has two signs: zero is then in the middle of a range made from values.
    pub signed: bool,
    /// Whether equal steps of colour are equal ratios; values that are not positive then have no colour.
    pub log: bool,
}

impl ScaleOptions {
    /// The scale for some values; values that are not finite are ignored.
    #[must_use]
    pub fn fit(&self, values: impl IntoIterator<Item = f64>) -> Scale {
        let counts = |v: &f64| !v.is_nan() && (!self.log || *v > 0.0);
        let values: Vec<f64> = values.into_iter().filter(counts).collect();
        let [low, high] = match (self.range.percentiles(), self.range) {
            (Some(percentiles), _) => self.ends(percentiles, values.clone()),
            (None, Range::Given(low, high)) => [low, high],
            (None, _) => [0.0; 2],
        };
        let colors = self.colors.unwrap_or(ColorMap::usual(self.signed && !self.log));
        let is_beyond = |beyond: &dyn Fn(f64) -> bool| values.iter().any(|&value| beyond(value));
        let beyond = [is_beyond(&|value| value < low), is_beyond(&|value| value > high)];
        Scale { colors, low, high, log: self.log, beyond }
    }

    fn ends(&self, percentiles: [f64; 2], mut values: Vec<f64>) -> [f64; 2] {
        values.retain(|value| value.is_finite());
        let Some(last) = values.len().checked_sub(1) else { return [0.0; 2] };
        let [low, high] = percentiles.map(|percentile| {
            let rank = rank(percentile, last);
            *values.select_nth_unstable_by(rank, f64::total_cmp).1
        });
        if self.signed && !self.log {
            let reach = low.abs().max(high.abs());
            return [-reach, reach];
        }
        [low, high]
    }
}

/// The index of the percentile in a sorted list whose last index is `last`.
#[must_use]
pub fn rank(percentile: f64, last: usize) -> usize {
    (percentile / 100.0 * last as f64).round().clamp(0.0, last as f64) as usize
}

/// A colour map with the values at its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Scale {
    /// The colours.
    pub colors: ColorMap,
    /// The value at the lower end.
    pub low: f64,
    /// The value at the upper end.
    pub high: f64,
    /// Whether equal steps of colour are equal ratios.
    pub log: bool,
    /// Whether there are values below the lower and above the upper end. A legend shows arrows there.
    #[cfg_attr(feature = "serde", serde(default))]
    pub beyond: [bool; 2],
}

impl Scale {
    /// The place of a value on the colours, from 0 to 1; `None` if it has none. Values beyond the ends are at the end,
    /// and all are in the middle if both ends are equal.
    #[must_use]
    pub fn place(&self, value: f64) -> Option<f64> {
        if value.is_nan() || (self.log && value <= 0.0) {
            return None;
        }
        let unit = |x: f64| if self.log { x.max(f64::MIN_POSITIVE).ln() } else { x };
        // Halves, because the full extent of very large numbers overflows.
        let (low, high) = (0.5 * unit(self.low), 0.5 * unit(self.high));
        let extent = high - low;
        let place = if extent > 0.0 { (0.5 * unit(value) - low) / extent } else { 0.5 };
        Some(place.clamp(0.0, 1.0))
    }

    /// The colour of a value; [`MISSING`] if it has none.
    #[must_use]
    pub fn color(&self, value: f64) -> [u8; 3] {
        self.place(value).map_or(MISSING, |place| self.colors.at(place))
    }

    /// The value at a place from 0 to 1.
    #[must_use]
    pub fn value(&self, place: f64) -> f64 {
        if self.log {
            let [low, high] = [self.low, self.high].map(|x| x.max(f64::MIN_POSITIVE).ln());
            return (low + place * (high - low)).exp();
        }
        self.low * (1.0 - place) + self.high * place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outliers_do_not_set_the_range() {
        let mut values: Vec<f64> = (0..1000).map(f64::from).collect();
        values[0] = -1e9;
        values[999] = 1e9;
        let scale = ScaleOptions::default().fit(values.clone());
        assert_eq!((scale.low, scale.high, scale.beyond), (20.0, 979.0, [true; 2]));
        let signed = ScaleOptions { signed: true, ..ScaleOptions::default() }.fit(values.clone());
        assert_eq!((signed.low, signed.high), (-979.0, 979.0));
        let full = ScaleOptions { range: Range::Full, ..ScaleOptions::default() }.fit(values);
        assert_eq!((full.low, full.high, full.beyond), (-1e9, 1e9, [false; 2]));
    }

    #[test]
    fn zero_is_pale_and_what_is_no_number_is_grey() {
        let range = Range::Given(-1.0, 1.0);
        let scale = ScaleOptions { signed: true, range, ..ScaleOptions::default() }.fit([]);
        assert!(scale.color(0.0).iter().all(|&c| c > 229));
        assert_eq!(scale.color(f64::NAN), MISSING);
        assert_eq!(scale.color(f64::INFINITY), ColorMap::RedBlue.at(1.0));
        let log = ScaleOptions { log: true, ..ScaleOptions::default() };
        let scale = log.fit([f64::NAN, -4.0, 0.0, 1.0, 100.0]);
        assert_eq!((scale.low, scale.high), (1.0, 100.0));
        assert_eq!(scale.place(10.0), Some(0.5));
        assert_eq!(scale.color(0.0), MISSING);
        assert!((scale.value(0.5) - 10.0).abs() < 1e-12);
    }

    #[test]
    fn ranges_are_read_or_refused() {
        assert_eq!("auto".parse(), Ok(Range::Auto));
        assert_eq!("-1, 2.5".parse(), Ok(Range::Given(-1.0, 2.5)));
        assert_eq!("5%,95 %".parse(), Ok(Range::Percentiles(5.0, 95.0)));
        for bad in ["", "1", "2,1", "1,1", "0,inf", "a,b", "5%,95", "5%,101%", "9%,3%", "nan,1"] {
            assert!(bad.parse::<Range>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_constant_gets_the_middle_colour() {
        let scale = ScaleOptions::default().fit(vec![3.0; 9]);
        assert_eq!(scale.color(3.0), ColorMap::Viridis.at(0.5));
        let wide = Scale {
            colors: ColorMap::Viridis,
            low: -f64::MAX,
            high: f64::MAX,
            log: false,
            beyond: [false; 2],
        };
        assert_eq!(wide.place(0.0), Some(0.5));
    }
}
