//! Finding vertices by their indices in the input.

/// Finds numbers in a sorted list.
pub(crate) struct IdIndex<'i> {
    ids: &'i [u64],
    /// If the numbers are close together: for each number minus the first one, the place plus 1.
    direct: Vec<u32>,
}

/// A direct table is used if the list contains at least one in this many of the numbers between its first and its last.
const SPARSE: u64 = 8;

impl<'i> IdIndex<'i> {
    /// An index of a sorted list of fewer than 2^32 numbers.
    pub(crate) fn new(ids: &'i [u64]) -> Self {
        let span = match (ids.first(), ids.last()) {
            (Some(first), Some(last)) => last.saturating_sub(*first),
            _ => 0,
        };
        let mut direct = Vec::new();
        if !ids.is_empty() && span < SPARSE * ids.len() as u64 {
            direct.resize(span as usize + 1, 0);
            for (place, id) in (1..).zip(ids) {
                direct[(id - ids[0]) as usize] = place;
            }
        }
        Self { ids, direct }
    }

    /// The place of a number in the list.
    pub(crate) fn find(&self, id: u64) -> Option<u32> {
        if self.direct.is_empty() {
            return self.ids.binary_search(&id).ok().and_then(|place| place.try_into().ok());
        }
        let place = self.direct.get(usize::try_from(id.checked_sub(self.ids[0])?).ok()?)?;
        place.checked_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_wherever_they_lie() {
        for ids in [&[][..], &[7], &[3, 4, 9], &[0, u64::MAX], &[5, 1 << 40, u64::MAX - 1]] {
            let index = IdIndex::new(ids);
            for (place, &id) in (0..).zip(ids) {
                assert_eq!(index.find(id), Some(place));
            }
            for other in [1, 2, 8, 1 << 39, u64::MAX - 2] {
                assert_eq!(index.find(other), None, "{ids:?}");
            }
        }
    }
}
