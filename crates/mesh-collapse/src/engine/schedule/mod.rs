//! The queues in which edges wait for their collapse.
//!
//! A schedule stores edges with their cost, or a lower bound of it, at the time when they were added. The current cost
//! is evaluated when their turn comes.

pub(crate) mod heap;
pub(crate) mod queue;
pub(crate) mod rounds;

use mesh_core::{EdgeId, Topology};

/// The common interface of the schedules: the changes that collapses and rejections report.
pub(crate) trait EdgeQueue {
    /// Adds an edge whose cost is unknown.
    fn push_unknown(&mut self, topology: &Topology, edge: EdgeId);

    /// Reports that an edge was rejected and does not wait any more.
    fn refused(&mut self, edge: EdgeId) {
        let _ = edge;
    }
}
