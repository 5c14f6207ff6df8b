//! Colours of files with a range other than 0 to 1.

use crate::model::Model;

/// Colours with channels above this use another range. Channels between 1 and this are treated as rounding errors.
const ABOVE_ONE: f32 = 1.5;

/// If this share of the channels is between 0 and 1, brighter channels are light beyond white, as in colours from a
/// renderer. In a range up to 255, such channels are almost black, and few.
const SHARE_BELOW_ONE: f64 = 0.1;

/// The colour of a vertex or a face without one in a file where others have one.
pub(crate) const NO_COLOR: [f32; 4] = [f32::NAN; 4];

/// Divides colours above 1 by the value of full intensity, and adds a note. Light beyond white stays. A vertex without a
/// colour becomes white; a face stays without.
pub(crate) fn to_unit_range(model: &mut Model) {
    divide(model);
    let colors = model.vertex_colors.iter_mut().flatten();
    let missing = colors.filter(|color| color.iter().all(|value| value.is_nan()));
    missing.for_each(|color| *color = [1.0; 4]);
}

fn divide(model: &mut Model) {
    for (colors, of) in [(&mut model.vertex_colors, "vertices"), (&mut model.face_colors, "faces")]
    {
        let Some(colors) = colors else { continue };
        match range(colors.iter()) {
            Range::Unit => {}
            Range::BeyondWhite(most) => model
                .notes
                .push(format!("colours of {of} are up to {most}: kept as light beyond white")),
            Range::UpTo([full, full_opacity]) => {
                for [channels @ .., opacity] in colors.iter_mut() {
                    channels.iter_mut().for_each(|value| *value /= full);
                    *opacity /= full_opacity;
                }
                let full = full.max(full_opacity);
                model.notes.push(format!("colours of {of} are above 1: divided by {full}"));
            }
        }
    }
}

/// The range of colours.
pub(crate) enum Range {
    /// From 0 to 1.
    Unit,
    /// From 0 to 1, and brighter light up to this value.
    BeyondWhite(f32),
    /// From 0 to these values for full intensity and full opacity.
    UpTo([f32; 2]),
}

pub(crate) fn range<'c>(colors: impl Iterator<Item = &'c [f32; 4]> + Clone) -> Range {
    let largest = |from: usize, to: usize| {
        let channels = colors.clone().flat_map(|color| &color[from..to]);
        channels.copied().filter(|value| value.is_finite()).fold(0.0, f32::max)
    };
    let (most, opacity) = (largest(0, 3), largest(3, 4));
    if most > ABOVE_ONE && is_beyond_white(colors) {
        return Range::BeyondWhite(most);
    }
    // A colour without opacity is opaque, which is 1 in any range.
    let full_opacity = if opacity > ABOVE_ONE { full_intensity(opacity) } else { 1.0 };
    match [full_intensity(most), full_opacity] {
        [1.0, 1.0] => Range::Unit,
        full => Range::UpTo(full),
    }
}

/// Whether many channels are between 0 and 1, rounding errors apart.
fn is_beyond_white<'c>(colors: impl Iterator<Item = &'c [f32; 4]>) -> bool {
    let (mut bright, mut dim) = (0_u64, 0_u64);
    for &channel in colors.flat_map(|color| &color[..3]) {
        bright += u64::from(channel >= 0.99);
        dim += u64::from(channel > 0.0 && channel < 0.99);
    }
    dim as f64 >= SHARE_BELOW_ONE * (dim + bright) as f64
}

/// The value of full intensity, if the largest channel is `most`.
pub(crate) fn full_intensity(most: f32) -> f32 {
    match most {
        most if most <= ABOVE_ONE => 1.0,
        most if most <= 255.0 => 255.0,
        most if most <= 65535.0 => 65535.0,
        most => most,
    }
}
