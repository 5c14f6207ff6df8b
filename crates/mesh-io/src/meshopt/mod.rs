//! The codec of the glTF extensions `EXT_meshopt_compression` and `KHR_meshopt_compression`, without glTF.
//!
//! Streams come from files, so every decoder checks each byte that it reads, and never reads or writes outside its
//! data. The text of the extensions defines the formats:
//! <https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_meshopt_compression>

pub(crate) mod attributes;
pub(crate) mod filters;
pub(crate) mod indices;
pub(crate) mod stream;
pub(crate) mod triangles;

#[cfg(test)]
mod tests;

use filters::Filter;
use stream::Broken;

/// The form of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Values of any kind, with a filter that is applied after decoding.
    Attributes(Filter),
    /// Lists of triangles.
    Triangles,
    /// Indices of any kind.
    Indices,
}

impl Mode {
    pub(crate) fn is_index(self) -> bool {
        matches!(self, Self::Triangles | Self::Indices)
    }
}

/// Decodes `count` values of `stride` bytes. The memory of the result must be there.
pub(crate) fn decode(
    mode: Mode,
    count: usize,
    stride: usize,
    bytes: &[u8],
) -> Result<Vec<u8>, Broken> {
    let fits = match mode {
        Mode::Attributes(filter) => filter.fits(stride),
        Mode::Triangles => matches!(stride, 2 | 4) && count.is_multiple_of(3),
        Mode::Indices => matches!(stride, 2 | 4),
    };
    if !fits || count.checked_mul(stride).is_none() {
        return Err(Broken::Layout { count, stride });
    }
    match mode {
        Mode::Attributes(filter) => {
            let mut values = attributes::decode(bytes, count, stride)?;
            filter.apply(&mut values, stride);
            Ok(values)
        }
        Mode::Triangles => Ok(packed(&triangles::decode(bytes, count / 3)?, stride)),
        Mode::Indices => Ok(packed(&indices::decode(bytes, count)?, stride)),
    }
}

/// Encodes values of `stride` bytes without a filter. `None` if they have no such form.
pub(crate) fn encode(mode: Mode, stride: usize, bytes: &[u8]) -> Option<Vec<u8>> {
    let indices = || -> Vec<u32> {
        if stride == 2 {
            bytes.as_chunks().0.iter().map(|&index| u16::from_le_bytes(index).into()).collect()
        } else {
            bytes.as_chunks().0.iter().map(|&index| u32::from_le_bytes(index)).collect()
        }
    };
    let is_index = matches!(stride, 2 | 4);
    match mode {
        Mode::Attributes(Filter::None) => {
            let fits = Filter::None.fits(stride) && bytes.len().is_multiple_of(stride);
            fits.then(|| attributes::encode(bytes, stride))
        }
        Mode::Triangles => {
            let fits = is_index && bytes.len().is_multiple_of(3 * stride);
            fits.then(|| triangles::encode(indices().as_chunks().0))
        }
        Mode::Indices => {
            let fits = is_index && bytes.len().is_multiple_of(stride);
            if fits { indices::encode(&indices()) } else { None }
        }
        Mode::Attributes(_) => None,
    }
}

/// Indices of 2 or 4 bytes; longer ones lose their upper bytes, as the format says.
fn packed(indices: &[u32], stride: usize) -> Vec<u8> {
    let bytes = indices.iter().map(|index| index.to_le_bytes());
    if stride == 2 {
        bytes.flat_map(|[a, b, _, _]| [a, b]).collect()
    } else {
        bytes.flatten().collect()
    }
}
