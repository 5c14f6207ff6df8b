//! A cost modifier for changes of texture coordinates, normals and colours.

use glam::DVec3;
use mesh_collapse::{CostModifier, EdgePatch, Policy, Reach, Rejection, Scratch};
use mesh_core::{Remap, TriMesh};

use crate::attributes::wedges::CornerAttributes;

/// The cost plus w² times the *attribute deviation*. The deviation is a sum over both old ends of the edge and each of
/// their wedges. Each term is a third of the area of the faces of the wedge, times the squared difference between the
/// old value and the value at the closest point after the collapse.
///
/// With attributes scaled to model units, this has the unit of a quadric: area times squared length.
///
/// Rejects collapses after which a face would be reversed in the texture, or would have no area there.
#[derive(Clone, Debug)]
pub struct AttributeDeviation {
    weight: f64,
    attributes: CornerAttributes,
}

impl AttributeDeviation {
    /// The deviation of the attributes of a mesh before its simplification, with the weight w.
    #[must_use]
    pub fn new(attributes: CornerAttributes, weight: f64) -> Self {
        Self { weight, attributes }
    }
}

impl Policy for AttributeDeviation {
    fn compacted(&mut self, _: &TriMesh, remap: &Remap) {
        self.attributes.compact(remap);
    }
}

impl CostModifier for AttributeDeviation {
    fn raise(&self, cost: f64, patch: &EdgePatch<'_>, x: DVec3, _: &mut Scratch) -> f64 {
        cost + self.weight * self.weight * self.attributes.deviation(patch, x)
    }

    fn check(&self, patch: &EdgePatch<'_>, x: DVec3) -> Result<(), Rejection> {
        if self.attributes.folds(patch, x) { Err(Rejection::TextureFold) } else { Ok(()) }
    }

    fn reach(&self) -> Reach {
        Reach::OneRing
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, _: &mut Scratch) {
        self.attributes.collapsing(patch, x);
    }
}
