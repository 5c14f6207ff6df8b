//! Runs of collapses with policies that are given by name.

use core::ops::ControlFlow;

use mesh_core::TriMesh;

use crate::options::{CollapseOptions, Metric, Options, PlacementRule};
use mesh_collapse::blocks::Rules;
use mesh_collapse::{
    BestEndpoint, Boundary, ButterflyPoint, Cost, CostModifier, CurvatureFactor, CurvatureNorm,
    GarlandHeckbert, Hybrid, Memoryless, Midpoint, Norm, Optimal, Placement, Policies, Progress,
    Protect, Quadric, Run, Schedule, Start, Target, collapse_edges_from,
};
use mesh_refine::AttributeDeviation;

/// What a run in regions goes by, and how far it goes.
pub(crate) struct Regional {
    pub(crate) rules: Rules,
    /// Whether something else has to follow: regions do not know the metric.
    pub(crate) is_start: bool,
}

/// What regions can do of what the options ask for.
pub(crate) fn regional(mesh: &TriMesh, options: &Options) -> Option<Regional> {
    let size = mesh.bounding_box().map_or(0.0, |bounds| bounds.diagonal());
    regional_at(size, options)
}

/// The same for a mesh of this size, the diagonal of its bounding box.
pub(crate) fn regional_at(size: f64, options: &Options) -> Option<Regional> {
    let Options { collapse, limit, attributes, .. } = options;
    let Protect { boundary, locked, features } = &collapse.protect;
    let is_start = match collapse.metric {
        Metric::Quadric | Metric::IncrementalQuadric if collapse.curvature_weight <= 0.0 => false,
        Metric::Hybrid => !is_left_to_squeeze(options),
        _ => return None,
    };
    let keep_volume = match collapse.placement {
        PlacementRule::OptimalVolume => true,
        PlacementRule::Optimal => false,
        _ => return None,
    };
    let Target { faces: _, ratio: _, time: _, vertices, cost, collapses } = collapse.limits;
    let can = collapse.schedule == Schedule::Parallel
        && attributes.counting().is_none()
        // Levels that are finished as they are have more faces when they come from regions.
        && (limit.distance.is_none() || limit.decimate)
        && *boundary != Boundary::Lock
        && locked.is_none()
        && features.is_none()
        && collapse.min_component_vertices.is_none()
        && !collapse.forbid_intersections
        && (vertices, cost, collapses) == (None, None, None);
    let rules = Rules {
        marginal: collapse.metric != Metric::Quadric,
        keep_volume,
        border: *boundary == Boundary::Quadrics,
        min_cosine: collapse.min_cosine,
        min_shape: collapse.min_shape,
        record: collapse.record || limit.distance.is_some(),
        ..Rules::of_size(size)
    };
    can.then_some(Regional { rules, is_start })
}

/// The weight of the curvature factor up to which it makes no difference to what is squeezed afterwards.
const LITTLE_CURVATURE: f64 = 0.1;

/// Whether all that another metric could do is done by the squeeze, by a metric of its own: where nothing but a
/// largest error ends the collapses, it takes three of four faces from the level that is within it. On ten models,
/// within .05, .2 and 1 % of the diagonal, mean numbers of faces after quadrics alone are the same within .4 %.
fn is_left_to_squeeze(options: &Options) -> bool {
    let CollapseOptions { switch_ratio, curvature_weight, ref limits, .. } = options.collapse;
    let is_alone = (limits.faces, limits.ratio) == (None, None);
    let has_little = curvature_weight <= LITTLE_CURVATURE;
    options.limit.decimate && is_alone && switch_ratio.is_some() && has_little
}

/// Runs the driver on what a run in regions has left, or on a part of it, with what its vertices remember.
pub(crate) fn collapse_on(
    mesh: &mut TriMesh,
    quadrics: Vec<Quadric>,
    start: Start,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    with_cost(Hybrid::default().remembering(quadrics), mesh, start, options, observe)
}

