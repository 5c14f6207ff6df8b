//! The pipeline: greedy descent with look-ahead, then rebuilding, then annealing.

use core::ops::ControlFlow;

use mesh_core::{TriMesh, UnitScale};

use crate::anneal;
use crate::cost::FlipCost;
use crate::error::FlipError;
use crate::greedy;
use crate::options::FlipOptions;
use crate::progress::{Monitor, Progress};
use crate::report::{FlipReport, Stop};
use crate::ruin_recreate;
use crate::rules::Rules;
use crate::run::Run;

/// Flips edges until no allowed flip lowers the cost; see [`FlipOptions`].
///
/// Vertices do not move. Handles of vertices, edges and faces stay valid, and so do vertex
/// attributes. Boundary edges never flip. The result has the same bits for any number of threads.
///
/// # Errors
/// An option is out of range or does not fit the mesh, or the size of the mesh leaves too few digits. The mesh is then
/// unchanged.
pub fn optimise<C: FlipCost>(
    mesh: &mut TriMesh,
    cost: &C,
    options: &FlipOptions,
) -> Result<FlipReport, FlipError> {
    optimise_with(mesh, cost, options, &mut |_| ControlFlow::Continue(()))
}

/// As [`optimise`], with progress reports. When `progress` returns [`ControlFlow::Break`], the run stops
/// with the best mesh so far.
///
/// A mesh larger than 1e12 or smaller than 1e-12 is scaled by a power of two during the run, so the cost sees it near
/// size 1.
///
/// # Errors
/// As [`optimise`].
pub fn optimise_with<C: FlipCost>(
    mesh: &mut TriMesh,
    cost: &C,
    options: &FlipOptions,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<FlipReport, FlipError> {
    options.check(mesh.topology().edge_capacity())?;
    let Some(scale) = UnitScale::of(mesh)? else {
        return Ok(of_ordinary_size(mesh, cost, options, progress));
    };
    let mut scaled = scale.mesh(mesh)?;
    let report = of_ordinary_size(&mut scaled, cost, options, progress);
    // Flips change no position.
    scaled.positions_mut().copy_from_slice(mesh.positions());
    *mesh = scaled;
    let original = |value: f64| scale.original_power(value, cost.length_exponent());
    Ok(FlipReport {
        cost_before: original(report.cost_before),
        cost_after: original(report.cost_after),
        ..report
    })
}

/// [`optimise_with`] for a mesh whose products of lengths neither overflow nor vanish, with checked options.
fn of_ordinary_size<C: FlipCost>(
    mesh: &mut TriMesh,
    cost: &C,
    options: &FlipOptions,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> FlipReport {
    let mut monitor = Monitor::new(options, progress);
    let rules = Rules::new(mesh, cost, options, monitor.deadline());
    let mut run = Run::new(mesh, rules);
    let cost_before = run.running_cost;
    let mut stop = descend(&mut run, &mut monitor);
    let mut rebuilt = 0;
    if let Some(settings) = &options.rebuild
        && matches!(stop, Stop::LocalMinimum | Stop::CycleGuard)
    {
        (stop, rebuilt) = ruin_recreate::run(&mut run, settings, stop, &mut monitor);
    }
    let mut annealed_flips = 0;
    if let Some(settings) = &options.anneal
        && matches!(stop, Stop::LocalMinimum | Stop::CycleGuard)
    {
        (stop, annealed_flips) = anneal::run(&mut run, settings, stop, &mut monitor);
    }
    FlipReport {
        cost_before,
        cost_after: cost.total(run.mesh),
        flips: run.log.len() as u64,
        rebuilt,
        annealed_flips,
        locked_edges: run.rules.locked.as_slice().iter().filter(|&&locked| locked).count(),
        rejected: run.rejected,
        stop,
    }
}

/// Greedy descent, with look-ahead if requested. The result is never worse than without look-ahead.
///
/// An early sequence of flips may lead to a worse minimum than single flips. So both variants run. If
/// the plain variant ends lower, look-ahead continues from its result.
fn descend<C: FlipCost>(run: &mut Run<'_, C>, monitor: &mut Monitor<'_>) -> Stop {
    if run.rules.options.look_ahead < 2 {
        return greedy::run(run, 1, monitor);
    }
    let (start, start_refused) = (run.running_cost, run.rejected);
    let plain_stop = greedy::run(run, 1, monitor);
    if !matches!(plain_stop, Stop::LocalMinimum | Stop::CycleGuard) {
        return plain_stop;
    }
    let (plain_cost, plain_refused) = (run.total(), run.rejected);
    let plain_flips = run.log.clone();
    run.start_over(start, start_refused);
    let stop = greedy::run(run, run.rules.options.look_ahead, monitor);
    if run.total() <= plain_cost {
        return stop;
    }
    run.start_over(plain_cost, plain_refused);
    run.repeat(&plain_flips);
    match stop {
        Stop::TimeLimit | Stop::Cancelled => stop,
        _ => greedy::run(run, run.rules.options.look_ahead, monitor),
    }
}
