//! Distances to an original, and what of them is chance.

use mesh_core::TriMesh;
use mesh_metric::{CompareOptions, Comparison, Surface, compare};

use xtask_common::Failure;

/// Means over all face counts that differ less are the same but for chance.
pub(super) const NOISE: f64 = 0.02;

/// An original to measure distances from, as the paper does with Metro.
pub(super) struct Original {
    pub(super) surface: Surface,
    pub(super) diagonal: f64,
    /// How many samples are taken on either surface.
    pub(super) samples: usize,
}

impl Original {
    pub(super) fn new(mesh: &TriMesh) -> Result<Self, Failure> {
        Self::with_samples(mesh, 100_000)
    }

    pub(super) fn with_samples(mesh: &TriMesh, samples: usize) -> Result<Self, Failure> {
        let surface = Surface::new(mesh).map_err(Failure::mesh)?;
        Ok(Self { diagonal: surface.bounding_box().diagonal(), surface, samples })
    }

    /// Both directions, from samples that lie uniformly on either surface.
    pub(super) fn compare(&self, mesh: &TriMesh) -> Result<Comparison, Failure> {
        self.compare_by(mesh, CompareOptions::default())
    }

    pub(super) fn compare_by(
        &self,
        mesh: &TriMesh,
        options: CompareOptions,
    ) -> Result<Comparison, Failure> {
        let surface = Surface::new(mesh).map_err(Failure::mesh)?;
        let options = CompareOptions { samples: self.samples, ..options };
        Ok(compare(&self.surface, &surface, &options))
    }

    /// The mean distance in percent of the diagonal of the bounding box.
    pub(super) fn mean_percent(&self, mesh: &TriMesh) -> Result<f64, Failure> {
        // Points on edges and at vertices count for the largest distance only.
        let faces_only = CompareOptions { vertices: false, edges: false, ..Default::default() };
        Ok(self.percent(self.compare_by(mesh, faces_only)?.mean()))
    }

    pub(super) fn percent(&self, length: f64) -> f64 {
        100.0 * length / self.diagonal
    }
}
