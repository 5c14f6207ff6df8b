//! The greedy loop: it gives each edge its turn, cheapest first.

mod detail;
pub(crate) mod edge_collapse;
mod evaluate;
mod one_ring_sums;
mod schedule;
pub(crate) mod start;
mod stepper;
mod target_check;
pub(crate) mod valence;
pub(crate) mod vertex_freedom;
