//! A distance cost with the change of the curvature norm added.

use glam::DVec3;
use mesh_core::{Remap, TriMesh};

use super::cost_modifier::CostModifier;
use super::curvature_change::CurvatureChange;
use super::curvature_norm::Norm;
use crate::geometry::edge_patch::EdgePatch;
use crate::policy::{Policy, Scratch};

/// The cost plus w D, where D is the absolute change of the discrete curvature norm
/// ([`CurvatureNorm`](super::CurvatureNorm)).
///
/// KKL02 section 4.2 applies the norm "together with a distance metric" and does not say how. A sum
/// is one reading; [`CurvatureFactor`](super::CurvatureFactor), which multiplies, is another. Here
/// the weight has a unit: that of the cost over that of the norm. So a result depends on the scale
/// of the model unless the weight is scaled too.
#[derive(Clone, Debug)]
pub struct CurvatureTerm {
    weight: f64,
    change: CurvatureChange,
}

impl CurvatureTerm {
    /// The term with this norm and this weight w, not negative.
    #[must_use]
    pub fn new(norm: Norm, weight: f64) -> Self {
        Self { weight: weight.max(0.0), change: CurvatureChange::new(norm.measure()) }
    }
}

impl Policy for CurvatureTerm {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.change.prepare(mesh);
    }

    fn compacted(&mut self, _: &TriMesh, remap: &Remap) {
        self.change.compacted(remap);
    }
}

impl CostModifier for CurvatureTerm {
    fn raise(&self, cost: f64, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) -> f64 {
        let sums = self.change.of(patch, x, scratch);
        cost + self.weight * (sums.after - sums.before).abs()
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        self.change.collapsing(patch, x, scratch);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::{Cost, CurvatureNorm};
    use mesh_shapes::Sphere;

    #[test]
    fn the_term_is_the_weighted_cost_of_the_norm() {
        let soup = Sphere { radius: 1.0 }.random_hull(60, 2).unwrap();
        let mesh = TriMesh::from_soup(&soup).unwrap();
        let mut faces = Vec::new();
        for norm in [Norm::L1, Norm::L2] {
            let mut alone = CurvatureNorm::new(norm);
            let mut term = CurvatureTerm::new(norm, 3.0);
            alone.prepare(&mesh);
            term.prepare(&mesh);
            for h in mesh.topology().half_edges() {
                let patch = EdgePatch::gather(&mesh, h, &mut faces);
                let x = DVec3::new(0.02, 0.0, -0.01);
                let cost = alone.cost(&patch, None, x, &mut Scratch::default());
                let raised = term.raise(0.5, &patch, x, &mut Scratch::default());
                assert!((raised - (0.5 + 3.0 * cost)).abs() < 1e-9 * raised, "{norm:?} {h:?}");
            }
        }
    }
}
