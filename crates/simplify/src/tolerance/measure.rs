//! The distance of a mesh from the original.

use mesh_collapse::Phase;
use mesh_core::TriMesh;
use mesh_metric::{
    CertifiedBounds, CertifyOptions, CompareOptions, Surface, SurfaceError, hausdorff_bounds_until,
    sampled_hausdorff,
};
use mesh_refine::Observer;

/// How the distance of the result from the original is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum ErrorCheck {
    /// From samples of both surfaces, which may miss the largest distance by a little.
    #[default]
    Sampled,
    /// By proven bounds.
    Certified,
}

/// A distance between two surfaces: the larger of the two one-sided Hausdorff distances.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AchievedError {
    /// It is not smaller than this.
    pub lower: f64,
    /// It is proved not to be larger than this; `None` when it was only sampled.
    pub upper: Option<f64>,
}

impl AchievedError {
    /// Whether the distance is at most `limit`: by its proved upper bound, or by the sampled value if nothing was
    /// proved.
    #[must_use]
    pub fn is_within(&self, limit: f64) -> bool {
        self.upper.unwrap_or(self.lower) <= limit
    }
}

/// How distances are measured.
#[derive(Clone, Copy)]
pub(crate) struct Measuring<'a> {
    pub(crate) original: &'a Surface,
    pub(crate) check: ErrorCheck,
    /// The limit that the distance will be compared with, if there is one.
    pub(crate) limit: Option<f64>,
}

/// The number of pieces of triangles after which an undecided distance counts as above the limit.
const MAX_PIECES: usize = 4_000_000;

/// How many samples of each surface are compared.
const SAMPLES: usize = 200_000;

impl Measuring<'_> {
    /// The distance; `None` when the observer says to stop before it is known.
    pub(crate) fn measure(
        &self,
        mesh: &TriMesh,
        observer: &mut Observer<'_>,
    ) -> Result<Option<AchievedError>, SurfaceError> {
        if observer.stops(Phase::Measure, mesh) {
            return Ok(None);
        }
        let surface = Surface::new(mesh)?;
        if self.check == ErrorCheck::Certified {
            let size = self.original.bounding_box().diagonal();
            let limit = self.limit;
            let tolerance = limit.map_or(1e-4 * size, |limit| 0.001 * limit);
            // A distance so close to the limit that more pieces would be needed counts as above it.
            let certify = match limit {
                None => CertifyOptions { tolerance, ..CertifyOptions::default() },
                Some(_) => CertifyOptions {
                    tolerance,
                    limit,
                    max_pieces: MAX_PIECES,
                    ..CertifyOptions::default()
                },
            };
            let stops = &mut || observer.stops(Phase::Measure, mesh);
            let bounds = hausdorff_bounds_until(self.original, &surface, &certify, stops);
            let error = |bounds: CertifiedBounds| AchievedError {
                lower: bounds.lower,
                upper: Some(bounds.upper),
            };
            Ok(bounds.map(error))
        } else {
            let samples = CompareOptions { samples: SAMPLES, ..CompareOptions::default() };
            let lower = sampled_hausdorff(self.original, &surface, &samples);
            Ok(Some(AchievedError { lower, upper: None }))
        }
    }
}
