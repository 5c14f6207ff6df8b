//! Marks of visited and selected elements that are cleared in constant time.

/// Which elements were visited since the last [`VisitMarks::clear`], and which of them were selected.
#[derive(Clone, Debug)]
pub(crate) struct VisitMarks {
    /// The stamp of visited elements; selected elements have the next number.
    round: u32,
    stamps: Vec<u32>,
}

impl VisitMarks {
    pub(crate) fn new(count: usize) -> Self {
        Self { round: 2, stamps: vec![0; count] }
    }

    pub(crate) fn clear(&mut self) {
        self.round = self.round.wrapping_add(2);
        if self.round == 0 {
            self.stamps.fill(0);
            self.round = 2;
        }
    }

    /// Marks an element as visited.
    #[inline]
    pub(crate) fn visit(&mut self, index: usize) {
        self.stamps[index] = self.round;
    }

    /// Marks an element as visited if `is_new`, without a branch.
    #[inline]
    pub(crate) fn visit_if(&mut self, index: usize, is_new: bool) {
        let stamp = &mut self.stamps[index];
        *stamp = if is_new { self.round } else { *stamp };
    }

    #[inline]
    pub(crate) fn is_visited(&self, index: usize) -> bool {
        self.stamps[index] >= self.round
    }

    /// Marks an element as selected.
    #[inline]
    pub(crate) fn select(&mut self, index: usize) {
        self.stamps[index] = self.round + 1;
    }

    #[inline]
    pub(crate) fn is_selected(&self, index: usize) -> bool {
        self.stamps[index] == self.round + 1
    }
}
