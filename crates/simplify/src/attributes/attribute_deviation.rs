//! A cost that also counts how far texture coordinates, normals and colours would shift.

use std::cell::RefCell;
use std::rc::Rc;

use glam::DVec3;
use mesh_core::TriMesh;

use crate::attributes::wedges::CornerAttributes;
use crate::collapse::cost::{Cost, Reach};
use crate::collapse::patch::{Collapse, EdgePatch};
use crate::collapse::quadric::Quadric;

/// Another cost plus w² times the *attribute deviation*: over both old ends of the edge and each of
/// their wedges, the sum of a third of the area of the wedge's faces times the squared difference
/// between the value there and the one that is found at the closest point after the collapse.
///
/// With attributes scaled to model units, both have the unit of a quadric: area times squared
/// length. The other cost is a lower bound, so attributes are looked at only for edges that reach
/// the head of the queue.
pub struct AttributeDeviation {
    cost: Box<dyn Cost>,
    weight: f64,
    /// Shared with the guard against folds in the texture.
    attributes: Rc<RefCell<CornerAttributes>>,
}

impl AttributeDeviation {
    /// The deviation of these attributes with the weight w on top of `cost`.
    #[must_use]
    pub fn new(
        cost: Box<dyn Cost>,
        weight: f64,
        attributes: Rc<RefCell<CornerAttributes>>,
    ) -> Self {
        Self { cost, weight, attributes }
    }
}

impl Cost for AttributeDeviation {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.cost.prepare(mesh);
    }

    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        self.cost.quadric(patch)
    }

    fn cost(&self, patch: &EdgePatch<'_>, quadric: Option<&Quadric>, x: DVec3) -> f64 {
        let deviation = self.attributes.borrow().deviation(patch, x);
        self.cost.cost(patch, quadric, x) + self.weight * self.weight * deviation
    }

    fn lower_bound(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
    ) -> Option<f64> {
        let bound = self.cost.lower_bound(patch, quadric, x);
        bound.or_else(|| Some(self.cost.cost(patch, quadric, x)))
    }

    fn early_bound(&self, patch: &EdgePatch<'_>) -> Option<f64> {
        self.cost.early_bound(patch)
    }

    fn reach(&self) -> Reach {
        self.cost.reach().max(Reach::OneRing)
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3) {
        self.cost.collapsing(patch, x);
        self.attributes.borrow_mut().collapsing(patch, x);
    }

    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        self.cost.collapsed(mesh, collapse);
    }
}
