//! The greedy loop, which processes edges from the cheapest to the most expensive.

pub(crate) mod edge_collapse;
mod evaluate;
mod one_ring_sums;
mod patch_detail;
mod schedule;
pub(crate) mod start;
mod stepper;
mod target_check;
pub(crate) mod valence;
pub(crate) mod vertex_freedom;
