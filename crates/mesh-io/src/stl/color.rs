//! Colours of the facets of binary STL, in the two bytes after the corners.
//!
//! Both conventions have five bits per channel. VisCAM and SolidView set the highest bit if a facet has a colour, and
//! store blue in the lowest bits. Magics clears the highest bit if a facet has a colour, stores red in the lowest bits,
//! and writes the colour of all other facets into the header, after `COLOR=`.

use super::header;
use crate::color::from_bytes;

/// The bit that tells whether a facet has its own colour.
const FLAG: u16 = 1 << 15;

/// The convention for colours of facets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum StlColors {
    /// The convention of VisCAM and SolidView.
    #[default]
    Viscam,
    /// The convention of Materialise Magics.
    Magics,
}

/// The convention for reading colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Convention {
    Viscam,
    /// The convention of Magics, with the colour of the facets without their own.
    Magics([f32; 4]),
}

impl Convention {
    /// Detects the convention from the header.
    pub(super) fn of(header: &[u8]) -> Self {
        header::color(header).map_or(Self::Viscam, |color| Self::Magics(from_bytes(color)))
    }

    /// The colour of a facet from its two bytes; `None` for a facet without colour.
    pub(super) fn color(self, attribute: u16) -> Option<[f32; 4]> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
        let channel = |shift: u32| {
            let five = f32::from((attribute >> shift) & 31);
            (five * 255.0 / 31.0).round() as u8
        };
        let [low, middle, high] = [channel(0), channel(5), channel(10)];
        let has_own = attribute & FLAG != 0;
        match self {
            Self::Viscam => has_own.then(|| from_bytes([high, middle, low, 255])),
            Self::Magics(of_object) if has_own => Some(of_object),
            Self::Magics(_) => Some(from_bytes([low, middle, high, 255])),
        }
    }
}

impl StlColors {
    /// The two bytes of a facet with this colour; NaN means no colour.
    pub(super) fn attribute(self, color: [f32; 4]) -> u16 {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 31")]
        let [r, g, b] = [color[0], color[1], color[2]]
            .map(|value| (value.clamp(0.0, 1.0) * 31.0).round() as u16);
        match (self, color[0].is_nan()) {
            (Self::Viscam, true) => 0,
            (Self::Viscam, false) => FLAG | r << 10 | g << 5 | b,
            (Self::Magics, true) => FLAG,
            (Self::Magics, false) => b << 10 | g << 5 | r,
        }
    }

    /// The colour of the facets without a colour, for the header: white.
    pub(super) fn of_object(self) -> Option<[u8; 4]> {
        match self {
            Self::Viscam => None,
            Self::Magics => Some([255; 4]),
        }
    }
}
