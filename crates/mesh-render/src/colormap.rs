//! Maps from numbers between 0 and 1 to colours.

use core::fmt;
use core::str::FromStr;

use colorous::Gradient;

/// A perceptually uniform map for quantities of one sign, or a diverging map with a pale middle that stands for zero.
/// All maps can be read without colour vision: the first five grow steadily in lightness. The others become darker to
/// both sides, in hues that nearly everyone can distinguish.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum ColorMap {
    /// Dark violet over green to yellow.
    #[default]
    Viridis,
    /// Black over purple to pale yellow.
    Magma,
    /// Black over red to pale yellow.
    Inferno,
    /// Dark blue over purple to yellow.
    Plasma,
    /// Dark blue over grey to yellow.
    Cividis,
    /// Diverging: blue below, red above.
    RedBlue,
    /// Diverging: purple below, orange above.
    PurpleOrange,
    /// Diverging: teal below, brown above.
    BrownTeal,
}

/// An unknown name of a colour map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no colour map {0:?}; there are {names}", names = names())]
pub struct UnknownColorMap(pub String);

fn names() -> String {
    ColorMap::ALL.iter().map(|map| map.name()).collect::<Vec<_>>().join(", ")
}

impl ColorMap {
    /// All maps.
    pub const ALL: &'static [Self] = &[
        Self::Viridis,
        Self::Magma,
        Self::Inferno,
        Self::Plasma,
        Self::Cividis,
        Self::RedBlue,
        Self::PurpleOrange,
        Self::BrownTeal,
    ];

    /// The usual map for a quantity: viridis for one sign, blue to red for two.
    #[must_use]
    pub fn usual(signed: bool) -> Self {
        if signed { Self::RedBlue } else { Self::Viridis }
    }

    /// The name, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::Magma => "magma",
            Self::Inferno => "inferno",
            Self::Plasma => "plasma",
            Self::Cividis => "cividis",
            Self::RedBlue => "red-blue",
            Self::PurpleOrange => "purple-orange",
            Self::BrownTeal => "brown-teal",
        }
    }

    /// Whether its middle stands for zero.
    #[must_use]
    pub fn is_diverging(self) -> bool {
        matches!(self, Self::RedBlue | Self::PurpleOrange | Self::BrownTeal)
    }

    /// The colour at a place from 0 to 1; places outside get the colour of the nearer end, and NaN gets the colour of
    /// 0.
    #[must_use]
    pub fn at(self, place: f64) -> [u8; 3] {
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
        let place = if place.is_nan() { 0.0 } else { place.clamp(0.0, 1.0) };
        let color = gradient.eval_continuous(if from_above { 1.0 - place } else { place });
        [color.r, color.g, color.b]
    }

    /// The colours at `count` equidistant places, including both ends.
    #[must_use]
    pub fn table(self, count: usize) -> Vec<[u8; 3]> {
        let last = count.saturating_sub(1).max(1) as f64;
        (0..count).map(|i| self.at(i as f64 / last)).collect()
    }
}

impl fmt::Display for ColorMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ColorMap {
    type Err = UnknownColorMap;

    fn from_str(name: &str) -> Result<Self, UnknownColorMap> {
        let found = Self::ALL.iter().find(|map| map.name() == name);
        found.copied().ok_or_else(|| UnknownColorMap(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::ColorMap;

    /// Relative luminance as WCAG 2.1 defines it.
    fn luminance(color: [u8; 3]) -> f64 {
        let [r, g, b] = color.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        });
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    #[test]
    fn lightness_tells_the_value_without_hue() {
        for &map in ColorMap::ALL {
            let light: Vec<f64> = map.table(33).into_iter().map(luminance).collect();
            let grows = |part: &[f64]| part.windows(2).all(|pair| pair[0] < pair[1] + 2e-3);
            if map.is_diverging() {
                let falling: Vec<f64> = light[17..].iter().rev().copied().collect();
                assert!(grows(&light[..16]) && grows(&falling), "{map}: {light:?}");
                assert!(light[16] > 0.8, "{map}: zero is pale");
            } else {
                assert!(grows(&light), "{map}: {light:?}");
                assert!(light[32] - light[0] > 0.5, "{map}");
            }
        }
    }

    #[test]
    fn signs_have_their_colours() {
        let [red, _, blue] = ColorMap::RedBlue.at(1.0);
        assert!(red > blue);
        let [red, _, blue] = ColorMap::RedBlue.at(0.0);
        assert!(blue > red);
    }

    #[test]
    fn names_lead_back() {
        for &map in ColorMap::ALL {
            assert_eq!(map.name().parse(), Ok(map));
        }
        let error = "jet".parse::<ColorMap>().unwrap_err().to_string();
        assert!(error.contains("jet") && error.contains("viridis"), "{error}");
        assert_eq!(ColorMap::Viridis.at(f64::NAN), ColorMap::Viridis.at(0.0));
        assert_eq!(ColorMap::Magma.at(9.0), ColorMap::Magma.at(1.0));
    }
}
