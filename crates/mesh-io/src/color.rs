//! Colours: from 0 to 1, and in eight bits.

use crate::model::Model;

/// Channels above this are not from 0 to 1. Channels between 1 and this are taken for rounding.
const ABOVE_ONE: f32 = 1.5;

/// Divides colours that are above 1 by the value that stands for full intensity, and says so in the notes.
pub(crate) fn to_unit_range(model: &mut Model) {
    for (colors, of) in [(&mut model.vertex_colors, "vertices"), (&mut model.face_colors, "faces")]
    {
        let Some(colors) = colors else { continue };
        let largest = |from: usize, to: usize| {
            let channels = colors.iter().flat_map(|color| &color[from..to]);
            channels.copied().filter(|value| value.is_finite()).fold(0.0, f32::max)
        };
        let (most, opacity) = (largest(0, 3), largest(3, 4));
        // A colour without an opacity is opaque, which is 1 in any range.
        let full = full_intensity(most);
        let full_opacity = if opacity > ABOVE_ONE { full_intensity(opacity) } else { 1.0 };
        if full == 1.0 && full_opacity == 1.0 {
            continue;
        }
        for [channels @ .., opacity] in colors.iter_mut() {
            channels.iter_mut().for_each(|value| *value /= full);
            *opacity /= full_opacity;
        }
        let full = full.max(full_opacity);
        model.notes.push(format!("colours of {of} are above 1: divided by {full}"));
    }
}

/// The value that stands for full intensity where the largest channel is `most`.
fn full_intensity(most: f32) -> f32 {
    match most {
        most if most <= ABOVE_ONE => 1.0,
        most if most <= 255.0 => 255.0,
        most if most <= 65535.0 => 65535.0,
        most => most,
    }
}

/// A colour in eight bits, when that is exact for all of them.
pub(crate) fn as_bytes(colors: &[[f32; 4]]) -> Option<Vec<[u8; 4]>> {
    colors.iter().map(exact_bytes).collect()
}

/// Whether eight bits are exact for all colours.
pub(crate) fn are_bytes(colors: &[[f32; 4]]) -> bool {
    colors.iter().all(|color| exact_bytes(color).is_some())
}

/// The nearest colour in eight bits.
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
