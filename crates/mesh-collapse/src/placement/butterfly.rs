//! The butterfly subdivision mask (Dyn, Levin and Gregory 1990), as in KKL02 section 4.1.

use glam::DVec3;
use mesh_core::butterfly::{ButterflyOptions, IrregularRule};

use super::Placement;
use crate::geometry::edge_patch::{EdgePatch, Place};
use crate::geometry::quadric::Quadric;
use crate::policy::{Needs, Policy};

/// Puts the vertex where butterfly subdivision would put the midpoint of the edge: by the eight-point mask, or by the
/// four-point mask along the boundary.
#[derive(Clone, Copy, Debug, Default)]
pub struct ButterflyPoint;

impl Policy for ButterflyPoint {}

impl Placement for ButterflyPoint {
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        _: Option<&Quadric>,
        _: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        let rule = ButterflyOptions { irregular: IrregularRule::EightPoint, ..Default::default() };
        let (mesh, edge) = (patch.mesh(), patch.half_edge().edge());
        let mut x = DVec3::ZERO;
        // The weights add up to one.
        rule.weights(mesh.topology(), edge, |v, weight| {
            x += weight * (mesh.position(v) - patch.origin());
        });
        Place::At(x)
    }

    fn needs(&self) -> Needs {
        Needs::Ends
    }
}
