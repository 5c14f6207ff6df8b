//! The 80 bytes before the facets of binary STL: a comment, and the colour of the whole object as Magics stores it.

use super::facets::HEADER;

/// The keyword in the header before the colour of the whole object.
const COLOR: &[u8] = b"COLOR=";
/// The text of a header without a comment.
const DEFAULT: &str = "binary STL";

/// The colour of the whole object, if the header has one.
pub(super) fn color(header: &[u8]) -> Option<[u8; 4]> {
    header.get(color_place(header)? + COLOR.len()..)?.first_chunk().copied()
}

/// The text before the colour, if there is any. Bytes that are no text belong to the exporter's memory.
pub(super) fn comment(header: &[u8]) -> Option<String> {
    let end = header.iter().position(|&byte| byte == 0).unwrap_or(header.len());
    let end = color_place(header).map_or(end, |place| place.min(end));
    let text = std::str::from_utf8(header.get(..end)?).ok()?.trim();
    let is_said = !text.is_empty() && text != DEFAULT && !text.contains(char::is_control);
    is_said.then(|| text.to_owned())
}

/// A header with the comment, if there is room for it, and with the colour of the whole object.
pub(super) fn with(comment: Option<&str>, color: Option<[u8; 4]>) -> [u8; HEADER as usize] {
    let text = comment.filter(|comment| has_room(comment, color.is_some())).unwrap_or(DEFAULT);
    let color = color.iter().flat_map(|color| [b" ", COLOR, color]).flatten();
    let mut header = [0; HEADER as usize];
    header.iter_mut().zip(text.as_bytes().iter().chain(color)).for_each(|(to, &from)| *to = from);
    header
}

/// Whether a header keeps the comment. A file that starts with "solid" would be text, and a keyword would be a colour.
pub(super) fn has_room(comment: &str, has_color: bool) -> bool {
    let colors = if has_color { 1 + COLOR.len() + 4 } else { 0 };
    let is_text =
        |word: &str| comment.get(..5).is_some_and(|start| start.eq_ignore_ascii_case(word));
    comment.len() + colors <= HEADER as usize
        && !is_text("solid")
        && !is_text("facet")
        && self::comment(comment.as_bytes()).as_deref() == Some(comment)
}

fn color_place(header: &[u8]) -> Option<usize> {
    header.windows(COLOR.len()).position(|window| window == COLOR)
}

#[cfg(test)]
mod tests {
    use super::{color, comment, has_room, with};

    #[test]
    fn text_and_colour_stand_side_by_side() {
        let red = [255, 0, 0, 255];
        for text in ["part 7, bracket", "Halterung für Sensor", "x"] {
            for of_object in [None, Some(red)] {
                assert!(has_room(text, of_object.is_some()), "{text}");
                let header = with(Some(text), of_object);
                assert_eq!(comment(&header).as_deref(), Some(text));
                assert_eq!(color(&header), of_object, "{text}");
            }
        }
        let long = "a".repeat(75);
        assert!(has_room(&long, false) && !has_room(&long, true));
        assert_eq!(color(&with(Some(&long), Some(red))), Some(red));
    }

    #[test]
    fn what_would_change_the_file_is_no_comment() {
        for text in ["solid part", "SOLID", "facets", "", " a", "a COLOR=", "a\nb", "binary STL"] {
            assert!(!has_room(text, false), "{text}");
            assert_eq!(comment(&with(Some(text), None)), None, "{text}");
        }
        // Memory of the exporter after the end of the text, and instead of a text.
        assert_eq!(comment(b"part\0\xff\xfe").as_deref(), Some("part"));
        assert_eq!(comment(b"\xff\xfepart"), None);
        assert_eq!(comment(b"part  \0").as_deref(), Some("part"));
    }
}
