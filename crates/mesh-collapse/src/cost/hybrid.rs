//! The memoryless quadric plus a part of the accumulated quadrics.

use glam::DVec3;
use mesh_core::{Remap, TriMesh};

use super::Cost;
use super::garland_heckbert::{AccumulatedQuadrics, length_tie};
use crate::geometry::edge_patch::{Collapse, EdgePatch};
use crate::geometry::quadric::Quadric;
use crate::policy::{Needs, Policy, Scratch};

/// The memoryless quadric of the current faces plus a part of the accumulated quadrics of the original faces.
///
/// The first gives a smaller mean error. The second prevents errors from adding up unnoticed.
#[derive(Clone, Debug)]
pub struct Hybrid {
    /// The weight of the accumulated quadrics.
    pub memory: f64,
    quadrics: AccumulatedQuadrics,
    /// Whether the quadrics come from an earlier run.
    goes_on: bool,
}

impl Hybrid {
    /// The cost with this weight of the accumulated quadrics.
    #[must_use]
    pub fn new(memory: f64) -> Self {
        Self { memory, quadrics: AccumulatedQuadrics::default(), goes_on: false }
    }

    /// Starts with quadrics that the vertices have accumulated in an earlier run, each about the position of its
    /// vertex.
    pub fn remembering(self, quadrics: Vec<Quadric>) -> Self {
        Self { quadrics: AccumulatedQuadrics::from_vec(quadrics), goes_on: true, ..self }
    }
}

impl Default for Hybrid {
    fn default() -> Self {
        Self::new(0.1)
    }
}

impl Policy for Hybrid {
    fn prepare(&mut self, mesh: &TriMesh) {
        if !self.goes_on {
            self.quadrics = AccumulatedQuadrics::new(mesh);
        }
    }

    fn collapsed(&mut self, _: &TriMesh, collapse: &Collapse) {
        self.quadrics.merge(collapse);
    }

    fn compacted(&mut self, _: &TriMesh, remap: &Remap) {
        self.quadrics.compact(remap);
    }
}

impl Cost for Hybrid {
    #[inline]
    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        let past = self.memory * self.quadrics.of_edge(patch);
        Some(patch.face_quadric() + past + *patch.border())
    }

    #[inline]
    fn cost(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
        _: &mut Scratch,
    ) -> f64 {
        quadric.map_or(0.0, |q| q.value(x)).max(0.0) + length_tie(patch)
    }

    fn needs(&self) -> Needs {
        Needs::Sums
    }
}
