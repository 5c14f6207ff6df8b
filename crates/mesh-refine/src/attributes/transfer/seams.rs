//! Seams as lines between the vertices where they end, fork or cross.

use mesh_core::{EdgeId, EdgeMap, HalfEdgeId, HalfEdgeMap, Topology, VertexId, VertexMap};

/// The seams of the original as directed lines between nodes.
pub(super) struct SeamLines {
    /// For half-edges on a seam, twice the number of the line, plus one if the half-edge points against it.
    pub(super) label: HalfEdgeMap<Option<u32>>,
}

impl SeamLines {
    pub(super) fn new(topology: &Topology, seams: &EdgeMap<bool>) -> Self {
        let is_seam = |h: HalfEdgeId| {
            seams.get(h.edge()).is_some_and(|&seam| seam) && !topology.is_boundary_edge(h.edge())
        };
        let onward = |h: HalfEdgeId| {
            if topology.is_boundary_vertex(topology.target(h)) {
                return None;
            }
            let mut others =
                topology.outgoing(topology.target(h)).filter(|&o| is_seam(o) && o != h.twin());
            let only = others.next();
            only.filter(|_| others.next().is_none())
        };
        let mut label = topology.half_edge_map(None);
        let mut lines = 0;
        for start in topology.edges().map(EdgeId::half_edge).filter(|&h| is_seam(h)) {
            if label[start].is_some() {
                continue;
            }
            for (first, forward) in [(start, 0), (start.twin(), 1)] {
                let mut coming = Some(first);
                while let Some(h) = coming {
                    label[h] = Some(2 * lines + forward);
                    label[h.twin()] = Some(2 * lines + 1 - forward);
                    coming = onward(h).filter(|&next| label[next].is_none());
                }
            }
            lines += 1;
        }
        Self { label }
    }

    /// Whether a seam ends, forks or crosses another one or the boundary at a vertex.
    pub(super) fn is_node(&self, topology: &Topology, v: VertexId) -> bool {
        match topology.outgoing(v).filter(|&h| self.label[h].is_some()).count() {
            0 => false,
            2 => topology.is_boundary_vertex(v),
            _ => true,
        }
    }
}

/// The vertices at which seams end, fork, or cross each other or the boundary. They must be locked for
/// [`corner_sources`](crate::corner_sources) to be correct at them.
#[must_use]
pub fn seam_nodes(topology: &Topology, seams: &EdgeMap<bool>) -> VertexMap<bool> {
    let lines = SeamLines::new(topology, seams);
    let mut nodes = topology.vertex_map(false);
    for v in topology.vertices() {
        nodes[v] = lines.is_node(topology, v);
    }
    nodes
}

/// The first half-edge on a border, clockwise from a corner; `None` if the boundary comes first or there is no border.
pub(super) fn clockwise_border(
    topology: &Topology,
    corner: HalfEdgeId,
    is_border: impl Fn(HalfEdgeId) -> bool,
) -> Option<HalfEdgeId> {
    let mut side = corner;
    loop {
        if is_border(side) {
            return Some(side);
        }
        if topology.is_exterior(side.twin()) {
            return None;
        }
        side = topology.next(side.twin());
        if side == corner {
            return None;
        }
    }
}
