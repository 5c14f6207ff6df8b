//! The runs that the paper compares: distance only, and distance raised by curvature.

use mesh_core::TriMesh;
use simplify::{
    CostOptions, Metric, NormalConstraint, Options, PlacementRule, Preset, RefineOptions, Schedule,
    ShapeConstraint, Simplified, simplify,
};

use xtask_common::Failure;

/// The scan of the statue's head that the paper has too.
pub(super) const IGEA: &str = "igea.ply";
/// The leeway of results of long chains of decisions: rounding may turn one of them, and the rest
/// follows.
pub(super) const CHAINS: f64 = 0.02;

/// Distance only: the quadrics of the paper's first reference, as published.
pub(super) fn distance_only() -> Options {
    let cost = CostOptions {
        metric: Metric::Quadric,
        curvature_weight: 0.0,
        // One edge after the other over the whole mesh, as the paper has it.
        schedule: Schedule::Lazy,
        ..CostOptions::default()
    };
    Options {
        cost,
        placement: PlacementRule::Optimal,
        refine: RefineOptions::none(),
        ..Options::default()
    }
}

/// A curvature norm alone as published: every collapse that the topology allows.
pub(super) fn published(preset: Preset) -> Options {
    let mut options = Options::preset(preset);
    options.protect.min_cosine = None;
    options.protect.min_shape = None;
    options
}

/// A curvature norm alone with the constraints of the other presets: no collapse turns a face over or leaves a
/// needle.
pub(super) fn guarded(preset: Preset) -> Options {
    let mut options = Options::preset(preset);
    options.protect.min_cosine = Some(NormalConstraint::default().min_cosine);
    options.protect.min_shape = Some(ShapeConstraint::default().min_shape);
    options
}

/// The same, raised where a collapse changes the curvature.
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
    let fewest = faces.iter().copied().min().unwrap_or(0);
    let run = simplified(mesh, options, fewest)?;
    let level = |&faces: &usize| {
        let count = run.log.count_for_faces(faces);
        let mut level = run.log.replay(mesh, count).map_err(Failure::mesh)?;
        level.compact();
        Ok(level)
    };
    faces.iter().map(level).collect()
}
