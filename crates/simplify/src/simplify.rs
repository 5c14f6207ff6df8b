//! Simplification by options, and with custom policies.

use core::ops::ControlFlow;

use mesh_collapse::{Cost, Placement, Policies, Progress};
use mesh_core::{TriMesh, UnitScale};

use crate::cheaper::closest;
use crate::error::SimplifyError;
use crate::option_checks::check;
use crate::options::{Metric, Options, PlacementRule};
use crate::run::run_policies;
use crate::simplified::Simplified;

/// Simplifies a mesh.
///
/// ```
/// use mesh_core::TriMesh;
/// use simplify::{Options, Preset, simplify};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let soup = mesh_shapes::Sphere { radius: 1.0 }.icosphere(3)?;
/// # let mesh = TriMesh::from_soup(&soup)?;
/// let result = simplify(&mesh, &Options::preset(Preset::Default).to_faces(200))?;
/// assert_eq!(result.mesh.topology().face_count(), 200);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// An option makes no sense, a position is not finite, or there is too little memory.
pub fn simplify(mesh: &TriMesh, options: &Options) -> Result<Simplified, SimplifyError> {
    simplify_observed(mesh, options, &mut |_| ControlFlow::Continue(()))
}

/// Simplifies a mesh; `observe` sees the progress of all phases and may stop the run.
///
/// A mesh larger than 1e12 or smaller than 1e-12 is scaled by a power of two before, and the result is scaled back. So
/// the result for a mesh of any size is that for a mesh of size 1, scaled.
///
/// A stopped run returns the best mesh so far, and [`Simplified::stop`] is
/// [`StopReason::Cancelled`](crate::StopReason::Cancelled). That mesh is valid: it has the collapses so far, and
/// refinement up to that point. Its distance from the input is not measured. With an error limit, it is the coarsest
/// level measured to be within the limit, or the input if there is none.
///
/// # Errors
/// An option is out of range, options exclude each other, a position is not finite, the size of the mesh leaves too few
/// digits, or there is too little memory.
pub fn simplify_observed(
    mesh: &TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    check(mesh, options)?;
    if options.cost.metric == Metric::Custom || options.placement == PlacementRule::Custom {
        return Err(SimplifyError::Conflict {
            option: "a custom cost or placement",
            with: "a run without policies",
            cure: "call simplify_with, or name a metric and a placement",
        });
    }
    let Some(scale) = UnitScale::of(mesh)? else { return closest(mesh, options, observe) };
    let found = closest(&scale.mesh(mesh)?, &options.scaled(scale), observe)?;
    Ok(found.restored(scale, options))
}

/// Simplifies a mesh with custom cost, placement, cost modifiers and constraints. The options must be
/// [`Options::custom`]. Their protection, target, attributes, refinement and tolerance apply as in [`simplify()`];
/// custom constraints are also obeyed by the refinement. The mesh is not scaled, because policies know its size:
/// products of several lengths must be in the range of numbers.
///
/// # Errors
/// As [`simplify()`]; the options name a cost or a placement.
pub fn simplify_with(
    mesh: &TriMesh,
    policies: Policies<impl Cost, impl Placement>,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    check(mesh, options)?;
    if options.cost.metric != Metric::Custom || options.placement != PlacementRule::Custom {
        return Err(SimplifyError::Conflict {
            option: "a cost or placement by name",
            with: "policies of one's own",
            cure: "call Options::custom, so that the policies decide",
        });
    }
    run_policies(mesh, policies, options, observe)
}
