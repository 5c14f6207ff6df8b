//! Detection of formats: by content first, then by extension.

use crate::text::BYTE_ORDER_MARK;
use std::fmt;
use std::path::Path;

/// A mesh file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// Stanford PLY.
    Ply,
    /// Stereolithography, binary or text.
    Stl,
    /// Geomview OFF in all its variants.
    Off,
    /// glTF 2.0 as JSON, with embedded or separate buffers.
    Gltf,
    /// glTF 2.0 in its binary container.
    Glb,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Stl => "STL",
            Self::Off => "OFF",
            Self::Gltf => "glTF",
            Self::Glb => "GLB",
        })
    }
}

impl Format {
    /// All formats.
    pub const ALL: &'static [Self] =
        &[Self::Obj, Self::Ply, Self::Stl, Self::Off, Self::Gltf, Self::Glb];

    /// The usual extension, without the dot.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Stl => "stl",
            Self::Off => "off",
            Self::Gltf => "gltf",
            Self::Glb => "glb",
        }
    }

    /// The format of an extension, in any case. `coff` and similar extensions are OFF; `stla` and `stlb` are STL.
    #[must_use]
    pub fn from_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "stla" | "stlb" => Some(Self::Stl),
            "coff" | "noff" | "cnoff" | "ncoff" | "stoff" => Some(Self::Off),
            other => Self::ALL.iter().copied().find(|format| format.extension() == other),
        }
    }

    /// The format of a file whose first bytes are `head`; a few hundred are enough.
    ///
    /// The content decides if possible. If it is not decisive, as for OFF without its header word, the extension of
    /// `path` decides. `size` is the length of the whole file; it distinguishes binary STL whose header starts with
    /// `solid` from text STL.
    #[must_use]
    pub fn detect(head: &[u8], size: Option<u64>, path: Option<&Path>) -> Option<Self> {
        Self::from_content(head, size).or_else(|| path.and_then(Self::from_extension))
    }

    fn from_content(head: &[u8], size: Option<u64>) -> Option<Self> {
        if head.starts_with(b"glTF") {
            return Some(Self::Glb);
        }
        if is_binary_stl(head, size) {
            return Some(Self::Stl);
        }
        let text = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head).trim_ascii_start();
        if text.first() == Some(&b'{') {
            return Some(Self::Gltf);
        }
        let word_end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        let word = &text[..word_end];
        if word == b"ply" {
            Some(Self::Ply)
        } else if word.eq_ignore_ascii_case(b"solid") {
            Some(Self::Stl)
        } else if is_off_word(word) {
            Some(Self::Off)
        } else {
            first_words(text).find_map(off_or_obj)
        }
    }
}

/// `4nCOFF` and similar words.
pub(crate) fn is_off_word(word: &[u8]) -> bool {
    off_word(word).is_some()
}

/// The letters before `OFF` and the digits after it. The letters are `ST`, `C`, `N`, `4` and `n` in any order, each at
/// most once; a lower-case word has no `n`. Some files have the number of vertices directly after the word, as in `OFF8
/// 6 0`.
pub(crate) fn off_word(word: &[u8]) -> Option<(Vec<u8>, &[u8])> {
    let end = word.iter().rposition(|byte| !byte.is_ascii_digit()).map_or(0, |last| last + 1);
    let (word, digits) = word.split_at(end);
    let letters = match (word.strip_suffix(b"OFF"), word.strip_suffix(b"off")) {
        (Some(letters), _) => letters.to_owned(),
        (None, Some(letters)) => letters.to_ascii_uppercase(),
        (None, None) => return None,
    };
    let mut rest = letters.as_slice();
    while !rest.is_empty() {
        let known = [&b"ST"[..], b"C", b"N", b"4", b"n"];
        rest = known.iter().find_map(|&letter| rest.strip_prefix(letter))?;
    }
    let mut sorted = letters.clone();
    sorted.sort_unstable();
    let all_differ = sorted.array_windows::<2>().all(|[a, b]| a != b);
    all_differ.then_some((letters, digits))
}

/// Whether a file is binary STL: its length matches the count in its header, or it starts with `solid` and contains
/// bytes that do not occur in text. If the length is unknown, as of standard input, the first facets have to be
/// possible ones.
pub(crate) fn is_binary_stl(head: &[u8], size: Option<u64>) -> bool {
    let Some(&count) = head.get(80..84).and_then(<[u8]>::first_chunk::<4>) else { return false };
    let expected = 84 + 50 * u64::from(u32::from_le_bytes(count));
    if size == Some(expected) {
        return true;
    }
    let is_text = !head.iter().take(512).any(|&byte| byte == 0 || byte >= 0xF8);
    let says_solid = head.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    !is_text && (says_solid || (size.is_none() && has_facets(&head[84..], count)))
}

/// Whether there are several facets of binary STL, but no more than announced: coordinates that are 0 or neither tiny nor
/// huge. Other bytes have this property at random only if they are very few.
fn has_facets(bytes: &[u8], count: [u8; 4]) -> bool {
    let facets = bytes.chunks_exact(50);
    let is_possible = |bytes: &[u8; 4]| {
        let value = f32::from_le_bytes(*bytes).abs();
        value == 0.0 || (1e-20..1e20).contains(&value)
    };
    (4..=u32::from_le_bytes(count) as usize).contains(&facets.len())
        && facets.flat_map(|facet| facet[..48].as_chunks::<4>().0).all(is_possible)
}

/// The first word of every line that is neither empty nor a comment.
fn first_words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(|&byte| byte == b'\n' || byte == b'\r').filter_map(|line| {
        let line = line.trim_ascii();
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        line.first().is_some_and(|&byte| byte != b'#').then(|| &line[..end])
    })
}

/// The format with this keyword.
fn off_or_obj(word: &[u8]) -> Option<Format> {
    const OBJ: [&[u8]; 9] = [b"v", b"vt", b"vn", b"f", b"g", b"o", b"mtllib", b"usemtl", b"s"];
    if is_off_word(word) {
        Some(Format::Off)
    } else if OBJ.contains(&word) {
        Some(Format::Obj)
    } else {
        None
    }
}
