//! Legal edits in two steps: a check that returns a token or the reason why not, and an
//! application of the token that cannot fail.
//!
//! ```
//! use mesh_core::Topology;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut topology = Topology::from_triangles(4, &[[0, 1, 2], [2, 1, 3]])?;
//! let inner = topology.edges().find(|&e| !topology.is_boundary_edge(e)).ok_or("no inner edge")?;
//! let flip = topology.check_flip(inner)?;
//! topology.flip(flip);
//! assert_eq!(topology.edge_vertices(inner).map(|v| v.get()), [0, 3]);
//! # Ok(())
//! # }
//! ```
//!
//! A token stands for the mesh as it was checked. Any edit in between makes it stale, and applying
//! a stale token panics: that is a mistake in the program, never a matter of input.

// A token is used up by the edit it allows.
#![allow(clippy::needless_pass_by_value)]

mod collapse;
mod flip;
mod split;

pub use collapse::{CollapseRefusal, Collapsed, LegalCollapse};
pub use flip::{FlipRefusal, LegalFlip};
pub use split::{EdgeSplit, FaceSplit, LegalEdgeSplit, LegalFaceSplit, SplitRefusal};

use crate::handle::{HalfEdgeId, VertexId};
use crate::topology::Topology;

/// What the edits share.
impl Topology {
    /// Refuses a token that was made before another edit, and counts this one.
    fn advance_revision(&mut self, checked: u64) {
        assert_eq!(checked, self.revision, "the mesh was edited after this edit was checked");
        self.revision += 1;
    }

    /// Restores the rule that a boundary vertex stores its exterior half-edge, given any half-edge
    /// that starts at the vertex.
    fn anchor_vertex(&mut self, vertex: VertexId, outgoing: HalfEdgeId) {
        self.vertex_half_edge[vertex.index()] = Some(outgoing);
        let exterior = self.outgoing(vertex).find(|&h| self.is_exterior(h));
        if exterior.is_some() {
            self.vertex_half_edge[vertex.index()] = exterior;
        }
    }

    /// Makes `half_edge` follow `previous`.
    #[inline]
    fn link(&mut self, previous: HalfEdgeId, half_edge: HalfEdgeId) {
        self.half_edges[previous.index()].next = half_edge;
    }

    /// Makes three half-edges the circuit of the first one's face.
    fn circuit(&mut self, [first, second, third]: [HalfEdgeId; 3]) {
        self.link(first, second);
        self.link(second, third);
        self.link(third, first);
        self.half_edges[second.index()].face = self.face(first);
        self.half_edges[third.index()].face = self.face(first);
    }
}
