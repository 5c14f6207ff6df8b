//! Walks of a vertex of valence three from face to face.

use mesh_core::{EdgeId, FaceId, HalfEdgeId, VertexId};

use super::patch::Zone;
use super::round::Round;
use crate::cost::FlipCost;

/// A face that a vertex can reach.
pub(super) struct Reached {
    /// Index of the face before it on the way.
    pub(super) previous: usize,
    /// The side that the vertex crosses between them.
    side: EdgeId,
    pub(super) face: FaceId,
    steps: usize,
}

impl Reached {
    pub(super) fn side(&self) -> EdgeId {
        self.side
    }
}

/// Limits of a search for faces.
#[derive(Clone, Copy)]
pub(super) struct SearchLimits {
    pub(super) steps: usize,
    pub(super) faces: usize,
}

impl SearchLimits {
    pub(super) const NONE: Self = Self { steps: usize::MAX, faces: usize::MAX };
}

impl<C: FlipCost> Round<'_, '_, C> {
    /// Moves a vertex of valence three across a side of the face that it is in.
    pub(super) fn step(&mut self, v: VertexId, side: EdgeId) -> bool {
        let topology = self.run.mesh.topology();
        let ends = topology.edge_vertices(side);
        let is_behind =
            |&e: &EdgeId| !topology.edge_vertices(e).iter().any(|end| ends.contains(end));
        let Some(behind) = topology.edges_of_vertex(v).find(is_behind) else { return false };
        let start = self.checkpoint();
        if self.flip(side) && self.flip(behind) {
            return true;
        }
        self.restore(start);
        false
    }

    /// Walks a vertex of valence three into the parking face with these corners.
    pub(super) fn enter_parking(&mut self, v: VertexId, [a, b, _]: [VertexId; 3]) -> bool {
        let start = self.checkpoint();
        let is_in = self.patch.gate(self.run.mesh).is_some_and(|gate| {
            self.walk_to(v, gate.twin(), Zone::Surface) && self.step(v, gate.edge())
        });
        let goal = self.run.mesh.topology().find_half_edge(a, b);
        let is_in = is_in && goal.is_some_and(|goal| self.walk_to(v, goal, Zone::Parking));
        if !is_in {
            self.restore(start);
        }
        is_in
    }

    /// Walks a parked vertex to the face beyond the gate.
    pub(super) fn leave_parking(&mut self, v: VertexId) -> bool {
        let Some(gate) = self.patch.gate(self.run.mesh) else { return false };
        self.walk_to(v, gate, Zone::Parking)
            && self.patch.gate(self.run.mesh).is_some_and(|gate| self.step(v, gate.edge()))
    }

    /// Walks a vertex of valence three to the face of a half-edge, unless it is a corner of that face.
    fn walk_to(&mut self, v: VertexId, side: HalfEdgeId, zone: Zone) -> bool {
        let Some(goal) = self.run.mesh.topology().face(side) else { return false };
        if self.run.mesh.topology().face_vertices(goal).contains(&v) {
            return true;
        }
        let reached = self.reachable_faces(v, zone, SearchLimits::NONE, Some(goal));
        let at = reached.iter().position(|place| place.face == goal);
        at.is_some_and(|at| self.walk(v, &reached, at))
    }

    /// The faces that a vertex of valence three can reach, in breadth-first order. The first entry
    /// stands for the three faces at the vertex. The search ends at `goal`.
    pub(super) fn reachable_faces(
        &mut self,
        v: VertexId,
        zone: Zone,
        limits: SearchLimits,
        goal: Option<FaceId>,
    ) -> Vec<Reached> {
        let topology = self.run.mesh.topology();
        self.patch.visited.clear();
        let mut reached: Vec<Reached> = Vec::new();
        let mut own = topology.faces_of_vertex(v);
        let Some(face) = own.next() else { return reached };
        let side = topology.face_edges(face)[0];
        reached.push(Reached { previous: 0, side, face, steps: 0 });
        topology.faces_of_vertex(v).for_each(|f| {
            self.patch.visited.mark(f);
        });
        let mut at = 0;
        while at < reached.len() && reached.len() < limits.faces {
            let (face, steps) = (reached[at].face, reached[at].steps);
            let sides: Vec<EdgeId> = if at == 0 {
                let faces = topology.faces_of_vertex(v);
                let is_side = |&e: &EdgeId| !topology.edge_vertices(e).contains(&v);
                faces.flat_map(|f| topology.face_edges(f)).filter(is_side).collect()
            } else {
                topology.face_edges(face).to_vec()
            };
            let sides = if steps < limits.steps { sides } else { Vec::new() };
            for side in sides {
                if !self.patch.allows_crossing(self.run.mesh, side, zone) {
                    continue;
                }
                for next in topology.edge_faces(side).into_iter().flatten() {
                    if self.patch.visited.mark(next) {
                        reached.push(Reached { previous: at, side, face: next, steps: steps + 1 });
                        if goal == Some(next) {
                            return reached;
                        }
                    }
                }
            }
            at += 1;
        }
        reached
    }

    /// Walks a vertex of valence three to one of its reachable faces. Undoes the walk if it fails.
    pub(super) fn walk(&mut self, v: VertexId, reached: &[Reached], mut to: usize) -> bool {
        let start = self.checkpoint();
        let mut sides = Vec::new();
        while to != 0 {
            sides.push(reached[to].side);
            to = reached[to].previous;
        }
        let is_there = sides.into_iter().rev().all(|side| self.step(v, side));
        if !is_there {
            self.restore(start);
        }
        is_there
    }
}
