//! The runs that the paper compares: distance only, and distance raised by curvature.

use core::ops::ControlFlow;

use mesh_core::TriMesh;
use simplify::{
    Cost, Options, Placement, PlacementRule, Policies, Preset, Simplified, simplify, simplify_with,
};

use xtask_common::Failure;

/// The scan of the statue's head that the paper has too.
pub(super) const IGEA: &str = "igea.ply";
/// The leeway of results of long chains of decisions: rounding may turn one of them, and the rest
/// follows.
pub(super) const CHAINS: f64 = 0.02;

/// Distance only: the quadrics of the paper's first reference, as published.
pub(super) fn distance_only() -> Options {
    Options::preset(Preset::Quadrics)
}

/// Distance, raised where a collapse changes the curvature.
pub(super) fn with_curvature(weight: f64) -> Options {
    let mut options = distance_only();
    options.cost.curvature_weight = weight;
    options
}

/// The same with the new vertex where the paper puts it.
pub(super) fn butterfly(mut options: Options) -> Options {
    options.placement = PlacementRule::Butterfly;
    options
}

pub(super) fn simplified(
    mesh: &TriMesh,
    options: Options,
    faces: usize,
) -> Result<Simplified, Failure> {
    simplify(mesh, &options.to_faces(faces)).map_err(Failure::mesh)
}

/// Several face counts from one run: that of the fewest faces, stopped early.
pub(super) fn levels(
    mesh: &TriMesh,
    options: Options,
    faces: &[usize],
) -> Result<Vec<TriMesh>, Failure> {
    levels_of(mesh, &simplified(mesh, options, fewest(faces))?, faces)
}

/// The same with a cost, modifiers and a placement without a name; the options say the rest.
pub(super) fn levels_with<C: Cost, P: Placement>(
    mesh: &TriMesh,
    policies: Policies<C, P>,
    options: Options,
    faces: &[usize],
) -> Result<Vec<TriMesh>, Failure> {
    let options = options.custom().to_faces(fewest(faces));
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let run = simplify_with(mesh, policies, &options, go_on).map_err(Failure::mesh)?;
    levels_of(mesh, &run, faces)
}

fn fewest(faces: &[usize]) -> usize {
    faces.iter().copied().min().unwrap_or(0)
}

fn levels_of(mesh: &TriMesh, run: &Simplified, faces: &[usize]) -> Result<Vec<TriMesh>, Failure> {
    let level = |&faces: &usize| {
        let count = run.log.count_for_faces(faces);
        let mut level = run.log.replay(mesh, count).map_err(Failure::mesh)?;
        level.compact();
        Ok(level)
    };
    faces.iter().map(level).collect()
}
