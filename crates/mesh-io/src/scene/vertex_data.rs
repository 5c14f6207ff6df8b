//! The values of an attribute of vertices, in the type of the file.

use crate::scalars::ScalarType;

/// The values of one attribute of the vertices of a primitive, bit for bit as in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexData {
    /// The name of the attribute, such as `POSITION`, `TEXCOORD_1` or `_TEMPERATURE`.
    pub name: String,
    /// The type of the components.
    pub component: ScalarType,
    /// The number of components of a value.
    pub width: usize,
    /// Whether integers stand for 0 to 1, or for -1 to 1 if they are signed.
    pub normalized: bool,
    /// The values in the order of the vertices, without gaps, in little-endian order.
    pub bytes: Vec<u8>,
}

impl VertexData {
    /// An attribute of the same type without values.
    #[must_use]
    pub fn empty(&self) -> Self {
        Self { name: self.name.clone(), bytes: Vec::new(), ..*self }
    }

    /// The number of bytes of a value.
    #[must_use]
    pub fn size(&self) -> usize {
        self.width * self.component.bytes()
    }

    /// The number of values.
    #[must_use]
    pub fn count(&self) -> usize {
        self.bytes.len() / self.size().max(1)
    }

    /// The bytes of the value of a vertex; empty if there is no such vertex.
    #[must_use]
    pub fn value(&self, vertex: usize) -> &[u8] {
        let size = self.size();
        self.bytes.get(vertex * size..(vertex + 1) * size).unwrap_or_default()
    }

    /// A component of the value of a vertex, as the number in the file; 0 if there is no such vertex or component.
    #[must_use]
    pub fn get(&self, vertex: usize, component: usize) -> f64 {
        let size = self.component.bytes();
        let bytes = self.value(vertex).get(component * size..(component + 1) * size);
        bytes.map_or(0.0, |bytes| decode(bytes, self.component))
    }

    /// The largest number of the component type that stands for 1, if the values are normalised; else 1.
    #[must_use]
    pub fn one(&self) -> f64 {
        match self.component.range() {
            Some([_, most]) if self.normalized => most as f64,
            _ => 1.0,
        }
    }

    /// Appends a number in the component type to `bytes`: rounded to the nearest integer within range, if it is an
    /// integer type.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the range of the type"
    )]
    pub fn encode(&self, value: f64, bytes: &mut Vec<u8>) {
        let whole = self.component.range().map(|[least, most]| {
            // Integers of 32 bits are exact in this type.
            value.round().clamp(least as f64, most as f64)
        });
        match (self.component, whole.unwrap_or(value)) {
            (ScalarType::I8, whole) => bytes.extend((whole as i8).to_le_bytes()),
            (ScalarType::U8, whole) => bytes.extend((whole as u8).to_le_bytes()),
            (ScalarType::I16, whole) => bytes.extend((whole as i16).to_le_bytes()),
            (ScalarType::U16, whole) => bytes.extend((whole as u16).to_le_bytes()),
            (ScalarType::U32, whole) => bytes.extend((whole as u32).to_le_bytes()),
            (_, value) => bytes.extend((value as f32).to_le_bytes()),
        }
    }

    /// The code of the component type in glTF.
    pub(crate) fn code(&self) -> u32 {
        match self.component {
            ScalarType::I8 => 5120,
            ScalarType::U8 => 5121,
            ScalarType::I16 => 5122,
            ScalarType::U16 => 5123,
            ScalarType::U32 => 5125,
            _ => 5126,
        }
    }

    /// The name of the shape in glTF.
    pub(crate) fn shape(&self) -> &'static str {
        match self.width {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            _ => "VEC4",
        }
    }

    /// The least and the largest number of every component; `None` without values.
    pub(crate) fn bounds(&self) -> Option<[Vec<f64>; 2]> {
        if self.count() == 0 {
            return None;
        }
        let of =
            |component: usize| (0..self.count()).map(move |vertex| self.get(vertex, component));
        let least = (0..self.width).map(|c| of(c).fold(f64::INFINITY, f64::min)).collect();
        let most = (0..self.width).map(|c| of(c).fold(f64::NEG_INFINITY, f64::max)).collect();
        Some([least, most])
    }
}

fn decode(bytes: &[u8], component: ScalarType) -> f64 {
    match (component, bytes) {
        (ScalarType::I8, &[b]) => f64::from(b.cast_signed()),
        (ScalarType::U8, &[b]) => f64::from(b),
        (ScalarType::I16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (ScalarType::U16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (ScalarType::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (_, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => 0.0,
    }
}
