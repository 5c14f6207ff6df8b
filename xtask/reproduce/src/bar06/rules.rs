//! The rules that decide on flips: the paper's, and others beside it.

use core::f64::consts::FRAC_PI_2;

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions, FlipReport};
use mesh_core::TriMesh;

use super::super::flips::optimise;
use xtask_common::Failure;

/// What decides on flips.
pub(super) struct Rule {
    pub(super) name: &'static str,
    pub(super) cost: CostName,
    /// How far a face may turn, in radians.
    pub(super) max_fold: Option<f64>,
}

/// The rule as printed first, then others that stand on firmer ground.
pub(super) const RULES: [Rule; 4] = [
    Rule { name: "as printed", cost: CostName::Willmore, max_fold: None },
    Rule { name: "as printed, no folds", cost: CostName::Willmore, max_fold: Some(FRAC_PI_2) },
    Rule { name: "W itself", cost: CostName::WillmorePotential, max_fold: None },
    Rule { name: "F2", cost: CostName::F2, max_fold: None },
];

impl Rule {
    pub(super) fn optimise(&self, mesh: &mut TriMesh) -> Result<FlipReport, Failure> {
        let options = FlipOptions { max_fold: self.max_fold, ..FlipOptions::default() };
        optimise(mesh, self.cost, VertexArea::Voronoi, &options)
    }
}
