//! A distance cost, raised where a collapse changes the curvature.

use glam::DVec3;
use mesh_core::{Remap, TriMesh};

use super::cost_modifier::CostModifier;
use super::curvature_change::CurvatureChange;
use super::curvature_change::measure::Measure;
use crate::geometry::edge_patch::EdgePatch;
use crate::policy::{Policy, Scratch};

/// The cost times 1 + w D. D is the change of the integral of |k1| + |k2| over the patch, divided by the square root of
/// the area of the patch; it has no unit.
#[derive(Clone, Debug)]
pub struct CurvatureFactor {
    weight: f64,
    change: CurvatureChange,
}

impl CurvatureFactor {
    /// The factor with this weight w, not negative.
    #[must_use]
    pub fn new(weight: f64) -> Self {
        let change = CurvatureChange::new(Measure::AbsIntegral);
        Self { weight: weight.max(0.0), change }
    }
}

impl Policy for CurvatureFactor {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.change.prepare(mesh);
    }

    fn compacted(&mut self, _: &TriMesh, remap: &Remap) {
        self.change.compacted(remap);
    }
}

impl CostModifier for CurvatureFactor {
    fn raise(&self, cost: f64, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) -> f64 {
        let sums = self.change.of(patch, x, scratch);
        let size = patch.area().sqrt();
        let relative = (sums.after - sums.before).abs() / size;
        let factor = if size > 0.0 { 1.0 + self.weight * relative } else { 1.0 };
        cost * factor
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        self.change.collapsing(patch, x, scratch);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_shapes::polyhedra;

    #[test]
    fn a_patch_without_area_costs_no_more_for_its_curvature() {
        let mut mesh = TriMesh::from_soup(&polyhedra::icosahedron()).unwrap();
        mesh.positions_mut().fill(DVec3::ONE);
        let mut factor = CurvatureFactor::new(1.0);
        factor.prepare(&mesh);
        let (mut faces, edge) = (Vec::new(), mesh.topology().edges().next().unwrap());
        let patch = EdgePatch::gather(&mesh, edge.half_edge(), &mut faces);
        assert_eq!(factor.raise(2.0, &patch, DVec3::ZERO, &mut Scratch::default()), 2.0);
    }
}
