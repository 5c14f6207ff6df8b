//! Runs of collapses with policies that are given by name.

use core::ops::ControlFlow;

use mesh_collapse::{
    BestEndpoint, ButterflyPoint, Cost, CostModifier, CurvatureFactor, CurvatureNorm,
    GarlandHeckbert, Hybrid, LeastCost, Memoryless, Midpoint, Norm, Optimal, Placement, Policies,
    Progress, Quadric, Run, Start, collapse_edges_from,
};
use mesh_core::TriMesh;
use mesh_refine::{AttributeDeviation, Posed};

use crate::options::{Metric, Options, PlacementRule};

/// Runs the greedy loop on a part of a mesh, with the quadrics that its vertices have accumulated.
pub(crate) fn collapse_on(
    mesh: &mut TriMesh,
    quadrics: Vec<Quadric>,
    start: Start,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    with_cost(Hybrid::default().remembering(quadrics), mesh, start, options, observe)
}

/// Runs the greedy loop with the policies that the options name.
pub(crate) fn collapse(
    mesh: &mut TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    let start = Start::default();
    if let Some(poses) = &options.attributes.poses
        && let Some(cost) = options.cost.metric.cost()
        && let Some(placement) = options.placement.placement()
    {
        let cost = Posed::new(cost, poses.clone());
        return with_both(cost, placement, mesh, start, options, observe);
    }
    match options.cost.metric {
        Metric::Quadric => with_cost(GarlandHeckbert::new(), mesh, start, options, observe),
        Metric::IncrementalQuadric => {
            with_cost(GarlandHeckbert::marginal(), mesh, start, options, observe)
        }
        Metric::Memoryless => with_cost(Memoryless, mesh, start, options, observe),
        // There is no other cost here: `simplify` rejects `Custom`.
        Metric::Hybrid | Metric::Custom => {
            with_cost(Hybrid::default(), mesh, start, options, observe)
        }
        Metric::CurvatureL1 => {
            with_cost(CurvatureNorm::new(Norm::L1), mesh, start, options, observe)
        }
        Metric::CurvatureL2 => {
            with_cost(CurvatureNorm::new(Norm::L2), mesh, start, options, observe)
        }
    }
}

impl Metric {
    /// The cost of this name, for [`Policies`] that are put together at run time; `None` for [`Metric::Custom`].
    #[must_use]
    pub fn cost(self) -> Option<Box<dyn Cost>> {
        Some(match self {
            Self::Quadric => Box::new(GarlandHeckbert::new()),
            Self::IncrementalQuadric => Box::new(GarlandHeckbert::marginal()),
            Self::Memoryless => Box::new(Memoryless),
            Self::Hybrid => Box::new(Hybrid::default()),
            Self::CurvatureL1 => Box::new(CurvatureNorm::new(Norm::L1)),
            Self::CurvatureL2 => Box::new(CurvatureNorm::new(Norm::L2)),
            Self::Custom => return None,
        })
    }
}

impl PlacementRule {
    /// The placement of this name, for [`Policies`] that are put together at run time; `None` for
    /// [`PlacementRule::Custom`].
    #[must_use]
    pub fn placement(self) -> Option<Box<dyn Placement>> {
        Some(match self {
            Self::OptimalVolume => Box::new(Optimal { keep_volume: true }),
            Self::Optimal => Box::new(Optimal { keep_volume: false }),
            Self::Endpoint => Box::new(BestEndpoint),
            Self::Midpoint => Box::new(Midpoint),
            Self::Butterfly => Box::new(ButterflyPoint),
            Self::CurvatureOptimal => Box::new(LeastCost),
            Self::Custom => return None,
        })
    }
}

fn with_cost(
    cost: impl Cost,
    mesh: &mut TriMesh,
    start: Start,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    match options.placement {
        // There is no other placement here: `simplify` rejects `Custom`.
        PlacementRule::OptimalVolume | PlacementRule::Custom => {
            with_both(cost, Optimal { keep_volume: true }, mesh, start, options, observe)
        }
        PlacementRule::Optimal => {
            with_both(cost, Optimal { keep_volume: false }, mesh, start, options, observe)
        }
        PlacementRule::Endpoint => with_both(cost, BestEndpoint, mesh, start, options, observe),
        PlacementRule::Midpoint => with_both(cost, Midpoint, mesh, start, options, observe),
        PlacementRule::Butterfly => with_both(cost, ButterflyPoint, mesh, start, options, observe),
        PlacementRule::CurvatureOptimal => {
            with_both(cost, LeastCost, mesh, start, options, observe)
        }
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
    if options.cost.curvature_weight > 0.0 {
        modifiers.push(Box::new(CurvatureFactor::new(options.cost.curvature_weight)));
    }
    let schedule = options.cost.schedule;
    let policies = Policies { modifiers, schedule, ..Policies::new(cost, placement) };
    collapse_with(mesh, policies, start, options, observe)
}

/// Runs the greedy loop with these policies.
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
    let (protect, target) = (&options.protect, &options.target);
    collapse_edges_from(mesh, policies, start, protect, target, observe)
}
