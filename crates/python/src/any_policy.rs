//! Costs and placements of the library behind one type each, chosen by name at run time.

use ::simplify::{
    BestEndpoint, ButterflyPoint, Collapse, Cost, CurvatureNorm, EdgePatch, GarlandHeckbert,
    Hybrid, Memoryless, Metric, Midpoint, Norm, Optimal, Place, Placement, PlacementRule, Policy,
    Quadric, Reach, Refusal, Scratch,
};
use mesh_core::glam::DVec3;
use mesh_core::{Remap, TriMesh};

use crate::failure::Failure;

/// Any cost.
pub(crate) struct AnyCost(pub(crate) Box<dyn Cost>);

/// Any placement.
pub(crate) struct AnyPlacement(Box<dyn Placement>);

impl AnyCost {
    pub(crate) fn of(metric: Metric) -> Result<Self, Failure> {
        Ok(Self(match metric {
            Metric::Classic => Box::new(GarlandHeckbert::new()),
            Metric::Marginal => Box::new(GarlandHeckbert::marginal()),
            Metric::Memoryless => Box::new(Memoryless),
            Metric::Hybrid => Box::new(Hybrid::default()),
            Metric::CurvatureL1 => Box::new(CurvatureNorm::new(Norm::L1)),
            Metric::CurvatureL2 => Box::new(CurvatureNorm::new(Norm::L2)),
            other => return Err(Failure::internal(format!("no cost {other:?}"))),
        }))
    }
}

impl AnyPlacement {
    pub(crate) fn of(rule: PlacementRule) -> Result<Self, Failure> {
        Ok(Self(match rule {
            PlacementRule::OptimalVolume => Box::new(Optimal { keep_volume: true }),
            PlacementRule::Optimal => Box::new(Optimal { keep_volume: false }),
            PlacementRule::Endpoint => Box::new(BestEndpoint),
            PlacementRule::Midpoint => Box::new(Midpoint),
            PlacementRule::Butterfly => Box::new(ButterflyPoint),
            other => return Err(Failure::internal(format!("no placement {other:?}"))),
        }))
    }
}

impl Policy for AnyCost {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.0.prepare(mesh);
    }

    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        self.0.collapsed(mesh, collapse);
    }

    fn compacted(&mut self, mesh: &TriMesh, remap: &Remap) {
        self.0.compacted(mesh, remap);
    }
}

impl Policy for AnyPlacement {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.0.prepare(mesh);
    }

    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        self.0.collapsed(mesh, collapse);
    }

    fn compacted(&mut self, mesh: &TriMesh, remap: &Remap) {
        self.0.compacted(mesh, remap);
    }
}

impl Cost for AnyCost {
    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        self.0.quadric(patch)
    }

    fn cost(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> f64 {
        self.0.cost(patch, quadric, x, scratch)
    }

    fn lower_bound(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
    ) -> Option<f64> {
        self.0.lower_bound(patch, quadric, x)
    }

    fn early_bound(&self, patch: &EdgePatch<'_>) -> Option<f64> {
        self.0.early_bound(patch)
    }

    fn needs_faces(&self) -> bool {
        self.0.needs_faces()
    }

    fn reach(&self) -> Reach {
        self.0.reach()
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        self.0.collapsing(patch, x, scratch);
    }
}

impl Placement for AnyPlacement {
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        cost: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        self.0.place(patch, quadric, cost)
    }

    fn check(&self, patch: &EdgePatch<'_>, x: DVec3) -> Result<(), Refusal> {
        self.0.check(patch, x)
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        self.0.collapsing(patch, x, scratch);
    }

    fn needs_faces(&self) -> bool {
        self.0.needs_faces()
    }
}
