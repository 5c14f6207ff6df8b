//! Covers of a mesh by patches within a tolerance.

mod candidates;
mod options;
mod selection;

use mesh_core::{FaceId, FaceMap, parallel};

use crate::curvature_estimator::CurvatureEstimator;
use crate::fit_test::FitTest;
use crate::patch_errors::PatchErrors;
use crate::patch_fit::PatchFit;
use crate::patch_sizer::StopReason;
use crate::size_options::{OptionError, SizeOptions};
pub use candidates::{CoverCandidates, CoverProgress};
pub use options::{CoverMethod, CoverOptions, Seeds};

/// A patch of a cover.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CoverPatch {
    /// The patch, with its point, curvature and shape.
    pub fit: PatchFit,
    /// The reason why it is not larger.
    pub stop: StopReason,
    /// Its errors.
    pub errors: PatchErrors,
    /// The covered faces: all their vertices are over or under the footprint and within tolerance.
    /// Patches overlap; several patches may cover a face.
    pub faces: Vec<FaceId>,
}

/// A mesh covered by patches.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Cover {
    /// The patches, in the order of their selection.
    pub patches: Vec<CoverPatch>,
    /// The faces that no patch covers. They remain triangles.
    pub residual: Vec<FaceId>,
    /// The index of the first patch that covers each face.
    pub patch_of_face: FaceMap<Option<u32>>,
    /// The tolerance, in model units.
    pub tolerance: f64,
    /// The selection method: [`CoverMethod::Greedy`] or [`CoverMethod::Sequential`].
    pub method: CoverMethod,
    /// Number of faces that were tried as base face.
    pub seeds: usize,
    /// Number of candidates found.
    pub candidates: usize,
    /// Whether the search for candidates was cancelled. Residual faces can then be untried.
    pub cancelled: bool,
}

impl Cover {
    /// Number of faces that at least one patch covers.
    #[must_use]
    pub fn covered_faces(&self) -> usize {
        self.patch_of_face.as_slice().iter().flatten().count()
    }

    /// The largest error of all patches; 0 without patches.
    #[must_use]
    pub fn max_error(&self) -> f64 {
        self.patches.iter().map(|patch| patch.errors.max()).fold(0.0, f64::max)
    }

    /// The largest distance that a patch sticks out beyond the boundary of the mesh; see [`PatchErrors::overhang`].
    #[must_use]
    pub fn overhang(&self) -> f64 {
        self.patches.iter().map(|patch| patch.errors.overhang).fold(0.0, f64::max)
    }
}

/// Covers the mesh of the estimator with patches: [`CoverCandidates::find`], then
/// [`CoverCandidates::choose`].
///
/// # Errors
/// An option out of its range.
pub fn cover(
    estimator: &CurvatureEstimator<'_>,
    options: &CoverOptions,
) -> Result<Cover, OptionError> {
    Ok(CoverCandidates::find(estimator, options)?.choose(options.method))
}

impl CoverCandidates<'_> {
    /// Selects patches until every face with a candidate is covered, then removes redundant patches.
    ///
    /// Residual faces have no admissible patch. The result does not depend on the number of threads.
    #[must_use]
    pub fn choose(&self, method: CoverMethod) -> Cover {
        let (method, chosen) = self.select(method);
        let mesh = self.mesh();
        let SizeOptions { tolerance, overhang, .. } = *self.size();
        let test = FitTest::new(mesh);
        let patches = parallel::collect_with(
            chosen.len(),
            || test.clone(),
            |test, i| {
                let candidate = self.get(chosen[i]);
                CoverPatch {
                    fit: candidate.fit,
                    stop: candidate.stop,
                    errors: test.full_error(&candidate.fit, tolerance, overhang),
                    faces: self.faces(chosen[i]).to_vec(),
                }
            },
        );
        let mut patch_of_face = mesh.topology().face_map(None);
        for (patch, index) in patches.iter().zip(0_u32..) {
            for &face in &patch.faces {
                patch_of_face[face].get_or_insert(index);
            }
        }
        let residual = mesh.topology().faces().filter(|&f| patch_of_face[f].is_none()).collect();
        Cover {
            patches,
            residual,
            patch_of_face,
            tolerance,
            method,
            seeds: self.seeds(),
            candidates: self.len(),
            cancelled: self.cancelled(),
        }
    }

    /// The method used, and the indices of the selected candidates.
    fn select(&self, method: CoverMethod) -> (CoverMethod, Vec<usize>) {
        let areas = || parallel::collect(self.face_capacity(), |index| self.face_area(index));
        let greedy = || (CoverMethod::Greedy, selection::greedy(self, &areas()));
        let sequential = || (CoverMethod::Sequential, selection::sequential(self));
        match method {
            CoverMethod::Greedy => greedy(),
            CoverMethod::Sequential => sequential(),
            CoverMethod::Best => {
                let (greedy, sequential) = parallel::both(greedy, sequential);
                if sequential.1.len() < greedy.1.len() { sequential } else { greedy }
            }
        }
    }
}
