//! Unique names, for formats that identify elements only by name.

use std::collections::{HashMap, HashSet};

/// The names in order. Repeated names, and names in `taken`, become `NAME_2`, `NAME_3` and so on.
pub(crate) fn distinct_names(
    names: impl IntoIterator<Item = String>,
    taken: &[&str],
) -> Vec<String> {
    let mut used: HashSet<String> = taken.iter().map(|&name| name.to_owned()).collect();
    // The position at which the search for a free number continues, so that many equal names take linear time.
    let mut last = HashMap::<String, u64>::new();
    let mut distinct = |name: String| {
        if used.insert(name.clone()) {
            return name;
        }
        let number = last.entry(name.clone()).or_insert(1);
        loop {
            *number += 1;
            let candidate = format!("{name}_{number}");
            if used.insert(candidate.clone()) {
                return candidate;
            }
        }
    };
    names.into_iter().map(&mut distinct).collect()
}

#[cfg(test)]
mod tests {
    use super::distinct_names;

    #[test]
    fn equal_names_get_numbers_that_are_free() {
        let names = ["a", "a_2", "x", "a", "a", "b"].map(str::to_owned);
        assert_eq!(distinct_names(names, &["x"]), ["a", "a_2", "x_2", "a_3", "a_4", "b"]);
        let many = distinct_names((0..100_000).map(|_| "m".to_owned()), &[]);
        assert_eq!(many[99_999], "m_100000");
    }
}
