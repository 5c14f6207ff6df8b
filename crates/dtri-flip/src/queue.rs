//! Indexed priority queue: a four-ary heap with the position of each item.

use mesh_core::as_u32;

/// Items `0..count` with one key each, largest key first. Equal keys are ordered by item, so the order
/// does not depend on the history of insertions.
#[derive(Clone, Debug)]
pub(crate) struct IndexedQueue {
    heap: Vec<Entry>,
    /// Position of each item in the heap, or `ABSENT`.
    place: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    key: f64,
    item: u32,
}

impl Entry {
    #[inline]
    fn precedes(self, other: Self) -> bool {
        self.key > other.key || (self.key == other.key && self.item < other.item)
    }
}

const ABSENT: u32 = u32::MAX;
const ARITY: usize = 4;

impl IndexedQueue {
    /// A queue of the items that have a key. NaN counts as no key.
    pub(crate) fn new(keys: impl Iterator<Item = Option<f64>>) -> Self {
        let mut queue = Self { heap: Vec::new(), place: Vec::new() };
        for (item, key) in keys.enumerate() {
            queue.place.push(ABSENT);
            if let Some(key) = key.filter(|key| !key.is_nan()) {
                queue.place[item] = as_u32(queue.heap.len());
                queue.heap.push(Entry { key, item: as_u32(item) });
            }
        }
        for place in (0..queue.heap.len().div_ceil(ARITY)).rev() {
            queue.sift_down(place);
        }
        queue
    }

    pub(crate) fn len(&self) -> usize {
        self.heap.len()
    }

    /// Removes the first item and returns it with its key.
    pub(crate) fn pop(&mut self) -> Option<(u32, f64)> {
        let Entry { key, item } = *self.heap.first()?;
        self.remove(item);
        Some((item, key))
    }

    /// Sets the key of an item, or removes the item. NaN counts as no key.
    pub(crate) fn set(&mut self, item: u32, key: Option<f64>) {
        let Some(key) = key.filter(|key| !key.is_nan()) else {
            self.remove(item);
            return;
        };
        let entry = Entry { key, item };
        let place = self.place[item as usize];
        if place == ABSENT {
            self.heap.push(entry);
            self.place[item as usize] = as_u32(self.heap.len()) - 1;
            self.sift_up(self.heap.len() - 1);
        } else {
            self.replace(place as usize, entry);
        }
    }

    fn remove(&mut self, item: u32) {
        let place = core::mem::replace(&mut self.place[item as usize], ABSENT);
        if place == ABSENT {
            return;
        }
        let Some(last) = self.heap.pop() else { return };
        if last.item != item {
            self.replace(place as usize, last);
        }
    }

    /// Replaces the entry at a position and restores the heap order.
    fn replace(&mut self, place: usize, entry: Entry) {
        let rises = entry.precedes(self.heap[place]);
        self.put(place, entry);
        if rises {
            self.sift_up(place);
        } else {
            self.sift_down(place);
        }
    }

    #[inline]
    fn put(&mut self, place: usize, entry: Entry) {
        self.heap[place] = entry;
        self.place[entry.item as usize] = as_u32(place);
    }

    fn sift_up(&mut self, mut place: usize) {
        let entry = self.heap[place];
        while place > 0 {
            let parent = (place - 1) / ARITY;
            if !entry.precedes(self.heap[parent]) {
                break;
            }
            self.put(place, self.heap[parent]);
            place = parent;
        }
        self.put(place, entry);
    }

    fn sift_down(&mut self, mut place: usize) {
        let Some(&entry) = self.heap.get(place) else { return };
        loop {
            let children = ARITY * place + 1..self.heap.len().min(ARITY * place + 1 + ARITY);
            let first = children.reduce(|best, child| {
                if self.heap[child].precedes(self.heap[best]) { child } else { best }
            });
            let Some(child) = first.filter(|&child| self.heap[child].precedes(entry)) else {
                break;
            };
            self.put(place, self.heap[child]);
            place = child;
        }
        self.put(place, entry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::SplitMix64;

    #[test]
    fn agrees_with_a_sorted_list_under_random_changes() {
        let mut random = SplitMix64::new(1);
        let count = 60;
        let key = |random: &mut SplitMix64| match random.bits() % 4 {
            0 => None,
            1 => Some(f64::NAN),
            _ => Some((random.bits() % 10) as f64),
        };
        let mut keys: Vec<Option<f64>> = (0..count).map(|_| key(&mut random)).collect();
        let mut queue = IndexedQueue::new(keys.iter().copied());
        for _ in 0..20_000 {
            if random.bits().is_multiple_of(3) {
                let best = (0..count)
                    .filter(|&i| keys[i].is_some_and(|k| !k.is_nan()))
                    .min_by(|&i, &j| keys[j].partial_cmp(&keys[i]).unwrap().then(i.cmp(&j)));
                assert_eq!(queue.pop(), best.map(|i| (i as u32, keys[i].unwrap())));
                if let Some(best) = best {
                    keys[best] = None;
                }
            } else {
                let item = random.bits() as usize % count;
                keys[item] = key(&mut random);
                queue.set(item as u32, keys[item]);
            }
            assert_eq!(queue.len(), keys.iter().flatten().filter(|k| !k.is_nan()).count());
        }
    }
}
