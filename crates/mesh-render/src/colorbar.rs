//! The colour bar: a legend for the colours.

use crate::error::RenderError;
use crate::picture::Picture;
use crate::scale::Scale;
use crate::text::{Font, Title};
use crate::ticks;

/// A bar with the colours of a scale, round numbers beside it and a name above it.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorBar {
    /// The colours and the values at their ends.
    pub scale: Scale,
    /// The quantity and its unit; may be empty.
    pub label: String,
    /// The colour of numbers and words.
    pub ink: [u8; 3],
}

impl ColorBar {
    /// A bar with dark text.
    #[must_use]
    pub fn new(scale: Scale, label: impl Into<String>) -> Self {
        Self { scale, label: label.into(), ink: [20; 3] }
    }

    /// The picture with the bar to its right, on the given background (`None`: transparent).
    ///
    /// # Errors
    /// Picture and bar together are too wide.
    pub fn beside(
        &self,
        picture: &Picture,
        background: Option<[u8; 3]>,
    ) -> Result<Picture, RenderError> {
        let font = Font::for_height(picture.height());
        let line = font.line();
        let marks = self.marks();
        let widest = marks.iter().map(|(_, text)| font.width(text)).max().unwrap_or(0);
        let (gap, bar) = (line / 2, line);
        let title = Title::new(font, &self.label);
        let strip = (gap + bar + gap + widest).max(gap + title.width) + gap;
        let mut whole = picture.with_strip(strip, background)?;
        let left = i64::from(picture.width() + gap);
        let arrow = i64::from(gap);
        let [below, above] = self.scale.beyond;
        // Room for the name above and half a line below, and for arrows.
        let top = i64::from(title.height(font)) + arrow * i64::from(above);
        let end = i64::from(picture.height()) - i64::from(line) - arrow * i64::from(below);
        let bottom = end.max(top + 1);
        let place = |row: i64| (bottom - row) as f64 / (bottom - top) as f64;
        for row in top..bottom {
            let [r, g, b] = self.scale.colors.at(place(row));
            whole.fill([left, row], [i64::from(bar), 1], [r, g, b, 255]);
        }
        for (is_there, row, step, end) in [(above, top - 1, -1, 1.0), (below, bottom, 1, 0.0)] {
            if is_there {
                let color = self.scale.colors.at(end);
                self.arrow(&mut whole, [left, row], [i64::from(bar), arrow * step], color);
            }
        }
        let [r, g, b] = self.ink;
        for (at, text) in &marks {
            let row = bottom - (at * (bottom - top) as f64).round() as i64;
            let right = left + i64::from(bar);
            whole.fill([right, row.min(bottom - 1)], [i64::from(gap / 2), 1], [r, g, b, 255]);
            let text_top = row - i64::from(line / 2);
            font.write(&mut whole, [right + i64::from(gap), text_top], text, self.ink);
        }
        title.write(&mut whole, font, left, self.ink);
        Ok(whole)
    }

    /// An arrow with its base at one end of the bar and an outline: values go on beyond the end. The height is negative
    /// upward.
    fn arrow(
        &self,
        picture: &mut Picture,
        [x, y]: [i64; 2],
        [width, height]: [i64; 2],
        color: [u8; 3],
    ) {
        for step in 0..height.abs() {
            let inset = width * step / (2 * height.abs());
            let row = y + step * height.signum();
            for column in x + inset..x + width - inset {
                let is_rim = column < x + inset + 2 || column >= x + width - inset - 2;
                let [r, g, b] = if is_rim { self.ink } else { color };
                picture.blend([column, row], [r, g, b, 255]);
            }
        }
    }

    /// Round values in the range: the place of each, and its text.
    pub(crate) fn marks(&self) -> Vec<(f64, String)> {
        let Scale { low, high, log, .. } = self.scale;
        let ticks = if log { ticks::log(low, high) } else { ticks::linear(low, high, 6) };
        let ticks = if ticks.len() < 2 { vec![low, high] } else { ticks };
        let mark = |tick: f64| Some((self.scale.place(tick)?, ticks::label(tick)));
        let mut marks: Vec<(f64, String)> = ticks.into_iter().filter_map(mark).collect();
        marks.dedup_by(|a, b| a.1 == b.1);
        marks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colormap::ColorMap;

    #[test]
    fn the_bar_has_the_colours_of_the_scale_from_bottom_to_top() {
        let scale = Scale {
            colors: ColorMap::Viridis,
            low: -1.0,
            high: 3.0,
            log: false,
            beyond: [false; 2],
        };
        let picture = Picture::new([300, 400], [255; 4]).unwrap();
        let whole = ColorBar::new(scale, "H").beside(&picture, Some([255; 3])).unwrap();
        assert!(whole.width() > 300 && whole.height() == 400);
        let column = 300 + 8 + 2;
        let top = whole.pixel(column, 32).unwrap();
        let bottom = whole.pixel(column, 383).unwrap();
        let near = |a: [u8; 4], b: [u8; 3]| (0..3).all(|i| a[i].abs_diff(b[i]) <= 2);
        assert!(near(top, ColorMap::Viridis.at(1.0)), "{top:?}");
        assert!(near(bottom, ColorMap::Viridis.at(0.0)), "{bottom:?}");
        let labels: Vec<String> =
            ColorBar::new(scale, "").marks().into_iter().map(|(_, text)| text).collect();
        assert_eq!(labels, ["-1", "0", "1", "2", "3"]);
    }

    #[test]
    fn arrows_say_that_values_go_on() {
        let colors = ColorMap::Viridis;
        let bar = |beyond| {
            let scale = Scale { colors, low: 0.0, high: 1.0, log: false, beyond };
            let picture = Picture::new([300, 400], [255; 4]).unwrap();
            ColorBar::new(scale, "H").beside(&picture, Some([255; 3])).unwrap()
        };
        // Whether an outline is at the upper and at the lower end.
        let ends = |beyond: [bool; 2]| {
            let whole = bar(beyond);
            let is_ink = |y: u32| (308..324).any(|x| whole.pixel(x, y) == Some([20, 20, 20, 255]));
            [(32..40).any(is_ink), (376..384).any(is_ink)]
        };
        assert_eq!(ends([false, false]), [false, false]);
        assert_eq!(ends([true, false]), [false, true]);
        assert_eq!(ends([false, true]), [true, false]);
    }

    #[test]
    fn names_are_whole() {
        let scale = Scale {
            colors: ColorMap::Viridis,
            low: 0.0,
            high: 1.0,
            log: false,
            beyond: [false; 2],
        };
        let picture = Picture::new([300, 400], [255; 4]).unwrap();
        let width = |name: &str| ColorBar::new(scale, name).beside(&picture, None).unwrap().width();
        assert!(width("gaussian_curvature") < width("gaussiancurvature_"));
        assert!(width("abcdefghijklmnopqrstuvwx") > 300 + 24 * 7);
    }

    #[test]
    fn any_scale_has_a_bar() {
        let picture = Picture::new([20, 30], [0; 4]).unwrap();
        for [low, high] in [[0.0, 0.0], [2.0, 1.0], [f64::NAN, 1.0], [-1e308, 1e308]] {
            for log in [false, true] {
                let beyond = [true; 2];
                let scale = Scale { colors: ColorMap::RedBlue, low, high, log, beyond };
                assert!(
                    ColorBar::new(scale, "a\u{202e}b".repeat(99)).beside(&picture, None).is_ok()
                );
            }
        }
    }
}
