//! Runs of collapses with policies that are given by name.

use core::ops::ControlFlow;
use std::cell::RefCell;
use std::rc::Rc;

use mesh_core::TriMesh;

use crate::attributes::attribute_deviation::AttributeDeviation;
use crate::attributes::texture_guard::TextureGuard;
use crate::collapse::cost::{
    Cost, CurvatureFactor, CurvatureNorm, GarlandHeckbert, Hybrid, Memoryless, Norm,
};
use crate::collapse::driver::collapse_edges;
use crate::collapse::guard::{ComponentGuard, Guard, IntersectionGuard, NormalGuard, ShapeGuard};
use crate::collapse::placement::{BestEndpoint, ButterflyPoint, Midpoint, Optimal, Placement};
use crate::collapse::policies::Policies;
use crate::collapse::run::{Progress, Run};
use crate::options::{Metric, Options, PlacementRule};

/// Runs the driver with the policies that the options name.
pub(crate) fn collapse(
    mesh: &mut TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    let job = Job { mesh, options, texture: None, observe };
    match options.metric {
        Metric::Classic => job.with_factor(GarlandHeckbert::new()),
        Metric::Marginal => job.with_factor(GarlandHeckbert::marginal()),
        Metric::Memoryless => job.with_factor(Memoryless),
        Metric::Hybrid => job.with_factor(Hybrid::default()),
        Metric::CurvatureL1 => job.with_placement(CurvatureNorm::new(Norm::L1)),
        Metric::CurvatureL2 => job.with_placement(CurvatureNorm::new(Norm::L2)),
    }
}

/// A run whose policies are being chosen.
struct Job<'a> {
    mesh: &'a mut TriMesh,
    options: &'a Options,
    /// Set along with a cost that looks at attributes.
    texture: Option<TextureGuard>,
    observe: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
}

impl Job<'_> {
    fn with_factor(self, cost: impl Cost + 'static) -> Run {
        let weight = self.options.curvature_weight;
        if weight > 0.0 {
            self.with_attributes(CurvatureFactor::new(cost, weight))
        } else {
            self.with_attributes(cost)
        }
    }

    fn with_attributes(mut self, cost: impl Cost + 'static) -> Run {
        let weight = self.options.attribute_weight;
        let given = self.options.attributes.as_ref().filter(|_| weight > 0.0);
        let Some(attributes) = given else { return self.with_placement(cost) };
        let shared = Rc::new(RefCell::new(attributes.clone()));
        self.texture = Some(TextureGuard::new(Rc::clone(&shared)));
        self.with_placement(AttributeDeviation::new(Box::new(cost), weight, shared))
    }

    fn with_placement(self, cost: impl Cost) -> Run {
        match self.options.placement {
            PlacementRule::OptimalVolume => self.run(cost, Optimal { keep_volume: true }),
            PlacementRule::Optimal => self.run(cost, Optimal { keep_volume: false }),
            PlacementRule::Endpoint => self.run(cost, BestEndpoint),
            PlacementRule::Midpoint => self.run(cost, Midpoint),
            PlacementRule::Butterfly => self.run(cost, ButterflyPoint),
        }
    }

    fn run(self, cost: impl Cost, placement: impl Placement) -> Run {
        let Self { mesh, options, texture, observe } = self;
        let mut guards: Vec<Box<dyn Guard>> = Vec::new();
        if let Some(min_vertices) = options.min_component_vertices {
            guards.push(Box::new(ComponentGuard::new(min_vertices)));
        }
        if let Some(min_cosine) = options.min_cosine {
            guards.push(Box::new(NormalGuard { min_cosine }));
        }
        if let Some(min_shape) = options.min_shape {
            guards.push(Box::new(ShapeGuard { min_shape }));
        }
        if let Some(guard) = texture {
            guards.push(Box::new(guard));
        }
        // The most expensive check comes last.
        if options.forbid_intersections {
            guards.push(Box::new(IntersectionGuard::default()));
        }
        let policies = Policies { cost, placement, guards, update: options.update };
        collapse_edges(mesh, policies, &options.constraints, &options.limits, observe)
    }
}
