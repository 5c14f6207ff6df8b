//! Text from files, made safe to print on a terminal.

use std::borrow::Cow;
use std::fmt::Write;

/// The bytes that some editors put before text in UTF-8.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// A text with escapes for all characters that a terminal or an editor would obey instead of showing: control
/// characters, marks of writing direction, characters without width. Letters of all scripts, quotes and backslashes
/// stay.
///
/// Errors and [notes](crate::Model::notes) are already printable. Names of groups, materials and attributes in a
/// [`Model`](crate::Model) are unchanged from the file.
///
/// ```
/// assert_eq!(mesh_io::printable("caf\u{e9} \u{1b}[2J"), "caf\u{e9} \\u{1b}[2J");
/// assert_eq!(mesh_io::printable("exe\u{202e}lpm.ply"), "exe\\u{202e}lpm.ply");
/// ```
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_unprintable) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    text.chars().for_each(|c| push_printable(&mut shown, c));
    Cow::Owned(shown)
}

fn push_printable(shown: &mut String, c: char) {
    match c {
        '\n' | '\r' | '\t' => shown.extend(c.escape_default()),
        _ if is_unprintable(c) => shown.extend(c.escape_unicode()),
        _ => shown.push(c),
    }
}

fn is_unprintable(c: char) -> bool {
    c.is_control()
        || matches!(c,
            // Soft hyphen, Arabic letter mark, Mongolian vowel separator.
            '\u{ad}' | '\u{61c}' | '\u{180e}'
            // No width, left-to-right and right-to-left marks.
            | '\u{200b}'..='\u{200f}'
            // Separators of lines and paragraphs, embeddings and overrides of direction.
            | '\u{2028}'..='\u{202e}'
            // Invisible operators, isolates.
            | '\u{2060}'..='\u{206f}'
            | '\u{feff}' | '\u{fff9}'..='\u{fffb}'
            // Tags.
            | '\u{e0000}'..='\u{e007f}')
}

/// A few words of the file for a message: quoted, shortened and printable.
pub(crate) fn quote(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    if bytes.is_empty() {
        return "nothing".to_owned();
    }
    let mut shown = String::from("\"");
    let mut room = LONGEST;
    // A character has at most four bytes.
    for chunk in bytes[..bytes.len().min(4 * LONGEST)].utf8_chunks() {
        for c in chunk.valid().chars().take(room) {
            match c {
                '"' | '\\' => shown.extend(c.escape_default()),
                _ => push_printable(&mut shown, c),
            }
        }
        room = room.saturating_sub(chunk.valid().chars().count());
        for byte in chunk.invalid().iter().take(room) {
            // Writing to a string cannot fail.
            let _ = write!(shown, "\\x{byte:02x}");
        }
        room = room.saturating_sub(chunk.invalid().len());
    }
    let whole =
        bytes.len() <= 4 * LONGEST && String::from_utf8_lossy(bytes).chars().count() <= LONGEST;
    shown.push_str(if whole { "\"" } else { "...\"" });
    shown
}

/// As [`printable`], limited to a few lines.
pub(crate) fn brief(text: &str) -> Cow<'_, str> {
    const LONGEST: usize = 400;
    match text.char_indices().nth(LONGEST) {
        None => printable(text),
        Some((end, _)) => Cow::Owned(format!("{}...", printable(&text[..end]))),
    }
}
