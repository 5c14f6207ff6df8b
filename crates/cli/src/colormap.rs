//! Options for the conversion of numbers to colours.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use mesh_render::{ColorMap, Range, Scale, ScaleOptions};

/// The options of [`ColorOptions`].
pub(crate) const COLOR_OPTIONS: [&str; 2] = ["colormap", "range"];

/// How numbers become colours.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Colours")]
pub(crate) struct ColorOptions {
    /// The colours [default: viridis for quantities of one sign, red-blue for signed ones]
    #[arg(long, value_parser = color_map())]
    pub(crate) colormap: Option<ColorMap>,
    /// The values at the ends of the colours; `auto` leaves out the outer 2 %, `full` leaves out
    /// nothing, and 5%,95% are percentiles
    #[arg(
        long,
        value_name = "LO,HI|auto|full",
        default_value = "auto",
        allow_hyphen_values = true
    )]
    pub(crate) range: Range,
}

fn color_map() -> impl TypedValueParser<Value = ColorMap> {
    let names = ColorMap::ALL.iter().map(|map| map.name());
    PossibleValuesParser::new(names).try_map(|name| name.parse::<ColorMap>())
}

impl ColorOptions {
    /// The colours for these values.
    pub(crate) fn scale(&self, signed: bool, values: Vec<f64>) -> Scale {
        self.options(signed, false).fit(values)
    }

    /// How values become colours; `log`: equal steps of colour are equal ratios.
    pub(crate) fn options(&self, signed: bool, log: bool) -> ScaleOptions {
        ScaleOptions { colors: self.colormap, range: self.range, signed, log }
    }

    /// The ends of the colours, if they are given.
    pub(crate) fn given_range(&self) -> Option<[f64; 2]> {
        match self.range {
            Range::Given(low, high) => Some([low, high]),
            _ => None,
        }
    }

    /// Describes the meaning of the colours.
    pub(crate) fn explain(&self, scale: &Scale) -> String {
        let Scale { low, high, .. } = scale;
        format!("colours run from {low:.4e} to {high:.4e} ({})", self.range.origin())
    }
}

/// A colour as stored in files.
pub(crate) fn opaque([red, green, blue]: [u8; 3]) -> [f32; 4] {
    let [red, green, blue] = [red, green, blue].map(|c| f32::from(c) / 255.0);
    [red, green, blue, 1.0]
}
