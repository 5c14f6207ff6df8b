//! From a mesh to a better one: the greedy run, look-ahead, rebuilding, and annealing, one after the
//! other.

use core::ops::ControlFlow;

use mesh_core::TriMesh;

use crate::anneal;
use crate::cost::FlipCost;
use crate::error::FlipError;
use crate::greedy;
use crate::options::FlipOptions;
use crate::rebuild;
use crate::report::{FlipReport, Stop};
use crate::rules::Rules;
use crate::run::Run;
use crate::watch::{Progress, Watch};

/// Flips edges until no allowed flip lowers the cost; see [`FlipOptions`] for all that can be
/// asked for.
///
/// Handles of vertices, edges and faces stay valid, and so do attributes on vertices. Isolated
/// vertices and removed elements are left alone; boundary edges stay. The same input gives the
/// same result for any number of threads.
///
/// # Errors
/// An option is out of range or does not fit the mesh. The mesh is unchanged then.
pub fn optimise<C: FlipCost>(
    mesh: &mut TriMesh,
    cost: &C,
    options: &FlipOptions,
) -> Result<FlipReport, FlipError> {
    optimise_with(mesh, cost, options, &mut |_| ControlFlow::Continue(()))
}

/// As [`optimise`], telling `progress` now and then where it is. When that returns
/// [`ControlFlow::Break`], the run stops with the best mesh it has.
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
    let mut watch = Watch::new(options, progress);
    let rules = Rules::new(mesh, cost, options, watch.deadline());
    let mut run = Run::new(mesh, rules);
    let cost_before = run.running_cost;
    let mut stop = descend(&mut run, &mut watch);
    let mut rebuilt = 0;
    if let Some(settings) = &options.rebuild
        && matches!(stop, Stop::LocalMinimum | Stop::CycleGuard)
    {
        (stop, rebuilt) = rebuild::run(&mut run, settings, stop, &mut watch);
    }
    let mut annealed_flips = 0;
    if let Some(settings) = &options.anneal
        && matches!(stop, Stop::LocalMinimum | Stop::CycleGuard)
    {
        (stop, annealed_flips) = anneal::run(&mut run, settings, stop, &mut watch);
    }
    Ok(FlipReport {
        cost_before,
        cost_after: cost.total(run.mesh),
        flips: run.log.len() as u64,
        rebuilt,
        annealed_flips,
        locked_edges: run.rules.locked.as_slice().iter().filter(|&&locked| locked).count(),
        refused: run.refused,
        stop,
    })
}

/// Greedy, with look-ahead if that was asked for; never worse than without.
///
/// A row of flips that is taken early may lead to a worse minimum than single flips would have.
/// So both ways are tried, and where the plain one gets lower, look-ahead goes on from its end.
fn descend<C: FlipCost>(run: &mut Run<'_, C>, watch: &mut Watch<'_>) -> Stop {
    if run.rules.options.look_ahead < 2 {
        return greedy::run(run, 1, watch);
    }
    let (start, start_refused) = (run.running_cost, run.refused);
    let plain_stop = greedy::run(run, 1, watch);
    if !matches!(plain_stop, Stop::LocalMinimum | Stop::CycleGuard) {
        return plain_stop;
    }
    let (plain_cost, plain_refused) = (run.total(), run.refused);
    let plain_flips = run.log.clone();
    run.start_over(start, start_refused);
    let stop = greedy::run(run, run.rules.options.look_ahead, watch);
    if run.total() <= plain_cost {
        return stop;
    }
    run.start_over(plain_cost, plain_refused);
    run.repeat(&plain_flips);
    match stop {
        Stop::TimeLimit | Stop::Cancelled => stop,
        _ => greedy::run(run, run.rules.options.look_ahead, watch),
    }
}
