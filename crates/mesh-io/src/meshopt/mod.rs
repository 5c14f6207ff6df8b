//! The codec of the glTF extensions `EXT_meshopt_compression` and `KHR_meshopt_compression`, without glTF.
//!
//! Streams come from files, so every decoder checks each byte that it reads, and never reads or writes outside its
//! data. The formats are those of the text of the extensions:
//! <https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_meshopt_compression>

pub(crate) mod attributes;
pub(crate) mod filters;
pub(crate) mod indices;
pub(crate) mod triangles;

#[cfg(test)]
mod tests;

use filters::Filter;

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

/// The reason why a stream cannot be decoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Broken {
    /// The values cannot have this size, or not this number.
    #[error("{count} values of {stride} bytes, which this kind of compression does not have")]
    Layout { count: usize, stride: usize },
    /// The first byte belongs to another form or version.
    #[error("data that start with the byte {0:#04x}")]
    Header(u8),
    /// The stream is too short.
    #[error("data that end too early")]
    Short,
    /// The stream is too long.
    #[error("{0} bytes too many")]
    Long(usize),
    /// The differences are stored in an unknown way.
    #[error("the unknown channel mode {0:#04x}")]
    Channel(u8),
    /// The table of the corners refers to corners that are stored apart.
    #[error("a table of corners that is out of range")]
    Table,
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

/// The unread part of a stream.
struct Reader<'b>(&'b [u8]);

impl<'b> Reader<'b> {
    fn byte(&mut self) -> Result<u8, Broken> {
        let (&first, rest) = self.0.split_first().ok_or(Broken::Short)?;
        self.0 = rest;
        Ok(first)
    }

    fn take(&mut self, count: usize) -> Result<&'b [u8], Broken> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(Broken::Short)?;
        self.0 = rest;
        Ok(taken)
    }

    /// A number in groups of seven bits, least significant first. Bits beyond the 32nd are ignored.
    fn number(&mut self) -> Result<u32, Broken> {
        let mut number = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                break;
            }
        }
        Ok(number)
    }

    fn end(&self) -> Result<(), Broken> {
        if self.0.is_empty() { Ok(()) } else { Err(Broken::Long(self.0.len())) }
    }
}

/// The signed number that a zigzag code stands for, modulo 2³².
fn unzigzag(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}

/// The code of a signed number.
fn zigzag(number: i32) -> u32 {
    ((number << 1) ^ (number >> 31)).cast_unsigned()
}

/// Appends a number in groups of seven bits, least significant first.
fn write_number(stream: &mut Vec<u8>, mut number: u32) {
    loop {
        let [low, ..] = number.to_le_bytes();
        number >>= 7;
        if number == 0 {
            stream.push(low & 0x7f);
            return;
        }
        stream.push(low | 0x80);
    }
}
