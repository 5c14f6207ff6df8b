//! One run from options to result: collapses, then what follows them.

use core::ops::ControlFlow;

use mesh_collapse::{Constraints, Cost, Level, Placement, Policies, Policy, Progress, Start};
use mesh_core::TriMesh;
use mesh_refine::Observer;

use crate::after_collapses::AfterCollapses;
use crate::collapse::collapse_to_level;
use crate::dispatch::collapse_with;
use crate::error::SimplifyError;
use crate::memory::check_memory;
use crate::options::Options;
use crate::plan::Plan;
use crate::simplified::Simplified;

/// Simplifies a mesh whose products of lengths neither overflow nor vanish, by one set of options.
pub(crate) fn run_plan(
    mesh: &TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    let mut observer = observer(mesh, options, observe);
    let plan = Plan::of(options, mesh);
    check_memory(&plan, mesh, options)?;
    let see = &mut |now: &_| observer.observe(now);
    let (level, run) = collapse_to_level(mesh, plan, options, see);
    let constraints = Constraints::default();
    AfterCollapses { mesh, constraints: &constraints, options }.result(level, run, observer)
}

/// Simplifies a mesh by custom policies; the options name neither cost nor placement.
pub(crate) fn run_policies(
    mesh: &TriMesh,
    mut policies: Policies<impl Cost, impl Placement>,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    let constraints = core::mem::take(&mut policies.constraints);
    let mut followers = constraints.clone();
    followers.prepare(mesh);
    let mut working = mesh.clone();
    let mut observer = observer(mesh, options, observe);
    let see = &mut |now: &_| observer.observe(now);
    let run = collapse_with(&mut working, policies, Start::followed_by(followers), options, see);
    let level = Level::at_end(working, &run);
    AfterCollapses { mesh, constraints: &constraints, options }.result(level, run, observer)
}

fn observer<'a>(
    mesh: &TriMesh,
    options: &Options,
    observe: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Observer<'a> {
    let faces_before = mesh.topology().face_count();
    Observer::new(faces_before, options.target.face_target(faces_before), observe)
}
