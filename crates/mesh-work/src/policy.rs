//! How to simplify, by a few choices of the user.

use core::time::Duration;

use dtri_flip::feature_edges;
use mesh_core::TriMesh;
use simplify::{
    Boundary, ErrorCheck, FitNorm, Options, PlacementRule, Preset, Protect, RefineOptions, Target,
};

/// Changes to a preset; the default changes nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choices {
    /// The preset for everything else.
    pub preset: Preset,
    /// The placement of the remaining vertex of an edge; `None` for the rule of the preset.
    pub placement: Option<PlacementRule>,
    /// How much a change of curvature raises the cost; `None` for the weight of the preset.
    pub curvature_weight: Option<f64>,
    /// Rounds of fitting the result to the input, 0 for none; `None` for the number of the preset.
    pub fit_rounds: Option<usize>,
    /// The norm that the fit minimises; `None` for the norm of the preset.
    pub norm: Option<FitNorm>,
    /// The longest time for annealing; `None` for no limit. Only if the preset anneals.
    pub anneal_time: Option<Duration>,
    /// Whether boundary vertices are fixed.
    pub lock_boundary: bool,
    /// Edges are feature lines if the angle between the normals of the two faces exceeds this, in radians.
    pub feature_angle: Option<f64>,
    /// Whether collapses must not cause new intersections of faces.
    pub no_intersections: bool,
    /// The number of vertices that every component keeps.
    pub min_component_vertices: Option<usize>,
    /// Whether the distance from the input is certified instead of sampled.
    pub verify: bool,
    /// The seed of the random numbers of the fit.
    pub seed: u64,
}

impl Default for Choices {
    fn default() -> Self {
        Self {
            preset: Preset::default(),
            placement: None,
            curvature_weight: None,
            fit_rounds: None,
            norm: None,
            anneal_time: None,
            lock_boundary: false,
            feature_angle: None,
            no_intersections: false,
            min_component_vertices: None,
            verify: false,
            seed: 1,
        }
    }
}

impl Choices {
    /// Whether the result is fitted to the input, which uses random numbers.
    #[must_use]
    pub fn fits(&self) -> bool {
        let mut options = Options::preset(self.preset);
        self.adjust_fit(&mut options);
        options.refine.fit
    }

    /// Whether the result is annealed.
    #[must_use]
    pub fn anneals(&self) -> bool {
        let mut options = Options::preset(self.preset);
        self.adjust_fit(&mut options);
        options.refine.anneal
    }

    /// How distances from the input are measured.
    #[must_use]
    pub fn check(&self) -> ErrorCheck {
        if self.verify { ErrorCheck::Certified } else { ErrorCheck::Sampled }
    }

    /// The options for a mesh, without a largest error.
    #[must_use]
    pub fn options(&self, mesh: &TriMesh, target: Target) -> Options {
        let mut options = self.options_without_features(target);
        options.protect.features = self.feature_angle.map(|angle| feature_edges(mesh, angle));
        options
    }

    /// The options for a mesh that is not in memory, so that its feature lines are unknown.
    #[must_use]
    pub fn options_without_features(&self, target: Target) -> Options {
        let mut options = Options::preset(self.preset);
        options.tolerance.check = self.verify.then_some(ErrorCheck::Certified);
        options.target = target;
        options.protect = Protect {
            boundary: if self.lock_boundary { Boundary::Lock } else { Boundary::Quadrics },
            min_component_vertices: self.min_component_vertices,
            forbid_intersections: self.no_intersections,
            ..options.protect
        };
        if let Some(placement) = self.placement {
            options.placement = placement;
        }
        if let Some(weight) = self.curvature_weight {
            options.cost.curvature_weight = weight;
        }
        self.adjust_fit(&mut options);
        options
    }

    fn adjust_fit(&self, options: &mut Options) {
        let refine = &mut options.refine;
        match self.fit_rounds {
            Some(0) => *refine = RefineOptions { unfold: refine.unfold, ..RefineOptions::none() },
            Some(rounds) => (refine.fit, refine.tuning.fit.rounds) = (true, rounds),
            None => {}
        }
        refine.norm = self.norm.unwrap_or(refine.norm);
        refine.seed = self.seed;
        refine.tuning.anneal.time_limit = self.anneal_time;
    }
}
