//! Text in pictures.

use mesh_core::as_u32;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use crate::picture::Picture;

/// Letters of one of three sizes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Font {
    height: RasterHeight,
}

impl Font {
    /// The font for a picture of this height.
    pub(crate) fn for_height(pixels: u32) -> Self {
        let height = match pixels {
            0..600 => RasterHeight::Size16,
            600..1200 => RasterHeight::Size24,
            _ => RasterHeight::Size32,
        };
        Self { height }
    }

    /// The height of a line in pixels.
    pub(crate) fn line(self) -> u32 {
        as_u32(self.height.val())
    }

    /// The width of a text in pixels.
    pub(crate) fn width(self, text: &str) -> u32 {
        let letters = u32::try_from(text.chars().count()).unwrap_or(u32::MAX);
        letters.saturating_mul(as_u32(get_raster_width(FontWeight::Regular, self.height)))
    }

    /// The part of the text that fits into this width.
    pub(crate) fn fit(self, text: &str, pixels: u32) -> String {
        let letters = pixels as usize / get_raster_width(FontWeight::Regular, self.height);
        if text.chars().count() <= letters {
            return text.to_owned();
        }
        text.chars().take(letters.saturating_sub(2)).chain("..".chars().take(letters)).collect()
    }

    /// Writes a line with its upper left corner at a pixel; characters missing in the font become `?`.
    pub(crate) fn write(self, picture: &mut Picture, [x, y]: [i64; 2], text: &str, color: [u8; 3]) {
        let mut left = x;
        for letter in text.chars() {
            let raster = get_raster(letter, FontWeight::Regular, self.height)
                .or_else(|| get_raster('?', FontWeight::Regular, self.height));
            let Some(raster) = raster else { continue };
            for (row, line) in (y..).zip(raster.rows()) {
                for (column, &cover) in (left..).zip(line) {
                    let [r, g, b] = color;
                    picture.blend([column, row], [r, g, b, cover]);
                }
            }
            left += raster.width() as i64;
        }
    }
}
