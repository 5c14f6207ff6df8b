//! Legends: a colour bar for amounts, a swatch for every label.

use crate::colorbar::ColorBar;
use crate::error::RenderError;
use crate::labels::Labels;
use crate::picture::Picture;
use crate::scale::Scale;
use crate::text::{Font, Title};

/// The number of labels that a legend shows.
pub const MOST_SWATCHES: usize = 20;

/// The colour of words and numbers.
pub(crate) const INK: [u8; 3] = [20; 3];

/// The meaning of the colours.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Legend {
    /// Amounts on a scale.
    Scale(Scale),
    /// A colour for each label.
    Labels(Labels),
}

impl Legend {
    /// The scale of amounts.
    #[must_use]
    pub fn scale(&self) -> Option<Scale> {
        match self {
            Self::Scale(scale) => Some(*scale),
            Self::Labels(_) => None,
        }
    }

    /// The picture with the legend to its right, on the given background (`None`: transparent). The name of the
    /// quantity may be empty.
    ///
    /// # Errors
    /// Picture and legend together are too wide.
    pub fn beside(
        &self,
        picture: &Picture,
        name: &str,
        background: Option<[u8; 3]>,
    ) -> Result<Picture, RenderError> {
        match self {
            Self::Scale(scale) => ColorBar::new(*scale, name).beside(picture, background),
            Self::Labels(labels) => swatches_beside(labels, picture, name, background),
        }
    }
}

/// Colour and text of each shown label, and the lines below them that tell what is not shown.
pub(crate) fn swatches(labels: &Labels, most: usize) -> (Vec<([u8; 3], String)>, Vec<String>) {
    let shown = labels.values().iter().take(most.min(MOST_SWATCHES));
    let shown: Vec<_> = shown.map(|&value| (labels.color(value), value.to_string())).collect();
    let mut notes = Vec::new();
    if let Some(more @ 1..) = labels.values().len().checked_sub(shown.len()) {
        notes.push(format!("and {more} more"));
    }
    if labels.is_repeating() {
        notes.push("colours repeat".into());
    }
    (shown, notes)
}

fn swatches_beside(
    labels: &Labels,
    picture: &Picture,
    name: &str,
    background: Option<[u8; 3]>,
) -> Result<Picture, RenderError> {
    let font = Font::for_height(picture.height());
    let line = font.line();
    let step = line * 5 / 4;
    // Room for the name above and two notes below.
    let title = Title::new(font, name);
    let rows =
        (picture.height().saturating_sub(title.height(font)) / step).saturating_sub(2).max(1);
    let (shown, notes) = swatches(labels, rows as usize);
    let (gap, side) = (line / 2, line);
    let texts = shown.iter().map(|(_, text)| gap + side + gap + font.width(text));
    let widest = texts.chain(notes.iter().map(|note| gap + font.width(note))).max().unwrap_or(0);
    let strip = widest.max(gap + title.width) + gap;
    let mut whole = picture.with_strip(strip, background)?;
    let left = i64::from(picture.width() + gap);
    title.write(&mut whole, font, left, INK);
    let mut top = i64::from(title.height(font) - line / 4);
    for ([r, g, b], text) in &shown {
        whole.fill([left, top], [i64::from(side); 2], [*r, *g, *b, 255]);
        font.write(&mut whole, [left + i64::from(side + gap), top], text, INK);
        top += i64::from(step);
    }
    for note in &notes {
        font.write(&mut whole, [left, top], note, INK);
        top += i64::from(step);
    }
    Ok(whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::labels::LABEL_COLORS;

    #[test]
    fn every_label_has_its_swatch() {
        let labels = Labels::of([4.0, 1.0, 17.0]);
        let picture = Picture::new([300, 400], [255; 4]).unwrap();
        let whole = Legend::Labels(labels).beside(&picture, "segment", Some([255; 3])).unwrap();
        assert!(whole.width() > 300 && whole.height() == 400);
        // The font has 16 pixels, and the rows of swatches are 20 pixels apart.
        for (row, label) in (0..).zip([1, 4, 17]) {
            let [r, g, b] = LABEL_COLORS[label];
            assert_eq!(whole.pixel(308 + 8, 28 + 20 * row + 8), Some([r, g, b, 255]), "{label}");
        }
        assert_eq!(whole.pixel(308 + 8, 28 + 20 * 3 + 8), Some([255; 4]));
    }

    #[test]
    fn what_is_not_shown_is_named() {
        let labels = Labels::of((0..45).map(f64::from));
        let (shown, notes) = swatches(&labels, usize::MAX);
        assert_eq!(shown.len(), 20);
        assert_eq!(shown[19], (LABEL_COLORS[19], "19".to_owned()));
        assert_eq!(notes, ["and 25 more", "colours repeat"]);
        let (shown, notes) = swatches(&Labels::of([5.0, 6.0]), 1);
        assert_eq!((shown.len(), &notes[..]), (1, &["and 1 more".to_owned()][..]));
        for [width, height] in [[20, 30], [1, 1], [700, 16]] {
            let picture = Picture::new([width, height], [0; 4]).unwrap();
            for labels in [Labels::default(), labels.clone(), Labels::of([1e300])] {
                let name = "a\u{202e}b".repeat(99);
                assert!(Legend::Labels(labels).beside(&picture, &name, None).is_ok());
            }
        }
    }
}
