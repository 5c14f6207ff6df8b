//! The rounds of the lazy schedule: edges waiting for their collapse, in buckets of about equal cost.
//!
//! The costs in a bucket differ by at most 1/32. The edges of a bucket are visited in the order of a walk over the
//! surface, so that consecutive edges are neighbours and share cached data. The strict order of a heap jumps around on
//! the surface, and spends most of its time waiting for memory.

use mesh_core::{EdgeId, Topology, VertexId, as_u32};

use crate::engine::schedule::EdgeQueue;
use crate::engine::schedule::queue::Entry;

/// A waiting edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Visit {
    /// The cost of the edge, or a lower bound of it.
    pub(crate) cost: f64,
    pub(crate) edge: EdgeId,
    /// Edges with close ranks are close to each other on the surface.
    pub(crate) rank: u32,
}

/// Edges by the cost, or a lower bound of it, at the time when they were added.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rounds {
    buckets: Vec<Vec<Visit>>,
    /// No bucket before this one has entries.
    first: usize,
    /// The bucket of the last round.
    open: usize,
    /// The reciprocal of the largest cost at the start, so that a scaled copy of a mesh has the same edges in its
    /// buckets.
    scale: f64,
    /// The rank of each vertex.
    ranks: Vec<u32>,
}

/// The edges of one bucket.
#[derive(Clone, Debug, Default)]
pub(crate) struct Round {
    /// The edges, in the order of their ranks.
    pub(crate) visits: Vec<Visit>,
    /// The smallest key.
    pub(crate) least: f64,
    /// Edges that cost more belong to a later round.
    pub(crate) threshold: f64,
}

/// The bucket is given by the leading bits of a number: the exponent and five binary digits.
const SHIFT: u32 = 47;
/// Costs outside this range, relative to the largest cost at the start, share the first or last bucket.
const SMALLEST: f64 = 1e-36;
const LARGEST: f64 = 1e18;

impl Rounds {
    pub(crate) fn new(topology: &Topology, entries: &[Entry]) -> Self {
        let costs = entries.iter().map(|entry| entry.cost).filter(|cost| cost.is_finite());
        let scale = costs.fold(0.0, f64::max).recip();
        let scale = if scale.is_finite() { scale } else { 1.0 };
        let ranks = breadth_first_ranks(topology);
        let mut rounds = Self { buckets: Vec::new(), first: 0, open: 0, scale, ranks };
        let count = rounds.bucket(f64::INFINITY) + 2;
        rounds.buckets.resize(count, Vec::new());
        rounds.refill(topology, entries);
        rounds
    }

    fn rank(&self, topology: &Topology, edge: EdgeId) -> u32 {
        let [a, b] = topology.edge_vertices(edge);
        self.ranks[a.index()].min(self.ranks[b.index()])
    }

    fn bucket(&self, cost: f64) -> usize {
        let bits = |number: f64| (number.to_bits() >> SHIFT) as usize;
        bits((cost * self.scale).clamp(SMALLEST, LARGEST)) - bits(SMALLEST)
    }

    /// Replaces all waiting edges by these.
    pub(crate) fn refill(&mut self, topology: &Topology, entries: &[Entry]) {
        self.buckets.iter_mut().for_each(Vec::clear);
        (self.first, self.open) = (0, 0);
        // The number of edges is largest at the start, so no bucket allocates more than it needs.
        let mut counts = vec![0; self.buckets.len()];
        entries.iter().for_each(|entry| counts[self.bucket(entry.cost)] += 1);
        for (bucket, count) in self.buckets.iter_mut().zip(counts) {
            bucket.reserve_exact(count);
        }
        for &Entry { cost, edge } in entries {
            let bucket = self.bucket(cost);
            let rank = self.rank(topology, edge);
            self.buckets[bucket].push(Visit { cost, edge, rank });
        }
    }

    /// Adds an edge that costs more than the threshold of the last round.
    pub(crate) fn push_above(&mut self, visit: Visit) {
        // One bucket too far if the cost equals the threshold up to rounding.
        let bucket = self.bucket(visit.cost).max(self.open + 1);
        self.first = self.first.min(bucket);
        self.buckets[bucket].push(visit);
    }

