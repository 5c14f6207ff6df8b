//! The queue of a block: edges waiting for their collapse, in buckets of about equal cost.
//!
//! An edge is in at most one bucket, so the lists need only one link per edge. Each bucket is a stack: the last edge
//! added is the first one taken.

/// Edges by the cost, or a lower bound of it, at the time when they were added.
#[derive(Clone, Debug)]
pub(super) struct BucketQueue {
    /// The first edge of each bucket.
    heads: Vec<u32>,
    /// By edge: the next one in its bucket, [`END`], or [`ABSENT`].
    links: Vec<u32>,
    /// No bucket before this one has edges.
    first: usize,
}

const END: u32 = u32::MAX;
const ABSENT: u32 = u32::MAX - 1;

/// The bucket of a cost is given by its exponent and this many leading binary digits.
const DIGITS: u32 = 3;
const SHIFT: u32 = 52 - DIGITS;
/// Costs outside this range share the first or the last bucket.
const SMALLEST: f64 = 1e-42;
const LARGEST: f64 = 1e6;

/// The bucket of a cost in units of the fourth power of the size of the mesh.
#[inline]
pub(super) fn bucket(cost: f64) -> usize {
    let digits = |number: f64| (number.to_bits() >> SHIFT) as usize;
    // NaN goes into the first bucket, and is rejected.
    let cost = if cost.is_nan() { 0.0 } else { cost };
    digits(cost.clamp(SMALLEST, LARGEST)) - const { (SMALLEST.to_bits() >> SHIFT) as usize }
}

/// The number of buckets.
pub(super) const BUCKETS: usize =
    ((LARGEST.to_bits() >> SHIFT) - (SMALLEST.to_bits() >> SHIFT)) as usize + 1;

impl BucketQueue {
    /// An empty queue for this many edges.
    pub(super) fn new(edges: usize) -> Self {
        Self { heads: vec![END; BUCKETS], links: vec![ABSENT; edges], first: BUCKETS }
    }

    /// Whether an edge waits.
    #[inline]
    pub(super) fn contains(&self, edge: u32) -> bool {
        self.links[edge as usize] != ABSENT
    }

    /// Adds an edge that is not in the queue.
    #[inline]
    pub(super) fn push(&mut self, edge: u32, bucket: usize) {
        self.links[edge as usize] = self.heads[bucket];
        self.heads[bucket] = edge;
        self.first = self.first.min(bucket);
    }

    /// Takes an edge of the cheapest bucket, if it is below `end`.
    #[inline]
    pub(super) fn pop(&mut self, end: usize) -> Option<(u32, usize)> {
        while self.first < end.min(BUCKETS) {
            let edge = self.heads[self.first];
            if edge != END {
                self.heads[self.first] = core::mem::replace(&mut self.links[edge as usize], ABSENT);
                return Some((edge, self.first));
            }
            self.first += 1;
        }
        None
    }

    /// Takes another edge of a bucket, which must be the bucket of the last edge taken.
    #[inline]
    pub(super) fn pop_another(&mut self, bucket: usize) -> Option<u32> {
        let edge = self.heads[bucket];
        if edge == END {
            return None;
        }
        self.heads[bucket] = core::mem::replace(&mut self.links[edge as usize], ABSENT);
        Some(edge)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_ascend_and_come_in_order() {
        let costs: Vec<f64> = (0..4000).map(|i| 1e-45 * 1.03_f64.powi(i)).collect();
        assert!(costs.windows(2).all(|pair| bucket(pair[0]) <= bucket(pair[1])));
        assert!(bucket(0.0) == 0 && bucket(f64::NAN) == 0 && bucket(f64::INFINITY) == BUCKETS - 1);
        let mut queue = BucketQueue::new(costs.len());
        for (i, &cost) in costs.iter().enumerate() {
            queue.push(i as u32, bucket(cost));
        }
        let (mut before, mut count) = (0, 0);
        while let Some((edge, at)) = queue.pop(BUCKETS) {
            assert!(at >= before && at == bucket(costs[edge as usize]) && !queue.contains(edge));
            (before, count) = (at, count + 1);
        }
        assert_eq!(count, costs.len());
    }
}
