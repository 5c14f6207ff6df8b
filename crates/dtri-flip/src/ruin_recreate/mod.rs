//! Ruin and recreate (Schrimpf, Schneider, Stamm-Wilbrandt and Dueck 2000): leaves deep local minima.
//!
//! Single flips cannot move a vertex from one side of a fold to the other. But a vertex of valence
//! three can walk through a triangulation with two flips per step: the first flip turns the side that
//! it crosses into its fourth edge, the second flip removes its first edge. A round removes the
//! vertices of a patch one by one, parks them in one face, and inserts them again one by one. Each
//! vertex tries the few faces where it costs least, with greedy flips around it. Then it and its
//! neighbours are relocated while that lowers the cost.
//!
//! A parked vertex lies flat in its face, so its edges have no dihedral angle and do not affect the
//! cost nearby.

mod attempt;
mod checks;
mod insertion;
mod patch;
mod round;
mod walk;

use mesh_core::SplitMix64;

use crate::cost::FlipCost;
use crate::greedy;
use crate::options::Rebuild;
use crate::progress::Monitor;
use crate::report::Stop;
use crate::run::Run;
use attempt::{attempt, check};
use patch::{MIN_PATCH, Patch};

/// Rebuilds patches, starting from a local minimum. Returns the reason to stop and the number of rounds
/// that lowered the cost.
pub(crate) fn run<C: FlipCost>(
    run: &mut Run<'_, C>,
    settings: &Rebuild,
    at_minimum: Stop,
    monitor: &mut Monitor<'_>,
) -> (Stop, u64) {
    let vertices = run.mesh.topology().vertex_count();
    let mut random = SplitMix64::new(settings.seed);
    let mut patch = Patch::new(run.mesh);
    let all = settings.effort.saturating_mul(vertices);
    let patience = if all > 0 { all.max(MIN_PATIENCE) } else { 0 };
    let mut left = patience;
    let mut kept = 0;
    let mut stopped = None;
    let mut round = 0_u64;
    while left > 0 && stopped.is_none() {
        let size = patch_size(settings, vertices, round, &mut random);
        round += 1;
        let is_found = patch.choose(run, size, &mut random);
        left = left.saturating_sub(patch.vertices.len().max(MIN_PATCH));
        if !is_found {
            stopped = check(run, monitor, left);
            continue;
        }
        let is_local = random.uniform() < LOCAL_SHARE;
        match attempt(run, &mut patch, is_local, monitor, left) {
            Ok(true) => (kept, left) = (kept + 1, patience),
            Ok(false) => {}
            Err(stop) => stopped = Some(stop),
        }
    }
    run.forget_flips_of_edges();
    let stop = match stopped {
        Some(stop) => stop,
        None if kept == 0 => at_minimum,
        None => greedy::run(run, run.rules.options.look_ahead, monitor),
    };
    (stop, kept)
}

/// Smallest number of removed vertices without improvement before the search ends.
const MIN_PATIENCE: usize = 600;
/// One round in this many uses the largest patch.
const LARGEST_EVERY: u64 = 8;

/// Share of the rounds that insert a vertex near its own position. The others try all faces of the
/// patch, which takes as many flips as there are faces.
const LOCAL_SHARE: f64 = 0.75;

/// A random patch size, uniform in its logarithm.
fn patch_size(settings: &Rebuild, vertices: usize, round: u64, random: &mut SplitMix64) -> usize {
    let largest = settings.largest.min(vertices).max(MIN_PATCH);
    let share = random.uniform();
    if round.is_multiple_of(LARGEST_EVERY) && largest == vertices {
        return largest;
    }
    let ratio = largest as f64 / MIN_PATCH as f64;
    ((MIN_PATCH as f64 * ratio.powf(share)) as usize).min(largest)
}
