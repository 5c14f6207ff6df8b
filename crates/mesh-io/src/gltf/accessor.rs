//! The values of accessors, with every index checked.

use super::compressed::decompress;
use super::parts::part;
pub(crate) use super::parts::{Bytes, at, item, no_such};
use super::schema::{Accessor, Root, Shape, SparsePart};
use crate::color_range::full_intensity;
use crate::error::ReadErrorKind;
use crate::scalars::ScalarType;

/// A document with the bytes of its buffers.
pub(crate) struct Document {
    pub root: Root,
    pub buffers: Vec<Bytes>,
}

/// The location of the values of an accessor.
struct Source<'d> {
    bytes: &'d [u8],
    stride: usize,
}

impl Source<'_> {
    fn value(&self, index: usize, length: usize) -> &[u8] {
        let start = index * self.stride;
        self.bytes.get(start..start + length).unwrap_or_default()
    }
}

/// The type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// The values of an accessor, already checked to exist.
pub(crate) struct Values<'d> {
    /// The path of the user of the accessor, for errors.
    path: &'d str,
    count: usize,
    /// The bytes of a value.
    length: usize,
    kind: Kind,
    normalized: bool,
    /// `None` if all values are zero.
    source: Option<Source<'d>>,
    sparse: Option<SparseValues<'d>>,
}

/// Values that replace others.
struct SparseValues<'d> {
    count: usize,
    kind: Kind,
    indices: Source<'d>,
    values: Source<'d>,
}

impl Document {
    pub(crate) fn accessor(&self, index: u32, path: &str) -> Result<&Accessor, ReadErrorKind> {
        item(&self.root.accessors, index, "accessors", path)
    }

    /// The number of values of an accessor.
    pub(crate) fn count(&self, index: u32, path: &str) -> Result<u64, ReadErrorKind> {
        Ok(self.accessor(index, path)?.count)
    }

    /// The bytes of a view, and the stride of its values if given.
    pub(crate) fn view(
        &self,
        index: u32,
        path: &str,
    ) -> Result<(&[u8], Option<usize>), ReadErrorKind> {
        let view = item(&self.root.buffer_views, index, "buffer views", path)?;
        let stride = view.byte_stride.map(|stride| stride as usize);
        let buffer = item(&self.buffers, view.buffer, "buffers", path)?.get();
        if let Some(compressed) = view.extensions.compressed()
            && buffer.is_empty()
        {
            return Ok((decompress(&self.buffers, index, view, compressed)?, stride));
        }
        let place = || at(&format!("bufferViews[{index}]"));
        Ok((part(buffer, view.byte_offset, view.byte_length, place)?, stride))
    }

    /// The number of components of the values of an accessor.
    pub(crate) fn width(&self, index: u32, path: &str) -> Result<usize, ReadErrorKind> {
        Ok(width(self.accessor(index, path)?.shape))
    }

    /// The bytes of a value of an accessor.
    pub(crate) fn value_size(
        &self,
        accessor: &Accessor,
        path: &str,
    ) -> Result<usize, ReadErrorKind> {
        Ok(width(accessor.shape) * size(kind(accessor.component_type, path)?))
    }

