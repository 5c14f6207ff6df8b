//! Disjoint sets of indices.

/// A set for each index at first; sets are joined.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    pub(super) fn new(count: u32) -> Self {
        Self((0..count).collect())
    }

    /// The index that stands for the set of another one.
    pub(super) fn of(&mut self, index: u32) -> u32 {
        let mut at = index;
        while let Some(&next) = self.0.get(at as usize)
            && next != at
        {
            // Every second step is skipped the next time.
            let after = self.0.get(next as usize).copied().unwrap_or(next);
            if let Some(slot) = self.0.get_mut(at as usize) {
                *slot = after;
            }
            at = after;
        }
        at
    }

    pub(super) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        if let Some(slot) = self.0.get_mut(a as usize) {
            *slot = b;
        }
    }
}
