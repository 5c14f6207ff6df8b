//! Several pictures in one.

use crate::error::RenderError;
use crate::picture::{Picture, check_size};
use crate::text::Font;

/// Options for the layout of pictures.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
pub struct SheetOptions {
    /// Number of columns; 0 makes the sheet about square.
    pub columns: u32,
    /// Pixels between pictures.
    pub gap: u32,
    /// The colour of the background; `None` for transparent.
    pub background: Option<[u8; 3]>,
    /// The colour of captions.
    pub ink: [u8; 3],
}

impl Default for SheetOptions {
    fn default() -> Self {
        Self { columns: 0, gap: 12, background: Some([255; 3]), ink: [20; 3] }
    }
}

/// Pictures in rows and columns, each with its caption below; there is no room for captions if all are empty. Columns
/// are as wide as their widest picture, rows as high as their highest.
///
/// # Errors
/// There are no pictures, or the sheet is too large.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the size is limited, and all places are within"
)]
pub fn sheet(
    pictures: &[(Picture, String)],
    options: &SheetOptions,
) -> Result<Picture, RenderError> {
    let count = pictures.len();
    let highest = pictures.iter().map(|(p, _)| p.height()).max().ok_or(RenderError::NoPictures)?;
    let columns = match options.columns as usize {
        0 => (count as f64).sqrt().ceil() as usize,
        columns => columns.min(count),
    };
    let font = Font::for_height(highest);
    let has_captions = pictures.iter().any(|(_, caption)| !caption.is_empty());
    let caption = if has_captions { u64::from(font.line()) * 3 / 2 } else { 0 };
    let widths: Vec<u64> = (0..columns)
        .map(|c| pictures.iter().skip(c).step_by(columns).map(|(p, _)| p.width()).max())
        .map(|width| u64::from(width.unwrap_or(0)))
        .collect();
    let heights: Vec<u64> = pictures
        .chunks(columns)
        .map(|row| row.iter().map(|(p, _)| u64::from(p.height())).max().unwrap_or(0) + caption)
        .collect();
    let gap = u64::from(options.gap);
    let whole = |parts: &[u64]| parts.iter().sum::<u64>() + gap * (parts.len() as u64 - 1);
    let size = [whole(&widths), whole(&heights)];
    check_size(size)?;
    let behind = options.background.map_or([255, 255, 255, 0], |[r, g, b]| [r, g, b, 255]);
    let mut result = Picture::new(size.map(|n| n as u32), behind)?;
    let mut top = 0;
    for (row, height) in pictures.chunks(columns).zip(heights) {
        let mut left = 0;
        for ((picture, text), &width) in row.iter().zip(&widths) {
            let x = left + (width - u64::from(picture.width())) / 2;
            result.paste(picture, [x as u32, top as u32]);
            let text = font.fit(text, width as u32);
            let text_left = left + (width - u64::from(font.width(&text)).min(width)) / 2;
            let text_top = top + height - caption + u64::from(font.line()) / 4;
            font.write(&mut result, [text_left as i64, text_top as i64], &text, options.ink);
            left += width + gap;
        }
        top += height + gap;
    }
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_side_by_side_and_below_each_other() {
        let colors = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]];
        let picture = |color| (Picture::new([30, 20], color).unwrap(), String::new());
        let pictures = colors.map(picture);
        let two = SheetOptions { columns: 2, gap: 4, ..SheetOptions::default() };
        let whole = sheet(&pictures, &two).unwrap();
        assert_eq!([whole.width(), whole.height()], [64, 44]);
        assert_eq!(whole.pixel(5, 5), Some(colors[0]));
        assert_eq!(whole.pixel(40, 5), Some(colors[1]));
        assert_eq!(whole.pixel(5, 30), Some(colors[2]));
        assert_eq!(whole.pixel(40, 30), Some([255; 4]));
        assert_eq!(whole.pixel(32, 5), Some([255; 4]));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        assert!(matches!(sheet(&[], &SheetOptions::default()), Err(RenderError::NoPictures)));
        let wide = Picture::new([9000, 1], [0; 4]).unwrap();
        let pictures = [(wide.clone(), "a".to_owned()), (wide, String::new())];
        let row = SheetOptions { columns: 2, ..SheetOptions::default() };
        assert!(matches!(sheet(&pictures, &row), Err(RenderError::Size { .. })));
    }
}
