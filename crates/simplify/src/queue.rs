//! A priority queue of edges with costs as keys.

use mesh_core::EdgeId;

/// The cheapest first; of equally cheap ones, the one with the smallest index.
///
/// A heap of four children per node: half as deep as a binary one, and the children share a cache
/// line. Edges that vanish and costs that change are noticed when they come to the head.
#[derive(Clone, Debug, Default)]
pub(crate) struct Queue {
    heap: Vec<Entry>,
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

const CHILDREN: usize = 4;

impl Queue {
    /// A queue of these entries; linear time.
    pub(crate) fn new(heap: Vec<Entry>) -> Self {
        let mut queue = Self { heap };
        queue.restore();
        queue
    }

    pub(crate) fn len(&self) -> usize {
        self.heap.len()
    }

    /// Removes what `keep` does not want; linear time.
    pub(crate) fn retain(&mut self, keep: impl FnMut(&Entry) -> bool) {
        self.heap.retain(keep);
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

    /// Whether something in the queue comes before the head would with this cost.
    #[inline]
    pub(crate) fn head_would_sink(&self, entry: Entry) -> bool {
        self.heap.iter().take(CHILDREN + 1).skip(1).any(|child| child.before(&entry))
    }

    pub(crate) fn push(&mut self, entry: Entry) {
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

    /// Puts `entry` in place of the head.
    pub(crate) fn replace_head(&mut self, entry: Entry) {
        if let Some(head) = self.heap.first_mut() {
            *head = entry;
            self.sink(0);
        }
    }

    pub(crate) fn pop(&mut self) -> Option<Entry> {
        let last = self.heap.pop()?;
        let head = self.heap.first().copied();
        self.replace_head(last);
        Some(head.unwrap_or(last))
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
    use mesh_core::shapes::SplitMix64;

    #[test]
    fn entries_leave_in_order() {
        let mut random = SplitMix64::new(3);
        let mut entry =
            |i: u32| Entry { cost: (random.uniform() * 50.0).floor(), edge: EdgeId::new(i) };
        let mut queue = Queue::new((0..500).map(&mut entry).collect());
        (500..700).map(&mut entry).for_each(|e| queue.push(e));
        let head = queue.head().unwrap();
        let later = Entry { cost: 25.5, ..head };
        assert!(queue.head_would_sink(later) && !queue.head_would_sink(head));
        queue.replace_head(later);
        let order: Vec<Entry> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(order.len(), 700);
        assert!(order.windows(2).all(|pair| pair[0].before(&pair[1])));
    }
}
