//! Insertion of a vertex where it costs least, and relocation of vertices.

use mesh_core::{EdgeId, VertexId};

use super::patch::Zone;
use super::round::{Checkpoint, Round};
use super::walk::{Reached, SearchLimits};
use crate::cost::FlipCost;

/// Neighbourhood that is searched for a better face.
const NEARBY: SearchLimits = SearchLimits { steps: 3, faces: 24 };
/// Largest number of relocations after the insertion of a vertex.
const MAX_RELOCATIONS: usize = 60;
/// Number of cheapest faces that an insertion compares after greedy flips. The face that is cheapest
/// before these flips may lead to a permanent fold.
pub(super) const COMPARED: usize = 5;

impl<C: FlipCost> Round<'_, '_, C> {
    /// Moves a vertex of valence three to the reachable face where it costs least.
    pub(super) fn insert_at_best(&mut self, v: VertexId, limits: SearchLimits, compared: usize) {
        let reached = self.reachable_faces(v, Zone::Surface, limits, None);
        let mut costs = self.costs_of_faces(v, &reached);
        costs.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        costs.truncate(compared);
        let start = self.checkpoint();
        let mut best = (f64::INFINITY, 0);
        if costs.len() > 1 {
            for &(_, face) in &costs {
                self.walk(v, &reached, face);
                self.descend(self.star_edges(v));
                if self.run.running_cost < best.0 {
                    best = (self.run.running_cost, face);
                }
                self.restore(start);
            }
        } else if let Some(&least) = costs.first() {
            best = least;
        }
        self.walk(v, &reached, best.1);
    }

    /// The cost with the vertex in each reachable face, by a depth-first walk through all of them.
    fn costs_of_faces(&mut self, v: VertexId, reached: &[Reached]) -> Vec<(f64, usize)> {
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); reached.len()];
        for (i, place) in reached.iter().enumerate().skip(1) {
            children[place.previous].push(i);
        }
        let mut costs = vec![(self.run.running_cost, 0)];
        let mut path = vec![(0, 0, self.checkpoint())];
        while let Some((face, tried, state)) = path.last_mut() {
            let state: Checkpoint = *state;
            let child = children[*face].get(*tried).copied();
            *tried += 1;
            if self.run.log.len() != state.flips {
                self.restore(state);
            }
            let Some(child) = child else {
                path.pop();
                continue;
            };
            if self.step(v, reached[child].side()) {
                costs.push((self.run.running_cost, child));
                path.push((child, 0, self.checkpoint()));
            }
        }
        costs
    }

    /// Moves a vertex of valence three to the face nearest to it, then to the best face near that one.
    pub(super) fn insert_near_home(&mut self, v: VertexId) {
        let home = self.run.mesh.position(v);
        let reached = self.reachable_faces(v, Zone::Surface, SearchLimits::NONE, None);
        let distance = |place: &Reached| {
            let [a, b, c] = self.run.mesh.triangle(place.face);
            ((a + b + c) / 3.0).distance_squared(home)
        };
        let others = reached.iter().enumerate().skip(1).map(|(i, place)| (i, distance(place)));
        if let Some((nearest, _)) = others.min_by(|p, q| p.1.total_cmp(&q.1)) {
            self.walk(v, &reached, nearest);
        }
        self.insert_at_best(v, NEARBY, COMPARED);
    }

    /// Relocates a vertex and its neighbours, and then the neighbours of each relocated vertex.
    pub(super) fn relocate_around(&mut self, v: VertexId) {
        let mut open = self.star_vertices(v);
        let mut left = MAX_RELOCATIONS;
        while let Some(w) = open.pop() {
            if left == 0 {
                return;
            }
            left -= 1;
            if self.patch.may_relocate(w) && self.relocate(w) {
                open = self.star_vertices(w);
            }
        }
    }

    /// The neighbours of a vertex, then the vertex.
    fn star_vertices(&self, v: VertexId) -> Vec<VertexId> {
        self.run.mesh.topology().one_ring(v).chain([v]).collect()
    }

    /// Moves a vertex to a better face nearby. Returns whether the cost has fallen; if not, nothing
    /// changes.
    fn relocate(&mut self, v: VertexId) -> bool {
        let start = self.checkpoint();
        if self.reduce_valence(v) {
            self.insert_at_best(v, NEARBY, 1);
            let star = self.star_edges(v);
            let flipped: Vec<EdgeId> = self.run.log[start.flips..].to_vec();
            self.descend(flipped.into_iter().chain(star).collect());
            if self.run.rules.is_gain_of_totals([start.cost, self.run.running_cost]) {
                return true;
            }
        }
        self.restore(start);
        false
    }
}