/// Runs the driver with the policies that the options name.
pub(crate) fn collapse(
    mesh: &mut TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    let start = Start::default();
    match options.collapse.metric {
        Metric::Quadric => with_cost(GarlandHeckbert::new(), mesh, start, options, observe),
        Metric::IncrementalQuadric => {
            with_cost(GarlandHeckbert::marginal(), mesh, start, options, observe)
        }
        Metric::Memoryless => with_cost(Memoryless, mesh, start, options, observe),
        Metric::Hybrid => with_cost(Hybrid::default(), mesh, start, options, observe),
        Metric::CurvatureL1 => {
            with_cost(CurvatureNorm::new(Norm::L1), mesh, start, options, observe)
        }
        Metric::CurvatureL2 => {
            with_cost(CurvatureNorm::new(Norm::L2), mesh, start, options, observe)
        }
    }
}

impl Metric {
    /// The cost of this name, for [`Policies`] that are put together at run time.
    #[must_use]
    pub fn cost(self) -> Box<dyn Cost> {
        match self {
            Self::Quadric => Box::new(GarlandHeckbert::new()),
            Self::IncrementalQuadric => Box::new(GarlandHeckbert::marginal()),
            Self::Memoryless => Box::new(Memoryless),
            Self::Hybrid => Box::new(Hybrid::default()),
            Self::CurvatureL1 => Box::new(CurvatureNorm::new(Norm::L1)),
            Self::CurvatureL2 => Box::new(CurvatureNorm::new(Norm::L2)),
        }
    }
}

impl PlacementRule {
    /// The placement of this name, for [`Policies`] that are put together at run time.
    #[must_use]
    pub fn placement(self) -> Box<dyn Placement> {
        match self {
            Self::OptimalVolume => Box::new(Optimal { keep_volume: true }),
            Self::Optimal => Box::new(Optimal { keep_volume: false }),
            Self::Endpoint => Box::new(BestEndpoint),
            Self::Midpoint => Box::new(Midpoint),
            Self::Butterfly => Box::new(ButterflyPoint),
        }
    }
}

fn with_cost(
    cost: impl Cost,
    mesh: &mut TriMesh,
    start: Start,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    match options.collapse.placement {
        PlacementRule::OptimalVolume => {
            with_both(cost, Optimal { keep_volume: true }, mesh, start, options, observe)
        }
        PlacementRule::Optimal => {
            with_both(cost, Optimal { keep_volume: false }, mesh, start, options, observe)
        }
        PlacementRule::Endpoint => with_both(cost, BestEndpoint, mesh, start, options, observe),
        PlacementRule::Midpoint => with_both(cost, Midpoint, mesh, start, options, observe),
        PlacementRule::Butterfly => with_both(cost, ButterflyPoint, mesh, start, options, observe),
    }
}

fn with_both(
    cost: impl Cost,
    placement: impl Placement,
    mesh: &mut TriMesh,
    start: Start,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    let mut modifiers: Vec<Box<dyn CostModifier>> = Vec::new();
    if options.collapse.curvature_weight > 0.0 {
        modifiers.push(Box::new(CurvatureFactor::new(options.collapse.curvature_weight)));
    }
    let (constraints, schedule) = (options.collapse.constraints(), options.collapse.schedule);
    let policies = Policies { cost, modifiers, placement, constraints, schedule };
    collapse_with(mesh, policies, start, options, observe)
}

/// Runs the driver with these policies, whatever the options name.
pub(crate) fn collapse_with(
    mesh: &mut TriMesh,
    mut policies: Policies<impl Cost, impl Placement>,
    start: Start,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    if let Some(corners) = options.attributes.counting() {
        let deviation = AttributeDeviation::new(corners.clone(), options.attributes.weight);
        policies.modifiers.push(Box::new(deviation));
    }
    let (protect, limits) = (&options.collapse.protect, &options.collapse.limits);
    collapse_edges_from(mesh, policies, start, protect, limits, observe)
}