    /// The values of an accessor with this number of components.
    ///
    /// The time does not depend on the number of values, because values are requested before it is known whether the
    /// mesh fits into memory.
    pub(crate) fn values<'d>(
        &'d self,
        index: u32,
        path: &'d str,
        widths: std::ops::RangeInclusive<usize>,
    ) -> Result<Values<'d>, ReadErrorKind> {
        let accessor = self.accessor(index, path)?;
        let (kind, width) = (kind(accessor.component_type, path)?, width(accessor.shape));
        if !widths.contains(&width) {
            let expected = format!("{} to {} components", widths.start(), widths.end());
            let found = format!("{width} components");
            return Err(ReadErrorKind::malformed(at(path), expected, found));
        }
        let length = width * size(kind);
        let count = usize::try_from(accessor.count)
            .map_err(|_| ReadErrorKind::from(mesh_core::soup::TooManyCorners))?;
        let source = accessor
            .buffer_view
            .map(|view| self.source(view, accessor.byte_offset, count, length, path))
            .transpose()?
            .or(accessor.decoded.as_deref().map(|bytes| Source { bytes, stride: length }));
        let sparse = accessor.sparse.as_ref().map(|sparse| {
            if sparse.count > accessor.count {
                let expected = format!("no more than {count} sparse values");
                return Err(ReadErrorKind::malformed(at(path), expected, sparse.count.to_string()));
            }
            let (from, to): (&SparsePart, &SparsePart) = (&sparse.indices, &sparse.values);
            let kind = self::kind(from.component_type, path)?;
            let sparse_count = sparse.count as usize;
            let of = |part: &SparsePart, length| {
                self.source(part.buffer_view, part.byte_offset, sparse_count, length, path)
            };
            let (indices, values) = (of(from, size(kind))?, of(to, length)?);
            Ok(SparseValues { count: sparse_count, kind, indices, values })
        });
        let sparse = sparse.transpose()?;
        Ok(Values { path, count, length, kind, normalized: accessor.normalized, source, sparse })
    }

    /// The values of an accessor of indices.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an unsigned integer of at most 32 bits"
    )]
    pub(crate) fn indices(&self, index: u32, path: &str) -> Result<Vec<u32>, ReadErrorKind> {
        let values = self.values(index, path, 1..=1)?;
        if !matches!(values.kind, Kind::U8 | Kind::U16 | Kind::U32) {
            let found = format!("{:?}", values.kind);
            return Err(ReadErrorKind::malformed(at(path), "unsigned integers", found));
        }
        let mut indices = vec![0; values.count];
        values.each_bytes(|index, bytes| {
            if let Some(slot) = indices.get_mut(index) {
                *slot = decode(bytes, values.kind, false) as u32;
            }
        })?;
        Ok(indices)
    }

    /// The bytes of `count` values of `length` bytes each, checked to exist.
    fn source(
        &self,
        view: u32,
        offset: u64,
        count: usize,
        length: usize,
        path: &str,
    ) -> Result<Source<'_>, ReadErrorKind> {
        let (bytes, stride) = self.view(view, path)?;
        let stride = stride.unwrap_or(length);
        let span = (count as u64).saturating_sub(1).saturating_mul(stride as u64);
        let end = offset.saturating_add(span).saturating_add(length as u64);
        if stride < length || (count > 0 && end > bytes.len() as u64) {
            let expected =
                format!("{count} values of {length} bytes from byte {offset} of the view");
            let found = format!("a view of {} bytes, {stride} for a value", bytes.len());
            return Err(ReadErrorKind::malformed(at(path), expected, found));
        }
        let bytes = bytes.get(offset.min(bytes.len() as u64) as usize..).unwrap_or_default();
        Ok(Source { bytes, stride })
    }
}

