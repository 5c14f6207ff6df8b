//! Simulated annealing: leaves local minima.

use core::f64::consts::FRAC_PI_2;

use mesh_core::SplitMix64;
use mesh_core::{EdgeId, Handle};

use crate::cost::FlipCost;
use crate::fold::folds;
use crate::greedy;
use crate::options::Anneal;
use crate::progress::{Monitor, Phase, Progress};
use crate::report::Stop;
use crate::run::Run;

/// Anneals from the current local minimum. Returns the reason to stop and the number of flips of the last
/// round that was kept.
pub(crate) fn run<C: FlipCost>(
    run: &mut Run<'_, C>,
    settings: &Anneal,
    at_minimum: Stop,
    monitor: &mut Monitor<'_>,
) -> (Stop, u64) {
    let mut random = SplitMix64::new(settings.seed);
    run.forget_flips_of_edges();
    let mut best = Best { cost: run.total(), length: run.log.len(), stop: at_minimum };
    let mut kept_flips = 0;
    for _ in 0..settings.rounds {
        run.running_cost = best.cost;
        let stopped = round(run, settings, &mut random, monitor);
        run.forget_flips_of_edges();
        let stop = match stopped {
            Some(stop) => stop,
            None => greedy::run(run, run.rules.options.look_ahead, monitor),
        };
        let cost = run.total();
        if cost < best.cost {
            kept_flips = (run.log.len() - best.length) as u64;
            best = Best { cost, length: run.log.len(), stop };
        } else {
            run.undo_to(best.length);
        }
        if !matches!(stop, Stop::LocalMinimum | Stop::CycleGuard) {
            return (stop, kept_flips);
        }
    }
    (best.stop, kept_flips)
}

struct Best {
    cost: f64,
    /// Number of flips from the input.
    length: usize,
    stop: Stop,
}

/// One cooling schedule. Returns the reason if the monitor stops it.
fn round<C: FlipCost>(
    run: &mut Run<'_, C>,
    settings: &Anneal,
    random: &mut SplitMix64,
    monitor: &mut Monitor<'_>,
) -> Option<Stop> {
    let edges = run.mesh.topology().edge_capacity();
    let steps = settings.steps_per_edge.saturating_mul(edges);
    let unit = mean_absolute_change(run);
    let cooling = (settings.end / settings.start).ln() / steps.max(1) as f64;
    for step in 0..steps {
        let now = || Progress {
            phase: Phase::Annealing,
            flips: run.log.len() as u64,
            cost: run.running_cost,
            remaining: (steps - step) as u64,
        };
        if let Some(stop) = monitor.stop(now, run.log.len()) {
            return Some(stop);
        }
        let temperature = unit * settings.start * (cooling * step as f64).exp();
        let edge = EdgeId::from_index(((random.uniform() * edges as f64) as usize).min(edges - 1));
        try_flip(run, edge, temperature, random.uniform());
    }
    None
}

/// The step of Metropolis et al. 1953.
///
/// Flips that fold a face back are skipped: costs do not depend on the orientation, so a sequence of
/// folds could turn a small closed mesh inside out.
fn try_flip<C: FlipCost>(run: &mut Run<'_, C>, edge: EdgeId, temperature: f64, chance: f64) {
    let (Some(change), Some(quad)) = (run.change(edge), run.quad(edge)) else { return };
    if chance < (change.gain() / temperature).exp()
        && !folds(run.mesh, &quad, FRAC_PI_2)
        && let Ok(flip) = run.allow(edge)
    {
        run.record(flip, change);
    }
}

fn mean_absolute_change<C: FlipCost>(run: &Run<'_, C>) -> f64 {
    let topology = run.mesh.topology();
    let changes = topology.edges().filter_map(|edge| run.change(edge));
    let finite = changes.map(|change| change.gain().abs()).filter(|gain| gain.is_finite());
    let (sum, count) = finite.fold((0.0, 0_u32), |(sum, count), gain| (sum + gain, count + 1));
    if count == 0 { 0.0 } else { sum / f64::from(count) }
}
