//! Valences of the vertices, and the limit above which edges wait.
//!
//! The evaluation of a patch goes around both ends of its edge. At the tip of a cone with n sides, that takes n steps
//! for each of n edges, repeatedly while the rim is collapsed. So the edges of such a vertex wait until collapses of
//! the rim have reduced its valence. If the rim cannot be collapsed, they stay.

use mesh_core::{EdgeId, Topology, VertexId};

/// The largest valence of a vertex whose edges may collapse.
pub(crate) const MOST_EDGES: u32 = 512;

/// With more edges at a vertex, its rejected edges are not tried again after every collapse beside it: on the way from
/// 512 edges down, that would take as many evaluations as the square of the valence, each in time of the valence.
const MANY_EDGES: u32 = 64;
/// They are tried again when the valence has fallen to a multiple of this, and at the end.
const STEP: u32 = 32;

/// Whether the rejected edges of a vertex of this valence are tried again later, and not now.
#[inline]
pub(crate) fn is_later(valence: u32) -> bool {
    valence > MANY_EDGES && !valence.is_multiple_of(STEP)
}

/// The valence of each vertex, by index.
#[derive(Clone, Debug)]
pub(super) struct ValenceTable(Vec<u32>);

impl ValenceTable {
    pub(super) fn new(topology: &Topology) -> Self {
        let mut counts = vec![0; topology.vertex_capacity()];
        for v in topology.edges().flat_map(|e| topology.edge_vertices(e)) {
            counts[v.index()] += 1;
        }
        Self(counts)
    }

    /// Whether the rejected edges of a vertex are tried again later, and not now.
    pub(super) fn is_later(&self, v: VertexId) -> bool {
        is_later(self.0[v.index()])
    }

    /// Whether the valence of a vertex is so high that its edges have to wait.
    pub(super) fn is_crowded(&self, v: VertexId) -> bool {
        self.0[v.index()] > MOST_EDGES
    }

    /// Whether an edge has to wait because of one of its ends.
    pub(super) fn has_to_wait(&self, topology: &Topology, edge: EdgeId) -> bool {
        topology.edge_vertices(edge).iter().any(|&v| self.is_crowded(v))
    }

    /// Updates the valences after a collapse; `apexes` are the third corners of the vanished faces. Each vanished face
    /// has merged two edges into one.
    pub(super) fn collapsed(
        &mut self,
        [removed, kept]: [VertexId; 2],
        apexes: [Option<VertexId>; 2],
    ) {
        let counts = &mut self.0;
        counts[kept.index()] += counts[removed.index()];
        counts[kept.index()] -= 2;
        for apex in apexes.into_iter().flatten() {
            counts[kept.index()] -= 1;
            counts[apex.index()] -= 1;
        }
        counts[removed.index()] = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::TriMesh;
    use mesh_shapes::Plane;

    #[test]
    fn counts_follow_collapses_inside_and_at_the_boundary() {
        let soup = Plane { half_width: 1.0 }.mesh(5, Default::default()).unwrap();
        let mut mesh = TriMesh::from_soup(&soup).unwrap();
        let mut valences = ValenceTable::new(mesh.topology());
        let mut collapses = 0;
        while let Some(legal) = {
            let topology = mesh.topology();
            let mut sides = topology.half_edges().skip(7 * collapses % 31);
            sides.find_map(|h| topology.check_collapse(h).ok().map(|legal| (h, legal)))
        } {
            let (h, legal) = legal;
            let topology = mesh.topology();
            let apexes = [h, h.twin()].map(|side| topology.apex(side));
            let ends = [legal.removed(), legal.kept()];
            let place = mesh.position(ends[1]);
            mesh.collapse(legal, place);
            valences.collapsed(ends, apexes);
            collapses += 1;
            for v in mesh.topology().vertices() {
                assert_eq!(valences.0[v.index()] as usize, mesh.topology().valence(v));
            }
        }
        assert!(collapses > 20);
    }
}
