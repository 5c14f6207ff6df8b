//! The values of accessors, with every index checked.

use crate::error::{Location, ReadErrorKind};
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root, buffer::View};

/// Values that no buffer backs may be this many, beside one per byte of the buffers.
const FREE_ZEROS: u64 = 1 << 20;

/// A document with the bytes of its buffers.
pub(super) struct Document {
    pub root: Root,
    pub buffers: Vec<Vec<u8>>,
}

/// Where the values of an accessor are.
struct Source<'d> {
    bytes: &'d [u8],
    stride: usize,
}

pub(super) fn at(path: &str) -> Location {
    Location::Json(path.to_owned())
}

/// The error for an index that leads nowhere.
pub(super) fn no_such(path: &str, what: &str, index: usize, count: usize) -> ReadErrorKind {
    ReadErrorKind::malformed(at(path), format!("one of {count} {what}"), index.to_string())
}

impl Document {
    /// The number of bytes in all buffers.
    pub(super) fn bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.len() as u64).sum()
    }

    pub(super) fn accessor(
        &self,
        index: Index<Accessor>,
        path: &str,
    ) -> Result<&Accessor, ReadErrorKind> {
        let all = &self.root.accessors;
        all.get(index.value()).ok_or_else(|| no_such(path, "accessors", index.value(), all.len()))
    }

    /// The bytes of a view, and the distance of its values when given.
    pub(super) fn view(
        &self,
        index: Index<View>,
        path: &str,
    ) -> Result<(&[u8], Option<usize>), ReadErrorKind> {
        let all = &self.root.buffer_views;
        let view = all
            .get(index.value())
            .ok_or_else(|| no_such(path, "buffer views", index.value(), all.len()))?;
        let buffer = self
            .buffers
            .get(view.buffer.value())
            .ok_or_else(|| no_such(path, "buffers", view.buffer.value(), self.buffers.len()))?;
        let start = view.byte_offset.unwrap_or_default().0;
        let bytes = usize::try_from(start)
            .ok()
            .zip(usize::try_from(start.saturating_add(view.byte_length.0)).ok())
            .and_then(|(start, end)| buffer.get(start..end));
        let bytes = bytes.ok_or_else(|| {
            let expected = format!("a view within the {} bytes of its buffer", buffer.len());
            let found = format!("{} bytes from {start}", view.byte_length.0);
            ReadErrorKind::malformed(
                at(&format!("bufferViews[{}]", index.value())),
                expected,
                found,
            )
        })?;
        Ok((bytes, view.byte_stride.map(|stride| stride.0)))
    }

    /// The values of an accessor of `N` components as numbers, normalised if it says so; `fill`
    /// stands for components that the accessor lacks.
    pub(super) fn floats<const N: usize>(
        &self,
        index: Index<Accessor>,
        path: &str,
        widths: std::ops::RangeInclusive<usize>,
        fill: f32,
    ) -> Result<Vec<[f32; N]>, ReadErrorKind> {
        let accessor = self.accessor(index, path)?;
        let (kind, width) = layout(accessor, path)?;
        if !widths.contains(&width) {
            let found = format!("{width} components");
            return Err(ReadErrorKind::malformed(
                at(path),
                format!("{} to {} components", widths.start(), widths.end()),
                found,
            ));
        }
        let mut values = Vec::new();
        self.each(accessor, path, |index, bytes| {
            let mut value = [fill; N];
            for (component, bytes) in value.iter_mut().zip(bytes.chunks_exact(size(kind))) {
                *component = decode(bytes, kind, accessor.normalized) as f32;
            }
            match values.get_mut(index) {
                Some(slot) => *slot = value,
                None => values.push(value),
            }
        })?;
        Ok(values)
    }

    /// The values of an accessor of indices.
    pub(super) fn indices(
        &self,
        index: Index<Accessor>,
        path: &str,
    ) -> Result<Vec<u32>, ReadErrorKind> {
        let accessor = self.accessor(index, path)?;
        let (kind, width) = layout(accessor, path)?;
        let integer = matches!(kind, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
        if width != 1 || !integer {
            return Err(ReadErrorKind::malformed(
                at(path),
                "unsigned integers",
                format!("{kind:?}"),
            ));
        }
        let mut values = Vec::new();
        self.each(accessor, path, |index, bytes| {
            let value = decode(bytes, kind, false) as u32;
            match values.get_mut(index) {
                Some(slot) => *slot = value,
                None => values.push(value),
            }
        })?;
        Ok(values)
    }

    /// Calls `put` with the bytes of every value in order, then with those that a sparse accessor
    /// replaces.
    fn each(
        &self,
        accessor: &Accessor,
        path: &str,
        mut put: impl FnMut(usize, &[u8]),
    ) -> Result<(), ReadErrorKind> {
        let (kind, width) = layout(accessor, path)?;
        let length = width * size(kind);
        let count = accessor.count.0;
        if let Some(view) = accessor.buffer_view {
            let offset = accessor.byte_offset.unwrap_or_default().0;
            let source = self.source(view, offset, count, length, path)?;
            for index in 0..count as usize {
                let start = index * source.stride;
                put(index, source.bytes.get(start..start + length).unwrap_or_default());
            }
        } else {
            let limit = FREE_ZEROS + self.bytes();
            if count > limit {
                let expected = format!("no more than {limit} values without a buffer view");
                return Err(ReadErrorKind::malformed(at(path), expected, count.to_string()));
            }
            let zeros = [0; 64];
            for index in 0..count as usize {
                put(index, zeros.get(..length).unwrap_or_default());
            }
        }
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        let Checked::Valid(index_kind) = sparse.indices.component_type else {
            return Err(ReadErrorKind::malformed(at(path), "a type of sparse indices", "another"));
        };
        let (sparse_count, width) = (sparse.count.0, size(index_kind.0));
        let (from, to) = (&sparse.indices, &sparse.values);
        let indices =
            self.source(from.buffer_view, from.byte_offset.0, sparse_count, width, path)?;
        let values = self.source(to.buffer_view, to.byte_offset.0, sparse_count, length, path)?;
        for place in 0..sparse_count as usize {
            let bytes = &indices.bytes[place * indices.stride..][..width];
            let index = decode(bytes, index_kind.0, false) as u64;
            if index >= count {
                let expected = format!("sparse indices below {count}");
                return Err(ReadErrorKind::malformed(at(path), expected, index.to_string()));
            }
            put(index as usize, &values.bytes[place * values.stride..][..length]);
        }
        Ok(())
    }

    /// The bytes of `count` values of `length` bytes each, known to be there.
    fn source(
        &self,
        view: Index<View>,
        offset: u64,
        count: u64,
        length: usize,
        path: &str,
    ) -> Result<Source<'_>, ReadErrorKind> {
        let (bytes, stride) = self.view(view, path)?;
        let stride = stride.unwrap_or(length);
        let span = count.saturating_sub(1).saturating_mul(stride as u64);
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

/// The type and number of the components of a value.
fn layout(accessor: &Accessor, path: &str) -> Result<(ComponentType, usize), ReadErrorKind> {
    let (Checked::Valid(kind), Checked::Valid(shape)) = (accessor.component_type, accessor.type_)
    else {
        return Err(ReadErrorKind::malformed(at(path), "a known type of values", "another"));
    };
    let width = match shape {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 | Type::Mat2 => 4,
        Type::Mat3 => 9,
        Type::Mat4 => 16,
    };
    Ok((kind.0, width))
}

fn size(kind: ComponentType) -> usize {
    match kind {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

/// A component; normalised integers become -1 to 1 or 0 to 1.
fn decode(bytes: &[u8], kind: ComponentType, normalized: bool) -> f64 {
    let (value, full) = match (kind, bytes) {
        (ComponentType::I8, &[b]) => (f64::from(b as i8), f64::from(i8::MAX)),
        (ComponentType::U8, &[b]) => (f64::from(b), f64::from(u8::MAX)),
        (ComponentType::I16, &[a, b]) => {
            (f64::from(i16::from_le_bytes([a, b])), f64::from(i16::MAX))
        }
        (ComponentType::U16, &[a, b]) => {
            (f64::from(u16::from_le_bytes([a, b])), f64::from(u16::MAX))
        }
        (ComponentType::U32, &[a, b, c, d]) => {
            (f64::from(u32::from_le_bytes([a, b, c, d])), f64::from(u32::MAX))
        }
        (_, &[a, b, c, d]) => return f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => (0.0, 1.0),
    };
    if normalized { (value / full).max(-1.0) } else { value }
}
