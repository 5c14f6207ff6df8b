//! Where edges wait for their collapse.
//!
//! A schedule holds edges with the cost, or a bound of it, that they had when they came; what has
//! become of them since is found out when their turn comes.

pub(crate) mod heap;
pub(crate) mod queue;
pub(crate) mod rounds;

use mesh_core::{EdgeId, Topology};

/// What the schedules have in common: what a collapse and a rejection tell them.
pub(crate) trait EdgeQueue {
    /// Adds an edge of which nothing is known.
    fn push_unknown(&mut self, topology: &Topology, edge: EdgeId);

    /// An edge was rejected and waits no more.
    fn refused(&mut self, edge: EdgeId) {
        let _ = edge;
    }
}
