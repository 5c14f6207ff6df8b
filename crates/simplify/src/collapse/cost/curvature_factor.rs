//! A distance cost, raised where a collapse changes the curvature.

use glam::DVec3;
use mesh_core::TriMesh;

use super::curvature_change::CurvatureChange;
use super::curvature_change::measure::Measure;
use super::{Cost, Reach};
use crate::collapse::patch::{Collapse, EdgePatch};
use crate::collapse::quadric::Quadric;

/// Another cost times 1 + w D, where D is the change of the integral of |k1| + |k2| over the patch
/// relative to the square root of its area: a number without unit.
///
/// The factor is at least one, so the other cost is a lower bound, and curvature is evaluated only
/// for edges that reach the head of the queue.
#[derive(Clone, Debug)]
pub struct CurvatureFactor<C> {
    cost: C,
    weight: f64,
    change: CurvatureChange,
}

impl<C: Cost> CurvatureFactor<C> {
    /// The factor with this weight w, not negative, on top of `cost`.
    #[must_use]
    pub fn new(cost: C, weight: f64) -> Self {
        let change = CurvatureChange::new(Measure::AbsIntegral);
        Self { cost, weight: weight.max(0.0), change }
    }
}

impl<C: Cost> Cost for CurvatureFactor<C> {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.cost.prepare(mesh);
        self.change.prepare(mesh);
    }

    #[inline]
    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        self.cost.quadric(patch)
    }

    fn cost(&self, patch: &EdgePatch<'_>, quadric: Option<&Quadric>, x: DVec3) -> f64 {
        let sums = self.change.of(patch, x);
        let size = patch.area().sqrt();
        let relative = (sums.after - sums.before).abs() / size;
        let factor = if size > 0.0 { 1.0 + self.weight * relative } else { 1.0 };
        self.cost.cost(patch, quadric, x) * factor
    }

    #[inline]
    fn lower_bound(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
    ) -> Option<f64> {
        Some(self.cost.cost(patch, quadric, x))
    }

    #[inline]
    fn early_bound(&self, patch: &EdgePatch<'_>) -> Option<f64> {
        self.cost.early_bound(patch)
    }

    fn reach(&self) -> Reach {
        self.cost.reach()
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3) {
        self.cost.collapsing(patch, x);
        self.change.collapsing(patch, x);
    }

    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        self.cost.collapsed(mesh, collapse);
    }
}