impl Values<'_> {
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Whether no buffer defines the values.
    pub(crate) fn is_nothing(&self) -> bool {
        self.source.is_none() && self.sparse.is_none() && self.count > 0
    }

    /// Calls `put` with the index and the components of every value, normalised if the accessor says so; `fill`
    /// replaces missing components.
    pub(crate) fn each<const N: usize>(
        &self,
        fill: f32,
        mut put: impl FnMut(usize, [f32; N]),
    ) -> Result<(), ReadErrorKind> {
        self.each_bytes(|index, bytes| {
            let mut value = [fill; N];
            for (component, bytes) in value.iter_mut().zip(bytes.chunks_exact(size(self.kind))) {
                *component = decode(bytes, self.kind, self.normalized) as f32;
            }
            put(index, value);
        })
    }

    /// The type of the numbers in the file; floating point if they are normalised.
    pub(crate) fn scalar_type(&self) -> ScalarType {
        if self.normalized { ScalarType::F32 } else { self.component() }
    }

    /// The type of the components in the file.
    pub(crate) fn component(&self) -> ScalarType {
        match self.kind {
            Kind::I8 => ScalarType::I8,
            Kind::U8 => ScalarType::U8,
            Kind::I16 => ScalarType::I16,
            Kind::U16 => ScalarType::U16,
            Kind::U32 => ScalarType::U32,
            Kind::F32 => ScalarType::F32,
        }
    }

    /// Whether integers stand for 0 to 1, or -1 to 1.
    pub(crate) fn is_normalized(&self) -> bool {
        self.normalized
    }

    /// The bytes of all values, without gaps.
    pub(crate) fn packed(&self) -> Result<Vec<u8>, ReadErrorKind> {
        let length = self.length;
        let mut bytes = vec![0; self.count * length];
        self.each_bytes(|index, value| {
            if let Some(slot) = bytes.get_mut(index * length..(index + 1) * length) {
                slot.copy_from_slice(value);
            }
        })?;
        Ok(bytes)
    }

    /// The first value that is not finite, with its index.
    pub(crate) fn find_not_finite(&self) -> Result<Option<(usize, f64)>, ReadErrorKind> {
        let mut found = None;
        if self.kind == Kind::F32 && !self.is_nothing() {
            self.each_bytes(|index, bytes| {
                let components = bytes.as_chunks::<4>().0.iter().map(|&b| f32::from_le_bytes(b));
                if let Some(value) = components.into_iter().find(|value| !value.is_finite()) {
                    found.get_or_insert((index, f64::from(value)));
                }
            })?;
        }
        Ok(found)
    }

    /// The largest index; `None` if there are none, or no buffer gives them.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an unsigned integer of at most 32 bits, or an error later"
    )]
    pub(crate) fn largest_index(&self) -> Result<Option<u32>, ReadErrorKind> {
        let mut largest = None;
        if !self.is_nothing() {
            self.each_bytes(|_, bytes| {
                largest = largest.max(Some(decode(bytes, self.kind, false) as u32));
            })?;
        }
        Ok(largest)
    }

    /// Whether the values are plain integers.
    pub(crate) fn is_whole(&self) -> bool {
        self.scalar_type().is_integer()
    }

    /// The value that stands for full intensity, if the values are colours. It is not 1 if they are integers that are not
    /// marked as normalised: 255 for one byte, and otherwise by the largest of them.
    pub(crate) fn full_color(&self) -> Result<f32, ReadErrorKind> {
        if !self.is_whole() {
            return Ok(1.0);
        }
        if self.kind == Kind::U8 {
            return Ok(f32::from(u8::MAX));
        }
        let mut most = 0.0_f32;
        self.each(0.0, |_, color: [f32; 4]| most = color.into_iter().fold(most, f32::max))?;
        Ok(full_intensity(most))
    }

    /// Calls `put` with the index and the first component of every value.
    pub(crate) fn each_number(&self, mut put: impl FnMut(usize, f64)) -> Result<(), ReadErrorKind> {
        self.each_bytes(|index, bytes| {
            let component = bytes.get(..size(self.kind)).unwrap_or_default();
            put(index, decode(component, self.kind, self.normalized));
        })
    }

    pub(crate) fn to_vec<const N: usize>(&self, fill: f32) -> Result<Vec<[f32; N]>, ReadErrorKind> {
        let mut values = vec![[fill; N]; self.count];
        self.each(fill, |index, value| {
            if let Some(slot) = values.get_mut(index) {
                *slot = value;
            }
        })?;
        Ok(values)
    }

    /// Calls `put` with the bytes of every value in order, then with the values that replace others.
    fn each_bytes(&self, mut put: impl FnMut(usize, &[u8])) -> Result<(), ReadErrorKind> {
        let zeros = [0; 64];
        for index in 0..self.count {
            put(
                index,
                match &self.source {
                    Some(source) => source.value(index, self.length),
                    None => zeros.get(..self.length).unwrap_or_default(),
                },
            );
        }
        let Some(sparse) = &self.sparse else { return Ok(()) };
        for place in 0..sparse.count {
            let index = sparse.indices.value(place, size(sparse.kind));
            let index = decode(index, sparse.kind, false);
            if !(index >= 0.0 && index < self.count as f64) {
                let expected = format!("sparse indices below {}", self.count);
                let (at, found) = (at(self.path), index.to_string());
                return Err(ReadErrorKind::malformed(at, expected, found));
            }
            put(index as usize, sparse.values.value(place, self.length));
        }
        Ok(())
    }
}

fn kind(component_type: u32, path: &str) -> Result<Kind, ReadErrorKind> {
    Ok(match component_type {
        5120 => Kind::I8,
        5121 => Kind::U8,
        5122 => Kind::I16,
        5123 => Kind::U16,
        5125 => Kind::U32,
        5126 => Kind::F32,
        other => {
            let expected = "a component type from 5120 to 5126";
            return Err(ReadErrorKind::malformed(at(path), expected, other.to_string()));
        }
    })
}

fn width(shape: Shape) -> usize {
    match shape {
        Shape::Scalar => 1,
        Shape::Vec2 => 2,
        Shape::Vec3 => 3,
        Shape::Vec4 | Shape::Mat2 => 4,
        Shape::Mat3 => 9,
        Shape::Mat4 => 16,
    }
}

fn size(kind: Kind) -> usize {
    match kind {
        Kind::I8 | Kind::U8 => 1,
        Kind::I16 | Kind::U16 => 2,
        Kind::U32 | Kind::F32 => 4,
    }
}

/// A component; normalised integers become -1 to 1 or 0 to 1.
fn decode(bytes: &[u8], kind: Kind, normalized: bool) -> f64 {
    let (value, full) = match (kind, bytes) {
        (Kind::I8, &[b]) => (f64::from(b.cast_signed()), f64::from(i8::MAX)),
        (Kind::U8, &[b]) => (f64::from(b), f64::from(u8::MAX)),
        (Kind::I16, &[a, b]) => (f64::from(i16::from_le_bytes([a, b])), f64::from(i16::MAX)),
        (Kind::U16, &[a, b]) => (f64::from(u16::from_le_bytes([a, b])), f64::from(u16::MAX)),
        (Kind::U32, &[a, b, c, d]) => {
            (f64::from(u32::from_le_bytes([a, b, c, d])), f64::from(u32::MAX))
        }
        (_, &[a, b, c, d]) => return f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => (0.0, 1.0),
    };
    if normalized { (value / full).max(-1.0) } else { value }
}
