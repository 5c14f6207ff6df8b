//! Numbers to colours.

use std::str::FromStr;

use clap::ValueEnum;
use colorous::Gradient;

/// A perceptually uniform map for quantities of one sign, or a diverging one, whose middle is pale
/// and stands for zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ColorMap {
    Viridis,
    Magma,
    Inferno,
    Plasma,
    Cividis,
    /// Diverging: blue below, red above
    RedBlue,
    /// Diverging: purple below, orange above
    PurpleOrange,
    /// Diverging: teal below, brown above
    BrownTeal,
}

impl ColorMap {
    /// What suits a quantity.
    pub(crate) fn usual(signed: bool) -> Self {
        if signed { Self::RedBlue } else { Self::Viridis }
    }

    /// The colour at a place from 0 to 1.
    fn at(self, place: f64) -> [f32; 4] {
        let (gradient, from_above): (Gradient, bool) = match self {
            Self::Viridis => (colorous::VIRIDIS, false),
            Self::Magma => (colorous::MAGMA, false),
            Self::Inferno => (colorous::INFERNO, false),
            Self::Plasma => (colorous::PLASMA, false),
            Self::Cividis => (colorous::CIVIDIS, false),
            Self::RedBlue => (colorous::RED_BLUE, true),
            Self::PurpleOrange => (colorous::PURPLE_ORANGE, false),
            Self::BrownTeal => (colorous::BROWN_GREEN, true),
        };
        let color = gradient.eval_continuous(if from_above { 1.0 - place } else { place });
        let [r, g, b] = [color.r, color.g, color.b].map(|c| f32::from(c) / 255.0);
        [r, g, b, 1.0]
    }
}

/// The values at the ends of the colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Range {
    /// From the values: their 2nd to 98th percentile, made symmetric for signed quantities.
    Auto,
    Given(f64, f64),
}

impl Range {
    pub(crate) fn origin(self) -> &'static str {
        match self {
            Self::Auto => "2nd to 98th percentile",
            Self::Given(..) => "as given",
        }
    }
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let ends = text.split_once(',').and_then(|(low, high)| {
            Some((low.trim().parse::<f64>().ok()?, high.trim().parse::<f64>().ok()?))
        });
        match ends {
            Some((low, high)) if low.is_finite() && high.is_finite() && low < high => {
                Ok(Self::Given(low, high))
            }
            _ => Err("expected `auto` or two growing numbers, like -1,1".into()),
        }
    }
}

/// The options of [`ColorOptions`].
pub(crate) const COLOR_OPTIONS: [&str; 2] = ["colormap", "range"];

/// How numbers become colours.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Colours")]
pub(crate) struct ColorOptions {
    /// The colours [default: viridis for quantities of one sign, red-blue for signed ones]
    #[arg(long, value_enum)]
    colormap: Option<ColorMap>,
    /// The values at the ends of the colours; `auto` leaves out the outer 2 % of the vertices
    #[arg(long, value_name = "LO,HI|auto", default_value = "auto", allow_hyphen_values = true)]
    range: Range,
}

impl ColorOptions {
    /// The colours for these values.
    pub(crate) fn scale(&self, signed: bool, values: Vec<f64>) -> Scale {
        let colors = self.colormap.unwrap_or(ColorMap::usual(signed));
        Scale::new(colors, self.range, signed, values)
    }

    /// Says what the colours stand for.
    pub(crate) fn explain(&self, scale: &Scale) -> String {
        let Scale { low, high, .. } = scale;
        format!("colours run from {low:.4e} to {high:.4e} ({})", self.range.origin())
    }
}

/// A colour map with the values at its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    colors: ColorMap,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// The share of the values that the automatic range leaves out at each end.
const OUTLIERS: f64 = 0.02;

impl Scale {
    pub(crate) fn new(colors: ColorMap, range: Range, signed: bool, values: Vec<f64>) -> Self {
        let (low, high) = match range {
            Range::Given(low, high) => (low, high),
            Range::Auto => automatic(values, signed),
        };
        Self { colors, low, high }
    }

    /// The colour of a value; values beyond the ends get the colour of the end.
    pub(crate) fn color(&self, value: f64) -> [f32; 4] {
        let extent = self.high - self.low;
        let place = if extent > 0.0 { (value - self.low) / extent } else { 0.5 };
        self.colors.at(place.clamp(0.0, 1.0))
    }
}

/// The range without outliers; for signed quantities, zero stays in the middle.
fn automatic(mut values: Vec<f64>, signed: bool) -> (f64, f64) {
    let Some(last) = values.len().checked_sub(1) else { return (0.0, 0.0) };
    let mut percentile = |share: f64| {
        let rank = (share * last as f64).round() as usize;
        *values.select_nth_unstable_by(rank, f64::total_cmp).1
    };
    let (low, high) = (percentile(OUTLIERS), percentile(1.0 - OUTLIERS));
    if signed {
        let reach = low.abs().max(high.abs());
        (-reach, reach)
    } else {
        (low, high)
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
        let scale = Scale::new(ColorMap::Viridis, Range::Auto, false, values.clone());
        assert_eq!((scale.low, scale.high), (20.0, 979.0));
        let signed = Scale::new(ColorMap::RedBlue, Range::Auto, true, values);
        assert_eq!((signed.low, signed.high), (-979.0, 979.0));
    }

    #[test]
    fn zero_is_pale_and_signs_have_their_colours() {
        let scale = Scale::new(ColorMap::RedBlue, Range::Given(-1.0, 1.0), true, Vec::new());
        assert!(scale.color(0.0)[..3].iter().all(|&c| c > 0.9));
        let [red, _, blue, _] = scale.color(5.0);
        assert!(red > blue);
        let [red, _, blue, _] = scale.color(-5.0);
        assert!(blue > red);
    }

    #[test]
    fn ranges_are_read_or_refused() {
        assert_eq!("auto".parse(), Ok(Range::Auto));
        assert_eq!("-1, 2.5".parse(), Ok(Range::Given(-1.0, 2.5)));
        for bad in ["", "1", "2,1", "1,1", "0,inf", "a,b"] {
            assert!(bad.parse::<Range>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_constant_gets_the_middle_colour() {
        let scale = Scale::new(ColorMap::Viridis, Range::Auto, false, vec![3.0; 9]);
        assert_eq!(scale.color(3.0), ColorMap::Viridis.at(0.5));
    }
}
