//! Vertices with very many edges, such as the apex of a cone.
//!
//! A cost that is a function of the sums round a vertex makes the gain of every edge of its star
//! depend on every flip there. To keep all of them exact takes a turn round the vertex for each flip,
//! and so time that grows with the square of the number of edges. Where a vertex has more than
//! [`CROWDED`] of them, what is near a flip is brought up to date at once, and the rest of the star
//! once in so many flips and when the queue is empty. A gain that has not been is computed again
//! before its flip is done. So every flip still lowers the cost and the end is a local minimum, but
//! the flip that is done is the best one up to some flips ago.

use mesh_core::{Topology, VertexId};

/// More faces round a vertex than this are very many. No usual mesh has such a vertex.
pub(crate) const CROWDED: usize = 256;

/// Of the edges round a vertex, the share whose flips may wait for the rest to be brought up to date.
const SHARE: usize = 16;

/// Whether a vertex has more faces than a limit; takes as many steps as that at most.
#[inline]
pub(crate) fn has_more_faces(topology: &Topology, vertex: VertexId, limit: usize) -> bool {
    topology.faces_of_vertex(vertex).nth(limit).is_some()
}

/// After how many flips at a vertex all round it is computed anew.
pub(crate) fn flips_between_turns(topology: &Topology, vertex: VertexId) -> u32 {
    (topology.faces_of_vertex(vertex).count() / SHARE).max(1) as u32
}

/// The crowded vertices that flips have changed since all their edges were up to date.
#[derive(Debug, Default)]
pub(crate) struct Crowded {
    /// How many flips more each vertex may have; 0 for those that are up to date. Empty until there
    /// is a crowded vertex.
    left: Vec<u32>,
    outdated: Vec<VertexId>,
}

impl Crowded {
    /// Notes a flip at a crowded vertex. Says whether it is time to bring it up to date, and counts
    /// it as that if so.
    pub(crate) fn note(&mut self, topology: &Topology, vertex: VertexId) -> bool {
        self.left.resize(topology.vertex_capacity(), 0);
        let left = &mut self.left[vertex.index()];
        if *left == 0 {
            *left = flips_between_turns(topology, vertex);
            self.outdated.push(vertex);
        } else {
            *left -= 1;
        }
        let is_due = *left == 0;
        if is_due {
            self.outdated.retain(|&other| other != vertex);
        }
        is_due
    }

    /// Whether some edges of a vertex may not be up to date.
    #[inline]
    pub(crate) fn is_outdated(&self, vertex: VertexId) -> bool {
        self.left.get(vertex.index()).is_some_and(|&left| left > 0)
    }

    /// The vertices that are not up to date, and counts them as that.
    pub(crate) fn take(&mut self) -> Vec<VertexId> {
        for vertex in &self.outdated {
            self.left[vertex.index()] = 0;
        }
        core::mem::take(&mut self.outdated)
    }
}
