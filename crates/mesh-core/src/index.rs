//! Indices and counts of elements as 32 bits.

/// An index or a count of elements as the `u32` that meshes, soups and handles store.
///
/// Use it for numbers that are bounded already. Whatever makes a mesh, a soup or a surface from input refuses more
/// elements than [`Handle::LIMIT`](crate::Handle::LIMIT), so the index and the number of its vertices, edges,
/// half-edges, faces and corners fit into 32 bits. So do lists with at most one entry per element. A number from
/// elsewhere, such as a file, a record or an option, can be anything: convert it with `u32::try_from`, and return an
/// error.
///
/// No other code of the libraries casts to `u32` with `as`; `cargo xtask casts` checks this.
///
/// # Panics
/// The number does not fit into 32 bits, and debug assertions are on. Without them, the number is cut off, as `as`
/// does.
#[inline]
#[must_use]
#[track_caller]
#[expect(clippy::cast_possible_truncation, reason = "the numbers are bounded, see above")]
pub const fn as_u32(number: usize) -> u32 {
    debug_assert!(number <= u32::MAX as usize, "an index or a count exceeds 32 bits");
    number as u32
}

#[cfg(test)]
mod tests {
    use super::as_u32;

    #[test]
    fn numbers_that_fit_keep_their_value() {
        for number in [0, 1, u32::MAX] {
            assert_eq!(as_u32(number as usize), number);
        }
    }

    #[test]
    #[cfg(debug_assertions)]
    #[should_panic(expected = "exceeds 32 bits")]
    fn numbers_that_do_not_fit_are_noticed() {
        let _ = as_u32(u32::MAX as usize + 1);
    }
}
