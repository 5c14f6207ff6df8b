//! Disjoint sets of indices (union by smaller index, with path halving).

use crate::index::as_u32;

/// A partition of `0..n` that starts with sets of one index.
#[derive(Clone, Debug, Default)]
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// A number of sets of one index each.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self { parent: (0..as_u32(count)).collect() }
    }

    /// Adds an index as a new set and returns it.
    pub fn push(&mut self) -> u32 {
        let index = as_u32(self.parent.len());
        self.parent.push(index);
        index
    }

    /// The smallest index of the set that `index` is in.
    ///
    /// # Panics
    /// The index is out of range.
    pub fn find(&mut self, mut index: u32) -> u32 {
        while self.parent[index as usize] != index {
            let grandparent = self.parent[self.parent[index as usize] as usize];
            self.parent[index as usize] = grandparent;
            index = grandparent;
        }
        index
    }

    /// Unites the sets of `a` and `b`.
    ///
    /// # Panics
    /// An index is out of range.
    pub fn union(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// The number of distinct sets that contain the given indices.
    ///
    /// # Panics
    /// An index is out of range.
    pub fn count_sets(&mut self, indices: impl Iterator<Item = u32>) -> usize {
        let mut is_counted = vec![false; self.parent.len()];
        indices
            .filter(|&index| {
                let root = self.find(index) as usize;
                !core::mem::replace(&mut is_counted[root], true)
            })
            .count()
    }
}
