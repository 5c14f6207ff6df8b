//! One round: remove the vertices of a patch, insert them again, keep the result if it is better.

use glam::DVec3;
use mesh_core::VertexId;

use super::checks::PatchChecks;
use super::insertion::COMPARED;
use super::patch::Patch;
use super::round::Round;
use super::walk::SearchLimits;
use crate::cost::FlipCost;
use crate::progress::{Monitor, Phase, Progress};
use crate::report::Stop;
use crate::run::Run;

/// Reports progress. Returns the reason to stop, if there is one.
pub(super) fn check<C: FlipCost>(
    run: &Run<'_, C>,
    monitor: &mut Monitor<'_>,
    left: usize,
) -> Option<Stop> {
    let (flips, cost) = (run.log.len() as u64, run.running_cost);
    monitor.check(|| Progress { phase: Phase::Rebuilding, flips, cost, remaining: left as u64 })
}

/// Performs one round. Returns whether its result was kept. If not, or if the round was stopped, the mesh
/// is as before.
pub(super) fn attempt<C: FlipCost>(
    run: &mut Run<'_, C>,
    patch: &mut Patch,
    is_local: bool,
    monitor: &mut Monitor<'_>,
    left: usize,
) -> Result<bool, Stop> {
    let before = run.rules.cost.prepared_total(run.mesh, &run.cache);
    let length = run.log.len();
    let checks = PatchChecks::new(run, patch);
    // Only the result is checked for crossings.
    let tree = run.tree.take();
    let homes: Vec<(VertexId, DVec3)> =
        patch.vertices.iter().map(|&v| (v, run.mesh.position(v))).collect();
    let mut round = Round { run: &mut *run, patch: &mut *patch, homes: &homes, is_local };
    round.remove_vertices();
    let stopped = round.insert_vertices(monitor, left).err();
    let after = run.rules.cost.prepared_total(run.mesh, &run.cache);
    run.tree = tree;
    update_tree(run, patch);
    let stopped =
        stopped.or_else(|| (monitor.flips_left(run.log.len()) == 0).then_some(Stop::FlipLimit));
    let is_better = stopped.is_none()
        && run.rules.is_gain_of_totals([before, after])
        && checks.allow(run, patch);
    if is_better {
        run.running_cost = after;
        let change = checks.volume_change(run, patch);
        patch.volume = patch.volume.map(|volume| volume + change);
    } else {
        run.undo_to(length);
        run.running_cost = before;
    }
    stopped.map_or(Ok(is_better), Err)
}

fn update_tree<C: FlipCost>(run: &mut Run<'_, C>, patch: &Patch) {
    let Run { mesh, tree, .. } = run;
    if let Some(tree) = tree {
        tree.update(mesh, patch.faces.iter().copied());
    }
}

impl<C: FlipCost> Round<'_, '_, C> {
    /// Removes the vertices of the patch from the surface and parks them.
    fn remove_vertices(&mut self) {
        for &(v, _) in self.homes {
            let start = self.checkpoint();
            let Some(corners) = self.patch.next_slot() else { return };
            if !(self.reduce_valence(v) && self.enter_parking(v, corners)) {
                self.restore(start);
                continue;
            }
            let centroid = corners.map(|w| self.run.mesh.position(w)).iter().sum::<DVec3>() / 3.0;
            self.move_vertex(v, centroid);
            self.patch.park(v, corners);
        }
    }

    /// Inserts all parked vertices. If the monitor stops the run, the remaining vertices return to
    /// their positions but not to their faces.
    fn insert_vertices(&mut self, monitor: &mut Monitor<'_>, left: usize) -> Result<(), Stop> {
        let mut homes = self.run.mesh.topology().vertex_map(DVec3::ZERO);
        self.homes.iter().for_each(|&(v, home)| homes[v] = home);
        while let Some(v) = self.patch.unpark() {
            if let Some(stop) = check(self.run, monitor, left) {
                self.move_vertex(v, homes[v]);
                while let Some(v) = self.patch.unpark() {
                    self.move_vertex(v, homes[v]);
                }
                return Err(stop);
            }
            let is_out = self.leave_parking(v);
            self.move_vertex(v, homes[v]);
            if !is_out {
                continue;
            }
            if self.is_local {
                self.insert_near_home(v);
            } else {
                self.insert_at_best(v, SearchLimits::NONE, COMPARED);
            }
            self.descend(self.star_edges(v));
            self.relocate_around(v);
        }
        let all = self.patch.edges.clone();
        self.descend(all);
        Ok(())
    }
}
