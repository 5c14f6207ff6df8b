//! Arrays as text: compact binary data in base64, each array in its own element.

use std::collections::HashMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;

/// The data elements of a page, which the script addresses by number.
#[derive(Default)]
pub(crate) struct Blobs<'p> {
    pub(crate) elements: String,
    count: usize,
    /// The number of each picture, by its bytes.
    pictures: HashMap<&'p [u8], usize>,
}

impl<'p> Blobs<'p> {
    /// Adds a picture and returns its number. Equal pictures are stored once.
    pub(crate) fn picture(&mut self, bytes: &'p [u8]) -> usize {
        if let Some(&number) = self.pictures.get(bytes) {
            return number;
        }
        let number = self.bytes(bytes);
        self.pictures.insert(bytes, number);
        number
    }

    /// Adds an array and returns its number.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) -> usize {
        let number = self.count;
        self.count += 1;
        self.elements.push_str(&format!("<script type=\"text/plain\" id=\"b{number}\">"));
        STANDARD.encode_string(bytes, &mut self.elements);
        self.elements.push_str("</script>\n");
        number
    }

    /// Adds integers; consecutive ones should be close to each other.
    pub(crate) fn integers(&mut self, values: impl IntoIterator<Item = u32>) -> usize {
        self.bytes(&integers(values))
    }

    /// Adds 32-bit numbers.
    pub(crate) fn floats(&mut self, values: impl IntoIterator<Item = f32>) -> usize {
        let bytes: Vec<u8> = values.into_iter().flat_map(f32::to_le_bytes).collect();
        self.bytes(&bytes)
    }
}

/// Differences between consecutive numbers, in zigzag order (0, -1, 1, -2, ... become 0, 1, 2, 3, ...), in groups of
/// seven bits from the lowest on. The eighth bit means that another group follows.
fn integers(values: impl IntoIterator<Item = u32>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut last = 0_u32;
    for value in values {
        let difference = value.wrapping_sub(last).cast_signed();
        last = value;
        let mut rest = ((difference << 1) ^ (difference >> 31)).cast_unsigned();
        while rest > 127 {
            bytes.push(rest.to_le_bytes()[0] | 128);
            rest >>= 7;
        }
        bytes.push(rest.to_le_bytes()[0]);
    }
    bytes
}

/// The rounding errors of 32-bit numbers, relative to the gap between adjacent ones. Together with them, the numbers
/// have nine digits. `None` if there are no errors.
#[expect(clippy::cast_possible_truncation, reason = "-127 to 127")]
pub(crate) fn remainders(values: &[f64]) -> Option<Vec<u8>> {
    let remainder = |&value: &f64| {
        let rounded = value as f32;
        if !rounded.is_finite() || rounded == 0.0 {
            return 0;
        }
        let exponent = ((rounded.to_bits() >> 23) & 255).max(1);
        let step = 2_f64.powi(exponent.cast_signed() - 150);
        ((value - f64::from(rounded)) / step * 254.0).round().clamp(-127.0, 127.0) as i8
    };
    let all: Vec<i8> = values.iter().map(remainder).collect();
    let is_any = all.iter().any(|&r| r != 0);
    is_any.then(|| all.into_iter().map(i8::cast_unsigned).collect())
}

/// A unit vector folded onto an octahedron, one byte per axis; (255, 255) if there is no vector. (Meyer et al. 2010, On
/// floating-point normal vectors.)
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 254")]
pub(crate) fn octahedral(vector: Option<DVec3>) -> [u8; 2] {
    let Some(v) = vector.filter(|v| v.is_finite()) else { return [255; 2] };
    let sum = v.abs().element_sum();
    if sum == 0.0 {
        return [255; 2];
    }
    let (mut x, mut y) = (v.x / sum, v.y / sum);
    if v.z < 0.0 {
        let sign = |t: f64| if t < 0.0 { -1.0 } else { 1.0 };
        (x, y) = ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y));
    }
    [x, y].map(|t| ((t + 1.0) * 127.0).round().clamp(0.0, 254.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(bytes: &[u8]) -> Vec<u32> {
        let (mut values, mut last, mut group, mut shift) = (Vec::new(), 0_u32, 0_u32, 0);
        for &byte in bytes {
            group |= u32::from(byte & 127) << shift;
            shift += 7;
            if byte < 128 {
                last = last.wrapping_add((group >> 1) ^ (group & 1).wrapping_neg());
                values.push(last);
                (group, shift) = (0, 0);
            }
        }
        values
    }

    #[test]
    fn integers_come_back_and_neighbours_take_a_byte() {
        let values = vec![0, 1, 2, 60, 3, u32::MAX, 0, 1 << 31, 7, 7];
        assert_eq!(decoded(&integers(values.clone())), values);
        assert_eq!(integers(0..1000).len(), 1000);
    }

    #[test]
    fn two_parts_give_nine_digits() {
        let values: Vec<f64> =
            (1..2000).map(|i| (f64::from(i) * 0.37).sin() * 10_f64.powi(i % 60 - 30)).collect();
        let rest = remainders(&values).unwrap();
        for (&value, &rest) in values.iter().zip(&rest) {
            let rounded = value as f32;
            let exponent = ((rounded.to_bits() >> 23) & 255).max(1) as i32;
            let back =
                f64::from(rounded) + f64::from(rest as i8) / 254.0 * 2_f64.powi(exponent - 150);
            assert!((back / value - 1.0).abs() < 3e-10, "{value} {back}");
        }
        assert_eq!(remainders(&[0.5, -3.0, 0.0, f64::NAN, f64::INFINITY]), None);
    }

    #[test]
    fn directions_keep_to_a_degree() {
        for i in 0..500 {
            let t = f64::from(i);
            let v = DVec3::new((t * 1.7).sin(), (t * 0.9).cos(), (t * 2.3).sin()).normalize();
            let [x, y] = octahedral(Some(v)).map(|b| f64::from(b) / 127.0 - 1.0);
            let z = 1.0 - x.abs() - y.abs();
            let fold = |a: f64, b: f64| (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 };
            let back =
                if z < 0.0 { DVec3::new(fold(x, y), fold(y, x), z) } else { DVec3::new(x, y, z) };
            assert!(back.normalize().dot(v) > 1_f64.to_radians().cos(), "{v} {back}");
        }
        assert_eq!(octahedral(None), [255; 2]);
        assert_eq!(octahedral(Some(DVec3::ZERO)), [255; 2]);
    }
}
