//! From a point of the mesh to its patch: curvature, outline, translation.

use crate::curvature::{CurvatureEstimator, DiscCurvature};
use crate::curvature_error::CurvatureError;
use crate::params::TranslationRule;
use crate::patch::{Patch, PatchError};
use crate::shape::Shape;
use crate::surface_point::SurfacePoint;

/// A patch with what it was made from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PatchFit {
    /// The point that the patch was made for.
    pub point: SurfacePoint,
    /// The curvature of the disc.
    pub curvature: DiscCurvature,
    /// The outline that was asked for.
    pub shape: Shape,
    /// The patch.
    pub patch: Patch,
    /// The translation was asked for but left out, because a vertex of the base face lies too far
    /// outside the patch to say anything about it.
    pub translation_skipped: bool,
}

/// Why there is no patch at a point.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// No curvature.
    #[error(transparent)]
    Curvature(#[from] CurvatureError),
    /// The curvature is too large for the radius.
    #[error(transparent)]
    Patch(#[from] PatchError),
}

/// How far outside the patch, in u, the vertices of the base face may lie for the translation.
const MAX_VERTEX_U: f64 = 1.5;

impl CurvatureEstimator<'_> {
    /// The patch of this shape and radius at a point, or at the barycentre of a face.
    ///
    /// # Errors
    /// As [`CurvatureEstimator::at`], and when an arc turns by a quarter circle or more.
    pub fn patch(
        &self,
        point: impl Into<SurfacePoint>,
        radius: f64,
        shape: Shape,
    ) -> Result<PatchFit, FitError> {
        let point = point.into();
        let curvature = self.at(point, radius)?;
        Ok(self.patch_of(point, curvature, shape)?)
    }

    /// The patch of this shape for a curvature that was estimated at `point` before.
    pub(crate) fn patch_of(
        &self,
        point: SurfacePoint,
        curvature: DiscCurvature,
        shape: Shape,
    ) -> Result<PatchFit, PatchError> {
        let patch = Patch::from_curvature(&curvature, shape)?;
        let wanted = match self.params().translation {
            TranslationRule::Always => true,
            TranslationRule::Elliptic => curvature.gaussian() > 0.0,
        };
        let translation = if wanted { self.translation(point, &patch) } else { Some(0.0) };
        Ok(PatchFit {
            point,
            curvature,
            shape,
            patch: patch.translated(translation.unwrap_or(0.0)),
            translation_skipped: translation.is_none(),
        })
    }

    /// The mean height of the base face's vertices over the untranslated patch. `None` when one
    /// is too far outside.
    ///
    /// The Euclidean distance, of which SN10 speaks, differs by less than 0.01 % of the radius.
    fn translation(&self, point: SurfacePoint, patch: &Patch) -> Option<f64> {
        let mut sum = 0.0;
        for vertex in self.mesh().triangle(point.face()) {
            let local = patch.to_local(vertex);
            let [u, _] = patch.parameters(local.x, local.y)?;
            if u > MAX_VERTEX_U {
                return None;
            }
            sum += local.z - patch.height(local.x, local.y)?;
        }
        Some(sum / 3.0)
    }
}
