//! Formats of pictures, detected by their first bytes, and the size in their header.

/// The format of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum PictureFormat {
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
    /// WebP.
    WebP,
    /// KTX 2.0.
    Ktx2,
}

impl PictureFormat {
    /// All formats.
    pub const ALL: &'static [Self] = &[Self::Png, Self::Jpeg, Self::WebP, Self::Ktx2];

    /// The format of a file that begins with these bytes; at least 12 bytes tell all formats. `None` for other files.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', 0x0D, 0x0A, 0x1A, 0x0A, ..] => Some(Self::Png),
            [0xFF, 0xD8, 0xFF, ..] => Some(Self::Jpeg),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(Self::WebP),
            [0xAB, b'K', b'T', b'X', b' ', b'2', b'0', 0xBB, 0x0D, 0x0A, ..] => Some(Self::Ktx2),
            _ => None,
        }
    }

    /// The name of the format.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::WebP => "WebP",
            Self::Ktx2 => "KTX2",
        }
    }

    /// The media type.
    #[must_use]
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
            Self::WebP => "image/webp",
            Self::Ktx2 => "image/ktx2",
        }
    }

    /// Width and height in pixels, as the header of a file of this format states them. `None` if it states none.
    #[must_use]
    pub fn size(self, bytes: &[u8]) -> Option<[u32; 2]> {
        let little = |at: usize, count: usize| {
            let digits = bytes.get(at..at + count)?.iter().rev();
            Some(digits.fold(0, |sum, &byte| sum << 8 | u32::from(byte)))
        };
        let size = match self {
            Self::Png => {
                let [width, height] = bytes.get(16..24)?.as_chunks::<4>().0 else { return None };
                (bytes.get(12..16)? == b"IHDR")
                    .then(|| [width, height].map(|side| u32::from_be_bytes(*side)))
            }
            Self::Jpeg => jpeg_size(bytes),
            Self::WebP => match bytes.get(12..16)? {
                b"VP8X" => Some([little(24, 3)? + 1, little(27, 3)? + 1]),
                b"VP8L" => {
                    let bits = little(21, 4)?;
                    Some([(bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1])
                }
                b"VP8 " => Some([little(26, 2)? & 0x3FFF, little(28, 2)? & 0x3FFF]),
                _ => None,
            },
            // A height of zero stands for a texture of one row.
            Self::Ktx2 => Some([little(20, 4)?, little(24, 4)?.max(1)]),
        };
        size.filter(|&[width, height]| width > 0 && height > 0)
    }

    /// The largest number of bytes that a decoder needs for a pixel.
    pub(crate) fn pixel_bytes(self, bytes: &[u8]) -> u64 {
        // The depth of PNG is 16 bits at most, with four channels.
        if self == Self::Png && bytes.get(24) == Some(&16) { 8 } else { 4 }
    }
}

/// The size in the first frame header of a JPEG file.
fn jpeg_size(bytes: &[u8]) -> Option<[u32; 2]> {
    let mut rest = bytes.get(2..)?;
    loop {
        // Segments begin with 0xFF, any number of times, and a marker.
        let fill = rest.iter().take_while(|&&byte| byte == 0xFF).count();
        let (&marker, after) = rest.get(fill..)?.split_first()?;
        match (fill, marker) {
            // Data without a header, or its end.
            (0, _) | (_, 0x00 | 0xD9 | 0xDA) => return None,
            // Markers without data.
            (_, 0x01 | 0xD0..=0xD8) => rest = after,
            // Frame headers, not tables.
            (_, 0xC0..=0xC3 | 0xC5..=0xC7 | 0xC9..=0xCB | 0xCD..=0xCF) => {
                let &[_, _, _, h, l, w, v, ..] = after else { return None };
                return Some([[w, v], [h, l]].map(|side| u32::from(u16::from_be_bytes(side))));
            }
            _ => {
                let &[h, l, ..] = after else { return None };
                rest = after.get(usize::from(u16::from_be_bytes([h, l])).max(2)..)?;
            }
        }
    }
}
