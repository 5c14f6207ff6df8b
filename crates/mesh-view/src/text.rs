//! Names from files, made safe to show.

/// The text with escapes for all characters that are invisible or affect the text around them: control characters,
/// marks of writing direction, invisible characters.
pub(crate) fn visible(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for letter in text.chars() {
        let is_hidden = letter.is_control()
            || matches!(
                letter,
                '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
                    | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}'
                    | '\u{e0000}'..='\u{e007f}'
            );
        if is_hidden {
            shown.push_str(&format!("\u{27e8}U+{:04X}\u{27e9}", u32::from(letter)));
        } else {
            shown.push(letter);
        }
    }
    shown
}

/// The text for the content of an element or the value of an attribute.
pub(crate) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            _ => safe.push(letter),
        }
    }
    safe
}

/// JSON text for the inside of a script element. An element ends at `</script`, and `<!--` changes the parsing, so their
/// first letters are escaped.
pub(crate) fn in_script(json: &str) -> String {
    let mut safe = String::with_capacity(json.len());
    for part in json.split_inclusive(['<', '>', '&']) {
        let plain = part.trim_end_matches(['<', '>', '&']);
        safe.push_str(plain);
        safe.push_str(match &part[plain.len()..] {
            "<" => "\\u003c",
            ">" => "\\u003e",
            "&" => "\\u0026",
            _ => "",
        });
    }
    safe
}

/// A name for a file on the reader's machine: ASCII letters, digits, dots and dashes.
pub(crate) fn file_name(text: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { ' ' };
    let words: String = text.chars().take(80).map(plain).collect();
    words.split_whitespace().collect::<Vec<_>>().join("-")
}

/// An integer with separated thousands.
pub(crate) fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_names_are_only_names() {
        let name = "</script><script>alert(1)</script>\u{202e}\"'&\0";
        let inside = in_script(&serde_json::json!({ "name": visible(name) }).to_string());
        assert!(!inside.contains('<') && !inside.contains('\u{202e}'), "{inside}");
        let back: serde_json::Value = serde_json::from_str(&inside).unwrap();
        let read = back["name"].as_str().unwrap();
        assert!(read.starts_with("</script>") && read.contains("⟨U+202E⟩"), "{read}");
        assert!(!escaped(name).contains(['<', '"', '\'']));
        assert_eq!(file_name("a/../b <x>.ply"), "a-b-x-ply");
        assert_eq!([grouped(0), grouped(999), grouped(1_234_567)], ["0", "999", "1,234,567"]);
    }
}
