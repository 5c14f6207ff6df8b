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
            Self::Jpeg => JpegFrame::of(bytes).map(|frame| frame.size),
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

    /// The largest number of bytes of a decoded pixel.
    pub(crate) fn pixel_bytes(self, bytes: &[u8]) -> u64 {
        // The depth of PNG is 16 bits at most, with four channels.
        if self == Self::Png && bytes.get(24) == Some(&16) { 8 } else { 4 }
    }

    /// The largest number of bytes for a pixel that a decoder needs besides the decoded pixel.
    pub(crate) fn working_bytes(self, bytes: &[u8]) -> u64 {
        match (self, JpegFrame::of(bytes)) {
            // All coefficients, of 16 bits, until the last scan is read.
            (Self::Jpeg, Some(frame)) if frame.has_scans => 2 * u64::from(frame.components),
            _ => 0,
        }
    }
}

/// The first frame header of a JPEG file.
struct JpegFrame {
    size: [u32; 2],
    components: u8,
    /// Whether several scans define a pixel.
    has_scans: bool,
}

impl JpegFrame {
    fn of(bytes: &[u8]) -> Option<Self> {
        let mut segments = JpegSegments(bytes.get(2..)?);
        let (progressive, size, components) = segments.find_map(|segment| match *segment {
            // Markers of frame headers, not of tables.
            [
                marker @ (0xC0..=0xC3 | 0xC5..=0xC7 | 0xC9..=0xCB | 0xCD..=0xCF),
                _,
                _,
                _,
                h,
                l,
                w,
                v,
                count,
                ..,
            ] => {
                let size = [[w, v], [h, l]].map(|side| u32::from(u16::from_be_bytes(side)));
                Some((marker % 4 == 2, size, count))
            }
            _ => None,
        })?;
        let is_partial =
            |segment: &[u8]| matches!(*segment, [0xDA, _, _, count, ..] if count < components);
        let has_scans = progressive || segments.any(is_partial);
        Some(Self { size, components, has_scans })
    }
}

/// The segments up to the data of the first scan, each from its marker on.
struct JpegSegments<'b>(&'b [u8]);

impl<'b> Iterator for JpegSegments<'b> {
    type Item = &'b [u8];

    fn next(&mut self) -> Option<&'b [u8]> {
        // Segments begin with 0xFF, any number of times, and a marker.
        let fill = self.0.iter().take_while(|&&byte| byte == 0xFF).count();
        let segment = self.0.get(fill..)?;
        let end = match (fill, segment) {
            // No segment, or the end.
            (0, _) | (_, [] | [0x00 | 0xD9, ..]) => return None,
            (_, [0xDA, ..]) => segment.len(),
            // Markers without data.
            (_, [0x01 | 0xD0..=0xD8, ..]) => 1,
            (_, &[_, h, l, ..]) => 1 + usize::from(u16::from_be_bytes([h, l])).max(2),
            _ => segment.len(),
        };
        self.0 = segment.get(end..).unwrap_or_default();
        Some(segment)
    }
}
