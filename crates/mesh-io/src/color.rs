//! Colours from 0 to 1, and as bytes.

use std::borrow::Cow;

/// The colours as bytes, if that is exact for all of them.
pub(crate) fn as_bytes(colors: &[[f32; 4]]) -> Option<Vec<[u8; 4]>> {
    colors.iter().map(exact_bytes).collect()
}

/// Whether eight bits are exact for all colours.
pub(crate) fn are_bytes(colors: &[[f32; 4]]) -> bool {
    colors.iter().all(|color| exact_bytes(color).is_some())
}

/// The colours, with white where there is none.
pub(crate) fn without_gaps(colors: &[[f32; 4]]) -> Cow<'_, [[f32; 4]]> {
    let is_gap = |color: &[f32; 4]| color[0].is_nan();
    if !colors.iter().any(is_gap) {
        return Cow::Borrowed(colors);
    }
    colors.iter().map(|color| if is_gap(color) { [1.0; 4] } else { *color }).collect()
}

/// The nearest colour in eight bits to a colour of a [`Model`](crate::Model); white if there is no colour.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast of a float beyond the range gives its end"
)]
pub fn color_in_bytes(color: &[f32; 4]) -> [u8; 4] {
    if color[0].is_nan() { [255; 4] } else { color.map(|value| (value * 255.0).round() as u8) }
}

/// A colour of eight bits from 0 to 1.
pub(crate) fn from_bytes(color: [u8; 4]) -> [f32; 4] {
    color.map(from_byte)
}

fn exact_bytes(color: &[f32; 4]) -> Option<[u8; 4]> {
    let bytes = color_in_bytes(color);
    let exact = bytes.iter().zip(color).all(|(&byte, &value)| from_byte(byte) == value);
    exact.then_some(bytes)
}

/// An eight-bit colour from 0 to 1.
fn from_byte(byte: u8) -> f32 {
    f32::from(byte) / 255.0
}
