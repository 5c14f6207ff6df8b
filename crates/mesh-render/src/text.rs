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

    /// The text in lines of at most this width where words allow it. Words end at spaces and after `_`.
    pub(crate) fn lines(self, text: &str, pixels: u32) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_inclusive([' ', '_']) {
            match lines.last_mut() {
                Some(line) if self.width(&format!("{line}{}", word.trim_end())) <= pixels => {
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines.iter().map(|line| line.trim_end().to_owned()).collect()
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

/// The name above a legend, in lines.
pub(crate) struct Title {
    lines: Vec<String>,
    /// The width of the longest line in pixels.
    pub(crate) width: u32,
}

impl Title {
    /// The longest part of a name that is shown.
    const MOST_LETTERS: usize = 80;

    /// A name in lines of about ten letters, or as long as its longest word.
    pub(crate) fn new(font: Font, name: &str) -> Self {
        let name: String = name.chars().take(Self::MOST_LETTERS).collect();
        let lines = font.lines(&name, font.width("0") * 10);
        let width = lines.iter().map(|line| font.width(line)).max().unwrap_or(0);
        Self { lines, width }
    }

    /// The height in pixels, with room below.
    pub(crate) fn height(&self, font: Font) -> u32 {
        font.line() * (as_u32(self.lines.len()).max(1) + 1)
    }

    pub(crate) fn write(&self, picture: &mut Picture, font: Font, left: i64, color: [u8; 3]) {
        let tops = (i64::from(font.line() / 4)..).step_by(font.line() as usize);
        for (line, top) in self.lines.iter().zip(tops) {
            font.write(picture, [left, top], line, color);
        }
    }
}
