//! Vertices of very high valence, such as the apex of a cone.
//!
//! For a cost that is a function of sums over vertices, each flip at a vertex changes the gains of
//! all edges of its star. Updating all of them at once takes time quadratic in the valence. At
//! vertices of valence above [`HIGH_VALENCE`], only gains near the flip are updated at once. All gains
//! of the star are updated after every [`flips_between_refreshes`] flips and when the queue is empty.
//! A stale gain is computed again before its edge flips. So every flip still lowers the cost and the
//! result is a local minimum, but a flip may be the best of an earlier state.

use mesh_core::{Topology, VertexId, as_u32};

/// Largest number of faces around a vertex whose star is updated at each flip.
pub(crate) const HIGH_VALENCE: usize = 256;

/// A star is refreshed after one flip per this many faces.
const FACES_PER_FLIP: usize = 16;

/// Whether more than `limit` faces surround a vertex. Takes at most `limit` steps.
#[inline]
pub(crate) fn has_higher_valence(topology: &Topology, vertex: VertexId, limit: usize) -> bool {
    topology.faces_of_vertex(vertex).nth(limit).is_some()
}

/// Number of flips at a vertex after which its whole star is updated.
pub(crate) fn flips_between_refreshes(topology: &Topology, vertex: VertexId) -> u32 {
    as_u32((topology.faces_of_vertex(vertex).count() / FACES_PER_FLIP).max(1))
}

/// The vertices of high valence around which some gains are stale.
#[derive(Debug, Default)]
pub(crate) struct HighValence {
    /// Number of flips before the next refresh of each vertex; 0 where all gains are exact. Empty
    /// until there is a vertex of high valence.
    flips_left: Vec<u32>,
    stale: Vec<VertexId>,
}

impl HighValence {
    /// Records a flip at a vertex of high valence. Returns whether its star must be updated now.
    pub(crate) fn record_flip(&mut self, topology: &Topology, vertex: VertexId) -> bool {
        self.flips_left.resize(topology.vertex_capacity(), 0);
        let left = &mut self.flips_left[vertex.index()];
        if *left == 0 {
            *left = flips_between_refreshes(topology, vertex);
            self.stale.push(vertex);
        } else {
            *left -= 1;
        }
        let is_due = *left == 0;
        if is_due {
            self.stale.retain(|&other| other != vertex);
        }
        is_due
    }

    /// Whether gains around a vertex may be stale.
    #[inline]
    pub(crate) fn has_stale_gains(&self, vertex: VertexId) -> bool {
        self.flips_left.get(vertex.index()).is_some_and(|&left| left > 0)
    }

    /// Takes the list of vertices with stale gains. The caller updates their stars.
    pub(crate) fn take_stale(&mut self) -> Vec<VertexId> {
        for vertex in &self.stale {
            self.flips_left[vertex.index()] = 0;
        }
        core::mem::take(&mut self.stale)
    }
}
