//! State and basic operations of one round.

use glam::DVec3;
use mesh_core::{EdgeId, HalfEdgeId, VertexId};

use super::patch::Patch;
use crate::cost::FlipCost;
use crate::quad::Quad;
use crate::run::Run;

/// One round of removal and insertion.
pub(super) struct Round<'w, 'a, C: FlipCost> {
    pub(super) run: &'w mut Run<'a, C>,
    pub(super) patch: &'w mut Patch,
    /// The vertices of the patch and their positions.
    pub(super) homes: &'w [(VertexId, DVec3)],
    /// Whether a vertex is inserted near its own position. If not, all faces of the patch compete.
    pub(super) is_local: bool,
}

/// A state to return to.
#[derive(Clone, Copy)]
pub(super) struct Checkpoint {
    pub(super) flips: usize,
    pub(super) cost: f64,
}

impl<C: FlipCost> Round<'_, '_, C> {
    pub(super) fn checkpoint(&self) -> Checkpoint {
        Checkpoint { flips: self.run.log.len(), cost: self.run.running_cost }
    }

    /// Undoes all flips after a checkpoint. No vertex may have moved since.
    pub(super) fn restore(&mut self, to: Checkpoint) {
        self.run.undo_to(to.flips);
        self.run.running_cost = to.cost;
    }

    /// Moves a vertex in space and updates the cache of the cost around it.
    pub(super) fn move_vertex(&mut self, v: VertexId, to: DVec3) {
        self.run.mesh.positions_mut()[v.index()] = to;
        let topology = self.run.mesh.topology();
        let quads: Vec<Quad> =
            topology.edges_of_vertex(v).filter_map(|e| Quad::around(topology, e)).collect();
        let Run { mesh, cache, rules, .. } = &mut *self.run;
        quads.iter().for_each(|quad| rules.cost.update(mesh, cache, quad));
    }

    /// Flips an edge regardless of its cost. Returns whether the flip is legal.
    pub(super) fn flip(&mut self, edge: EdgeId) -> bool {
        let Some(change) = self.run.change(edge) else { return false };
        let Ok(flip) = self.run.mesh.topology().check_flip(edge) else { return false };
        self.run.record(flip, change);
        true
    }

    /// Flips edges of a vertex away, the cheapest first, until its valence is three.
    pub(super) fn reduce_valence(&mut self, v: VertexId) -> bool {
        while self.run.mesh.topology().valence(v) > 3 {
            let topology = self.run.mesh.topology();
            let may_flip = |&e: &EdgeId| {
                self.patch.allows_flip(self.run.mesh, e) && topology.check_flip(e).is_ok()
            };
            let gain = |e: EdgeId| self.run.change(e).map(|change| (change.gain(), e));
            let gains = topology.edges_of_vertex(v).filter(may_flip).filter_map(gain);
            let Some((_, best)) = gains.max_by(|p, q| p.0.total_cmp(&q.0)) else { return false };
            if !self.flip(best) {
                return false;
            }
        }
        true
    }

    /// The edges of the triangles around a vertex.
    pub(super) fn star_edges(&self, v: VertexId) -> Vec<EdgeId> {
        let topology = self.run.mesh.topology();
        topology.faces_of_vertex(v).flat_map(|f| topology.face_edges(f)).collect()
    }

    /// Flips these edges, and the edges near each flip, while that lowers the cost.
    pub(super) fn descend(&mut self, mut open: Vec<EdgeId>) {
        // A cost that is no potential may cycle.
        let mut left = 64 * (self.patch.edges.len() + open.len());
        while let Some(edge) = open.pop() {
            if left == 0 {
                return;
            }
            left -= 1;
            if !self.patch.allows_flip(self.run.mesh, edge) {
                continue;
            }
            let Some(change) = self.run.gainful_change(edge) else { continue };
            let Ok(flip) = self.run.allow(edge) else { continue };
            let Some(quad) = self.run.record(flip, change) else { continue };
            let topology = self.run.mesh.topology();
            for side in quad.sides {
                open.push(side.edge());
                let beyond = Quad::around(topology, side.edge());
                open.extend(beyond.into_iter().flat_map(|quad| quad.sides).map(HalfEdgeId::edge));
            }
        }
    }
}
