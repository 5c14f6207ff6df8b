//! Counts with their nouns: `1 face`, `2 faces`.

use core::fmt::Display;

/// A count and what is counted, given as for many. For one, the first word of the phrase that ends with an s becomes
/// singular: `1 edge of more than two faces`.
pub(crate) fn counted<N: Copy + Display + PartialEq + From<u8>>(count: N, many: &str) -> String {
    if count != N::from(1) {
        return format!("{count} {many}");
    }
    let mut is_done = false;
    let words = many.split(' ').map(|word| {
        let noun = word.trim_end_matches([',', ';']);
        if is_done || !noun.ends_with('s') {
            return word.to_owned();
        }
        is_done = true;
        singular(noun) + &word[noun.len()..]
    });
    format!("1 {}", words.collect::<Vec<_>>().join(" "))
}

fn singular(noun: &str) -> String {
    if let Some(stem) = noun.strip_suffix("ices") {
        return format!("{stem}ex");
    }
    if let Some(stem) = noun.strip_suffix("ies") {
        return format!("{stem}y");
    }
    let stem = noun.strip_suffix("es").filter(|s| s.ends_with("sh") || s.ends_with("ch"));
    stem.or_else(|| noun.strip_suffix('s')).unwrap_or(noun).to_owned()
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn one_is_singular() {
        for (many, one) in [
            ("faces", "1 face"),
            ("vertices that no face uses", "1 vertex that no face uses"),
            ("copies", "1 copy"),
            ("patches", "1 patch"),
            ("meshes", "1 mesh"),
            ("edges of more than two faces", "1 edge of more than two faces"),
            ("slivers, a thousand times longer", "1 sliver, a thousand times longer"),
            ("inside-out components", "1 inside-out component"),
        ] {
            assert_eq!(counted(1_usize, many), one);
            assert_eq!(counted(2_u64, many), format!("2 {many}"));
            assert_eq!(counted(0_u32, many), format!("0 {many}"));
        }
    }
}
