//! A priority queue of edges with costs as keys.

use core::cmp::Ordering;

use mesh_core::EdgeId;

/// A queue with the cheapest edge first; ties are broken by the smallest index.
///
/// A heap with four children per node holds only the cheapest part, so that it stays in the cache. Entries that cost
/// more than the `horizon` wait unsorted until the heap is empty. Removed edges and changed costs are detected when an
/// entry reaches the head.
#[derive(Clone, Debug)]
pub(crate) struct Queue {
    heap: Vec<Entry>,
    /// Entries whose cost is above the horizon.
    waiting: Vec<Entry>,
    horizon: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) cost: f64,
    pub(crate) edge: EdgeId,
}

impl Entry {
    #[inline]
    fn before(&self, other: &Self) -> bool {
        self.cost < other.cost || (self.cost == other.cost && self.edge < other.edge)
    }
}

impl Entry {
    pub(crate) fn compare(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.edge.cmp(&other.edge))
    }
}

const CHILDREN: usize = 4;

/// One in this many waiting entries moves into an empty heap, but at least the minimum below.
const SHARE: usize = 8;
const MIN_SHARE: usize = 4096;

impl Queue {
    /// A queue of these entries; linear time.
    pub(crate) fn new(waiting: Vec<Entry>) -> Self {
        let mut queue = Self { heap: Vec::new(), waiting, horizon: f64::NEG_INFINITY };
        queue.refill();
        queue
    }

    pub(crate) fn len(&self) -> usize {
        self.heap.len() + self.waiting.len()
    }

    /// Removes the entries that `keep` rejects, in linear time.
    pub(crate) fn retain(&mut self, mut keep: impl FnMut(&Entry) -> bool) {
        self.heap.retain(&mut keep);
        self.waiting.retain(keep);
        self.restore();
        self.refill();
    }

    /// Moves the cheapest waiting entries into the heap, if it is empty.
    fn refill(&mut self) {
        if !self.heap.is_empty() || self.waiting.is_empty() {
            return;
        }
        let count = (self.waiting.len() / SHARE).max(MIN_SHARE).min(self.waiting.len());
        self.horizon = self.waiting.select_nth_unstable_by(count - 1, Entry::compare).1.cost;
        let horizon = self.horizon;
        self.heap.extend(self.waiting.extract_if(.., |entry| entry.cost <= horizon));
        self.restore();
    }

    fn restore(&mut self) {
        for place in (0..self.heap.len().div_ceil(CHILDREN)).rev() {
            self.sink(place);
        }
    }

    #[inline]
    pub(crate) fn head(&self) -> Option<Entry> {
        self.heap.first().copied()
    }

    pub(crate) fn push(&mut self, entry: Entry) {
        if entry.cost > self.horizon {
            self.waiting.push(entry);
            self.refill();
            return;
        }
        let mut place = self.heap.len();
        self.heap.push(entry);
        while place > 0 {
            let parent = (place - 1) / CHILDREN;
            if !entry.before(&self.heap[parent]) {
                break;
            }
            self.heap[place] = self.heap[parent];
            place = parent;
        }
        self.heap[place] = entry;
    }

    pub(crate) fn pop(&mut self) -> Option<Entry> {
        let last = self.heap.pop()?;
        let head = match self.heap.first_mut() {
            Some(first) => core::mem::replace(first, last),
            None => last,
        };
        self.sink(0);
        self.refill();
        Some(head)
    }

    fn sink(&mut self, mut place: usize) {
        let Some(&entry) = self.heap.get(place) else { return };
        loop {
            let first = CHILDREN * place + 1;
            let end = (first + CHILDREN).min(self.heap.len());
            if first >= end {
                break;
            }
            let mut least = first;
            for child in first + 1..end {
                if self.heap[child].before(&self.heap[least]) {
                    least = child;
                }
            }
            if !self.heap[least].before(&entry) {
                break;
            }
            self.heap[place] = self.heap[least];
            place = least;
        }
        self.heap[place] = entry;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::SplitMix64;

    #[test]
    fn entries_leave_in_order() {
        let mut random = SplitMix64::new(3);
        let mut entry =
            |i: u32| Entry { cost: (random.uniform() * 50.0).floor(), edge: EdgeId::new(i) };
        let mut queue = Queue::new((0..20_000).map(&mut entry).collect());
        (20_000..25_000).map(&mut entry).for_each(|e| queue.push(e));
        let order: Vec<Entry> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(order.len(), 25_000);
        assert!(order.windows(2).all(|pair| pair[0].before(&pair[1])));
    }
}
