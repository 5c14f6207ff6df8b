//! Pixels.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::error::RenderError;

/// The longest side of a picture in pixels.
pub const LARGEST_SIDE: u32 = 16_384;

/// A picture with eight bits per channel: red, green, blue and opacity (not premultiplied), row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 4]>,
}

impl Picture {
    /// A picture of one colour.
    ///
    /// # Errors
    /// A side is zero or longer than [`LARGEST_SIDE`].
    pub fn new([width, height]: [u32; 2], color: [u8; 4]) -> Result<Self, RenderError> {
        check_size([u64::from(width), u64::from(height)])?;
        Ok(Self { width, height, pixels: vec![color; width as usize * height as usize] })
    }

    /// A picture of these rows, all of one length. The size was checked by `check_size`.
    pub(crate) fn from_pixels([width, height]: [u32; 2], pixels: Vec<[u8; 4]>) -> Self {
        Self { width, height, pixels }
    }

    /// Pixels per row.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, row by row from the top.
    #[must_use]
    pub fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// The pixel in a column and a row, `None` outside.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        self.index(i64::from(x), i64::from(y)).map(|i| self.pixels[i])
    }

    fn index(&self, x: i64, y: i64) -> Option<usize> {
        let inside =
            (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y);
        inside.then(|| y as usize * self.width as usize + x as usize)
    }

    /// Paints a rectangle; parts outside the picture are ignored.
    pub(crate) fn fill(&mut self, [x, y]: [i64; 2], [width, height]: [i64; 2], color: [u8; 4]) {
        for row in y..y + height {
            for column in x..x + width {
                self.blend([column, row], color);
            }
        }
    }

    /// Blends a colour over a pixel by its opacity; pixels outside the picture are ignored.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
    pub(crate) fn blend(&mut self, [x, y]: [i64; 2], color: [u8; 4]) {
        let Some(index) = self.index(x, y) else { return };
        let below = self.pixels[index];
        let [cover, under] = [color[3], below[3]].map(|a| f32::from(a) / 255.0);
        let opacity = cover + under * (1.0 - cover);
        let mix = |i: usize| {
            let sum = f32::from(color[i]) * cover + f32::from(below[i]) * under * (1.0 - cover);
            (sum / opacity.max(f32::MIN_POSITIVE)).round() as u8
        };
        self.pixels[index] = [mix(0), mix(1), mix(2), (255.0 * opacity).round() as u8];
    }

    /// A copy with a strip to its right, in the colour of the background (`None`: transparent).
    pub(crate) fn with_strip(
        &self,
        strip: u32,
        background: Option<[u8; 3]>,
    ) -> Result<Self, RenderError> {
        let behind = background.map_or([255, 255, 255, 0], |[r, g, b]| [r, g, b, 255]);
        let mut whole = Self::new([self.width.saturating_add(strip), self.height], behind)?;
        whole.paste(self, [0, 0]);
        Ok(whole)
    }

    /// Copies a picture into this one, with its upper left corner at a pixel.
    pub(crate) fn paste(&mut self, other: &Self, [x, y]: [u32; 2]) {
        let width = other.width.min(self.width.saturating_sub(x)) as usize;
        let rows = other.pixels.chunks_exact(other.width as usize);
        for (row, pixels) in (y..self.height).zip(rows) {
            let start = row as usize * self.width as usize + x as usize;
            self.pixels[start..start + width].copy_from_slice(&pixels[..width]);
        }
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    /// The encoder fails, for lack of memory.
    pub fn to_png(&self) -> Result<Vec<u8>, RenderError> {
        let mut bytes = Vec::new();
        let is_opaque = self.pixels.iter().all(|p| p[3] == 255);
        // Pictures are stored and sent: smaller files are worth the time.
        let (compression, filter) = (CompressionType::Default, FilterType::Adaptive);
        let encoder = PngEncoder::new_with_quality(&mut bytes, compression, filter);
        let written = if is_opaque {
            let rgb: Vec<u8> = self.pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
            encoder.write_image(&rgb, self.width, self.height, ExtendedColorType::Rgb8)
        } else {
            let rgba = self.pixels.as_flattened();
            encoder.write_image(rgba, self.width, self.height, ExtendedColorType::Rgba8)
        };
        written.map_err(Box::new)?;
        Ok(bytes)
    }
}

/// Whether a picture can have this size.
pub(crate) fn check_size([width, height]: [u64; 2]) -> Result<(), RenderError> {
    let sides = 1..=u64::from(LARGEST_SIDE);
    if sides.contains(&width) && sides.contains(&height) {
        return Ok(());
    }
    Err(RenderError::Size { width, height, largest: LARGEST_SIDE })
}
