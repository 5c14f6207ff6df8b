//! Colours from 0 to 1, and as bytes.

/// The colours as bytes, if that is exact for all of them.
pub(crate) fn as_bytes(colors: &[[f32; 4]]) -> Option<Vec<[u8; 4]>> {
    colors.iter().map(exact_bytes).collect()
}

/// Whether eight bits are exact for all colours.
pub(crate) fn are_bytes(colors: &[[f32; 4]]) -> bool {
    colors.iter().all(|color| exact_bytes(color).is_some())
}

/// The nearest colour in eight bits.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast of a float beyond the range gives its end"
)]
pub(crate) fn to_bytes(color: &[f32; 4]) -> [u8; 4] {
    color.map(|value| (value * 255.0).round() as u8)
}

/// A colour of eight bits from 0 to 1.
pub(crate) fn from_bytes(color: [u8; 4]) -> [f32; 4] {
    color.map(from_byte)
}

fn exact_bytes(color: &[f32; 4]) -> Option<[u8; 4]> {
    let bytes = to_bytes(color);
    let exact = bytes.iter().zip(color).all(|(&byte, &value)| from_byte(byte) == value);
    exact.then_some(bytes)
}

/// An eight-bit colour from 0 to 1.
fn from_byte(byte: u8) -> f32 {
    f32::from(byte) / 255.0
}
