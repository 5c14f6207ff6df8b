//! Safe output of foreign text on a terminal: letters, and no control sequences.

use std::fmt::{self, Display, Write};

/// Escapes control characters and characters that reorder the text around them: names in files may contain anything.
pub(crate) fn printable(text: impl Display) -> String {
    let mut shown = Escaped { text: String::new(), keep_lines: false };
    let _ = write!(shown, "{text}");
    shown.text
}

/// As [`printable`], shortened: a name in a file can be as long as the file.
pub(crate) fn printable_start(text: impl Display) -> String {
    const LONGEST: usize = 200;
    let shown = printable(text);
    match shown.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", shown.get(..end).unwrap_or_default()),
        None => shown,
    }
}

/// As [`printable`], for our own texts of several lines.
pub(crate) fn printable_lines(text: impl Display) -> String {
    let mut shown = Escaped { text: String::new(), keep_lines: true };
    let _ = write!(shown, "{text}");
    shown.text
}

/// As [`printable`], for a JSON text. Such characters are inside strings there, and JSON has its own escape for them.
pub(crate) fn printable_json(json: &str) -> String {
    if json.chars().all(is_harmless) {
        return json.to_owned();
    }
    let mut shown = String::with_capacity(json.len());
    for c in json.chars() {
        if is_harmless(c) {
            shown.push(c);
        } else {
            let _ =
                c.encode_utf16(&mut [0; 2]).iter().try_for_each(|u| write!(shown, "\\u{u:04x}"));
        }
    }
    shown
}

struct Escaped {
    text: String,
    keep_lines: bool,
}

impl Write for Escaped {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for c in text.chars() {
            if is_harmless(c) || (c == '\n' && self.keep_lines) {
                self.text.push(c);
            } else {
                self.text.extend(c.escape_default());
            }
        }
        Ok(())
    }
}

/// Whether a character is shown as itself and does not affect others.
fn is_harmless(c: char) -> bool {
    let reorders = matches!(c,
        '\u{061C}' | '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2060}'..='\u{206F}' | '\u{FEFF}');
    !c.is_control() && !reorders
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_to_the_terminal_are_spelled_out() {
        assert_eq!(printable("a\x1b[31mb\r\nc"), r"a\u{1b}[31mb\r\nc");
        assert_eq!(printable("\u{202E}gpj.exe \u{9b}2J"), r"\u{202e}gpj.exe \u{9b}2J");
        assert_eq!(printable("Überfläche 面"), "Überfläche 面");
        assert_eq!(printable_start("\u{e9}".repeat(201)), "\u{e9}".repeat(200) + "...");
        assert_eq!(printable_start("\u{e9}".repeat(200)), "\u{e9}".repeat(200));
        assert_eq!(printable_lines("one\ntwo\x07"), "one\ntwo\\u{7}");
        assert_eq!(printable_json("[\"a\u{202E}\u{9b}\"]"), r#"["a\u202e\u009b"]"#);
    }
}
