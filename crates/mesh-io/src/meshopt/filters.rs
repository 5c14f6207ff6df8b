//! Filters of values: what is decoded stands for something else.

/// A filter of values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Filter {
    /// The values are as they are decoded.
    #[default]
    None,
    /// Directions on an octahedron; the third number says how many bits they have.
    Octahedral,
    /// Rotations without their largest component; the fourth number says which one and how many bits there are.
    Quaternion,
    /// Numbers as a mantissa of 24 bits and an exponent.
    Exponential,
    /// Colours as brightness and two differences; the highest bit of the fourth number says how many bits they have.
    Color,
}

impl Filter {
    /// Whether values can have this size.
    pub(crate) fn fits(self, stride: usize) -> bool {
        match self {
            Self::None | Self::Exponential => {
                stride.is_multiple_of(4) && (4..=256).contains(&stride)
            }
            Self::Octahedral | Self::Color => matches!(stride, 4 | 8),
            Self::Quaternion => stride == 8,
        }
    }

    /// Replaces decoded values by what they stand for.
    pub(crate) fn apply(self, values: &mut [u8], stride: usize) {
        match (self, stride) {
            (Self::None, _) => {}
            (Self::Octahedral, 4) => {
                for value in values.as_chunks_mut::<4>().0 {
                    let [x, y, one, rest] = value.map(u8::cast_signed);
                    let [x, y, z] = octahedral([x, y, one].map(f32::from), 127.0);
                    *value =
                        [rounded_i8(x), rounded_i8(y), rounded_i8(z), rest].map(i8::cast_unsigned);
                }
            }
            (Self::Octahedral, _) => each_words(values, |words| {
                let [x, y, one, rest] = words.map(u16::cast_signed);
                let [x, y, z] = octahedral([x, y, one].map(f32::from), 32767.0);
                [rounded_i16(x), rounded_i16(y), rounded_i16(z), rest].map(i16::cast_unsigned)
            }),
            (Self::Quaternion, _) => each_words(values, quaternion),
            (Self::Exponential, _) => {
                for value in values.as_chunks_mut::<4>().0 {
                    *value = exponential(i32::from_le_bytes(*value)).to_le_bytes();
                }
            }
            (Self::Color, 4) => {
                for value in values.as_chunks_mut::<4>().0 {
                    let [y, co, cg, alpha] = *value;
                    let [co, cg] = [co, cg].map(|byte| i32::from(byte.cast_signed()));
                    *value = color(i32::from(y), [co, cg], u32::from(alpha), 255.0).map(rounded_u8);
                }
            }
            (Self::Color, _) => each_words(values, |[y, co, cg, alpha]| {
                let [co, cg] = [co, cg].map(|word| i32::from(word.cast_signed()));
                color(i32::from(y), [co, cg], u32::from(alpha), 65535.0).map(rounded_u16)
            }),
        }
    }
}

fn each_words(values: &mut [u8], mut map: impl FnMut([u16; 4]) -> [u16; 4]) {
    for value in values.as_chunks_mut::<8>().0 {
        let [a, b, c, d, e, f, g, h] = *value;
        let words = [[a, b], [c, d], [e, f], [g, h]].map(u16::from_le_bytes);
        let [[a, b], [c, d], [e, f], [g, h]] = map(words).map(u16::to_le_bytes);
        *value = [a, b, c, d, e, f, g, h];
    }
}

/// A unit vector times `scale`. A third number of zero, which is invalid, gives numbers that are not finite.
fn octahedral([x, y, one]: [f32; 3], scale: f32) -> [f32; 3] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    let below = z.min(0.0);
    let (x, y) = (x - below.copysign(x), y - below.copysign(y));
    let factor = scale / (x * x + y * y + z * z).sqrt();
    [x * factor, y * factor, z * factor]
}

fn quaternion(words: [u16; 4]) -> [u16; 4] {
    let [x, y, z, last] = words.map(u16::cast_signed);
    let factor = std::f32::consts::FRAC_1_SQRT_2 / f32::from(last | 3);
    let [x, y, z] = [x, y, z].map(|component| f32::from(component) * factor);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut all = [w, x, y, z].map(|c| rounded_i16(c * 32767.0).cast_unsigned());
    // The largest component has this place, and the others follow in a circle.
    all.rotate_right(usize::from(last.cast_unsigned() & 3));
    all
}

fn exponential(code: i32) -> f32 {
    // Exponents beyond ±100 are invalid; these limits keep the power of two a normal number.
    let exponent = (code >> 24).clamp(-126, 127);
    let power = f32::from_bits((exponent + 127).cast_unsigned() << 23);
    // A mantissa of 24 bits is exact in this type.
    power * ((code << 8) >> 8) as f32
}

fn color(y: i32, [co, cg]: [i32; 2], alpha: u32, scale: f32) -> [f32; 4] {
    // All bits below the highest one of alpha, and that one.
    let all = u32::MAX.checked_shr(alpha.leading_zeros()).unwrap_or(0);
    let half = alpha & (all >> 1);
    // The highest bit only marks the number of bits, so that alpha has one less than the others.
    let alpha = (half << 1 | half & 1).cast_signed();
    // An alpha of zero, which is invalid, gives numbers that are not finite.
    let factor = scale / all as f32;
    [y + co - cg, y + cg, y - co - cg, alpha].map(|component| component as f32 * factor)
}

#[expect(clippy::cast_possible_truncation, reason = "rounded, and clamped by the cast")]
fn rounded_i8(value: f32) -> i8 {
    value.round() as i8 // clamped by the cast; NaN is 0
}

#[expect(clippy::cast_possible_truncation, reason = "rounded, and clamped by the cast")]
fn rounded_i16(value: f32) -> i16 {
    value.round() as i16 // clamped by the cast; NaN is 0
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rounded, and clamped by the cast"
)]
fn rounded_u8(value: f32) -> u8 {
    value.round() as u8 // clamped by the cast; NaN is 0
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rounded, and clamped by the cast"
)]
fn rounded_u16(value: f32) -> u16 {
    value.round() as u16 // clamped by the cast; NaN is 0
}
