//! A queue of edges in strict order of their costs, which are all up to date.

use mesh_core::{EdgeId, Topology};

use crate::engine::schedule::EdgeQueue;
use crate::engine::schedule::queue::{Entry, Queue};

/// A queue, and the key of each edge in it.
#[derive(Clone, Debug)]
pub(crate) struct Heap {
    queue: Queue,
    /// The key of each edge; NaN if it is not in the queue. Queue entries with another key are out of date.
    keys: Vec<f64>,
}

impl Heap {
    /// A heap for a mesh with this many edges, counting gaps.
    pub(crate) fn new(edges: usize, entries: Vec<Entry>) -> Self {
        let mut keys = vec![f64::NAN; edges];
        entries.iter().for_each(|entry| keys[entry.edge.index()] = entry.cost);
        Self { queue: Queue::new(entries), keys }
    }

    /// Sets the key of an edge.
    pub(crate) fn push(&mut self, edge: EdgeId, cost: f64) {
        // An entry with the same key stays.
        if self.keys[edge.index()] != cost {
            self.keys[edge.index()] = cost;
            self.queue.push(Entry { cost, edge });
        }
    }

    /// Removes the key of a rejected edge.
    pub(crate) fn refuse(&mut self, edge: EdgeId) {
        self.keys[edge.index()] = f64::NAN;
    }

    /// Takes the cheapest edge.
    pub(crate) fn pop(&mut self, topology: &Topology) -> Option<Entry> {
        loop {
            let entry = self.queue.pop()?;
            let key = &mut self.keys[entry.edge.index()];
            if *key == entry.cost && topology.contains_edge(entry.edge) {
                *key = f64::NAN;
                return Some(entry);
            }
        }
    }

    /// A lower bound of the costs of all waiting edges; infinite if there are none.
    pub(crate) fn least(&self) -> f64 {
        self.queue.head().map_or(f64::INFINITY, |entry| entry.cost)
    }

    /// Removes outdated entries when they are most of the queue.
    pub(crate) fn tidy(&mut self, topology: &Topology) {
        let Self { queue, keys } = self;
        if queue.len() > 4 * topology.edge_count() + 1000 {
            queue.retain(|&Entry { cost, edge }| {
                keys[edge.index()] == cost && topology.contains_edge(edge)
            });
        }
    }
}

impl EdgeQueue for Heap {
    fn push_unknown(&mut self, _: &Topology, edge: EdgeId) {
        self.push(edge, f64::NEG_INFINITY);
    }

    fn refused(&mut self, edge: EdgeId) {
        self.refuse(edge);
    }
}
