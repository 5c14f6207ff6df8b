//! Covering a mesh with patches that keep a tolerance.

mod candidates;
mod options;
mod selection;

use mesh_core::{FaceId, FaceMap, parallel};

use crate::curvature::CurvatureEstimator;
use crate::fit::PatchFit;
use crate::probe::{PatchErrors, PatchProbe};
use crate::size::{OptionError, SizeOptions, StopReason};
pub use candidates::{CoverCandidates, CoverProgress};
pub use options::{CoverMethod, CoverOptions, Seeds};

/// A patch of a cover.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CoverPatch {
    /// The patch, with its point, curvature and shape.
    pub fit: PatchFit,
    /// Why it is not larger.
    pub stop: StopReason,
    /// How far it is from the mesh.
    pub errors: PatchErrors,
    /// The faces it covers: all their vertices lie in its footprint and within tolerance of it.
    /// Patches overlap, so a face may be covered more than once.
    pub faces: Vec<FaceId>,
}

/// A mesh covered by patches, as far as the tolerance allows.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Cover {
    /// The patches in the order in which they were chosen.
    pub patches: Vec<CoverPatch>,
    /// The faces that no patch covers; they stay triangles.
    pub residual: Vec<FaceId>,
    /// The first patch that covers each face.
    pub patch_of_face: FaceMap<Option<u32>>,
    /// The tolerance, in model units.
    pub tolerance: f64,
    /// How the patches were chosen; [`CoverMethod::Greedy`] or [`CoverMethod::Sequential`].
    pub method: CoverMethod,
    /// For how many faces a candidate was looked for.
    pub seeds: usize,
    /// How many of them had one.
    pub candidates: usize,
    /// Whether the search for candidates was broken off: residual faces may then have patches that
    /// were not looked for.
    pub cancelled: bool,
}

impl Cover {
    /// The number of faces that some patch covers.
    #[must_use]
    pub fn covered_faces(&self) -> usize {
        self.patch_of_face.as_slice().iter().flatten().count()
    }

    /// The largest error of any patch; 0 without patches.
    #[must_use]
    pub fn max_error(&self) -> f64 {
        self.patches.iter().map(|patch| patch.errors.max()).fold(0.0, f64::max)
    }
}

/// Covers the estimator's mesh with patches: [`CoverCandidates::find`] and
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
    /// Takes patches until every face with a candidate is covered, and then drops those whose faces
    /// others cover too. What is left are faces without any admissible patch. The result does not
    /// depend on the number of threads.
    #[must_use]
    pub fn choose(&self, method: CoverMethod) -> Cover {
        let (method, chosen) = self.chosen(method);
        let mesh = self.mesh();
        let SizeOptions { tolerance, overhang, .. } = *self.size();
        let probe = PatchProbe::new(mesh);
        let patches = parallel::collect_with(
            chosen.len(),
            || probe.clone(),
            |probe, i| {
                let candidate = self.get(chosen[i]);
                CoverPatch {
                    fit: candidate.fit,
                    stop: candidate.stop,
                    errors: probe.full_error(&candidate.fit, tolerance, overhang),
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

    /// The method that was used in the end, and the candidates that it chose.
    fn chosen(&self, method: CoverMethod) -> (CoverMethod, Vec<usize>) {
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