    /// Takes the cheapest bucket; `false` if all are empty.
    pub(crate) fn take(&mut self, round: &mut Round) -> bool {
        let filled = self.buckets.iter().skip(self.first).position(|bucket| !bucket.is_empty());
        let Some(steps) = filled else { return false };
        self.open = self.first + steps;
        self.first = self.open;
        // Only edges of unknown cost can be added to this bucket again, so its memory is released.
        round.visits = core::mem::take(&mut self.buckets[self.open]);
        round.visits.sort_unstable_by_key(|visit| (visit.rank, visit.edge));
        let keys = round.visits.iter().map(|visit| visit.cost);
        round.least = keys.fold(f64::INFINITY, f64::min);
        let end = ((SMALLEST.to_bits() >> SHIFT) + self.open as u64 + 1) << SHIFT;
        let is_last = self.open + 2 >= self.buckets.len();
        round.threshold = if is_last { f64::INFINITY } else { f64::from_bits(end) / self.scale };
        true
    }
}

impl EdgeQueue for Rounds {
    /// Adds an edge of unknown cost; the next round starts with it.
    fn push_unknown(&mut self, topology: &Topology, edge: EdgeId) {
        let rank = self.rank(topology, edge);
        self.buckets[0].push(Visit { cost: f64::NEG_INFINITY, edge, rank });
        self.first = 0;
    }
}

/// The rank of each vertex, by index, in a breadth-first walk over the surface.
fn breadth_first_ranks(topology: &Topology) -> Vec<u32> {
    const UNKNOWN: u32 = u32::MAX;
    let mut ranks = vec![UNKNOWN; topology.vertex_capacity()];
    let mut order: Vec<VertexId> = Vec::with_capacity(topology.vertex_count());
    for start in topology.vertices() {
        if ranks[start.index()] != UNKNOWN {
            continue;
        }
        let mut next = order.len();
        ranks[start.index()] = as_u32(next);
        order.push(start);
        while let Some(&v) = order.get(next) {
            next += 1;
            for w in topology.one_ring(v) {
                if ranks[w.index()] == UNKNOWN {
                    ranks[w.index()] = as_u32(order.len());
                    order.push(w);
                }
            }
        }
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::SplitMix64;
    use mesh_core::TriMesh;
    use mesh_shapes::Sphere;

    #[test]
    fn every_edge_comes_once_and_the_rounds_ascend() {
        let soup = Sphere { radius: 1.0 }.icosphere(4).unwrap();
        let mesh = TriMesh::from_soup(&soup).unwrap();
        let topology = mesh.topology();
        let mut random = SplitMix64::new(5);
        let mut cost = |index: usize| match index % 100 {
            0 => 0.0,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            _ => 10.0_f64.powf(12.0 * random.symmetric()),
        };
        let entries: Vec<Entry> =
            topology.edges().map(|edge| Entry { cost: cost(edge.index()), edge }).collect();
        let mut rounds = Rounds::new(topology, &entries);
        let (mut round, mut seen, mut before) = (Round::default(), 0, f64::NEG_INFINITY);
        let mut again = 0;
        while rounds.take(&mut round) {
            assert!(round.least >= before * (1.0 - 1e-15));
            let most = round.visits.iter().map(|visit| visit.cost).fold(0.0, f64::max);
            assert!(most <= round.threshold * (1.0 + 1e-15));
            assert!(round.least <= 1e-20 || most <= 1.0313 * round.least || most.is_infinite());
            assert!(round.visits.windows(2).all(|pair| pair[0].rank <= pair[1].rank));
            seen += round.visits.len();
            before = round.threshold;
            if most < 1e10 {
                // The cost equals the threshold, but the edge must still go into a later round.
                rounds.push_above(Visit { cost: round.threshold, ..round.visits[0] });
                again += 1;
            }
        }
        assert_eq!(seen, entries.len() + again);
        assert!(again > 100);
    }
}
