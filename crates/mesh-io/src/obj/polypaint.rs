//! Vertex colours in comments, as `ZBrush` writes them: lines of `#MRGB`, each followed by eight hexadecimal digits for
//! each of the next vertices. The first two digits are a mask.

use crate::budget::GROWING;
use crate::color::from_bytes;
use crate::input::Line;
use crate::model::Model;
use crate::notes::Notes;
use crate::scalars::Scalars;

/// The colours and masks read so far.
#[derive(Default)]
pub(super) struct Polypaint {
    entries: Vec<[u8; 4]>,
    has_errors: bool,
}

/// The digits of a line of `#MRGB`.
pub(super) fn digits<'l>(line: &Line<'l>) -> Option<&'l [u8]> {
    let digits = line.text.trim_ascii().strip_prefix(b"#MRGB")?;
    digits.first()?.is_ascii_whitespace().then(|| digits.trim_ascii())
}

impl Polypaint {
    /// Reads a line that may be a comment, and returns its memory.
    pub(super) fn line(&mut self, line: &Line<'_>) -> u64 {
        let Some(digits) = digits(line) else { return 0 };
        let (entries, rest) = digits.as_chunks::<8>();
        self.has_errors |= !rest.is_empty();
        for entry in entries {
            let value = std::str::from_utf8(entry).ok();
            let value = value.and_then(|digits| u32::from_str_radix(digits, 16).ok());
            self.has_errors |= value.is_none();
            self.entries.push(value.unwrap_or_default().to_be_bytes());
        }
        // The entries, and later the colours and masks.
        entries.len() as u64 * (GROWING * 4 + 16 + 1)
    }

    /// Moves the colours into the model. Masks become numbers, if any vertex is masked.
    pub(super) fn store(self, model: &mut Model, notes: &mut Notes) {
        let count = self.entries.len();
        if self.has_errors || count != model.soup.vertex_count() || model.vertex_colors.is_some() {
            let why = "not one colour for each vertex, or the vertices have others";
            notes.lose_some("colours in lines of #MRGB", count as u64, why);
            return;
        }
        if count == 0 {
            return;
        }
        let color = |&[_, r, g, b]: &[u8; 4]| from_bytes([r, g, b, u8::MAX]);
        model.vertex_colors = Some(self.entries.iter().map(color).collect());
        let masks: Vec<u8> = self.entries.iter().map(|entry| entry[0]).collect();
        if masks.iter().any(|&mask| mask != u8::MAX) {
            model.vertex_scalars.push(Scalars::new("mask", masks));
        }
    }
}
