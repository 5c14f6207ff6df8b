//! The patch at a point of the mesh: curvature, shape and translation (SN10, section 2).

use crate::curvature_error::CurvatureError;
use crate::curvature_estimator::CurvatureEstimator;
use crate::disc_curvature::DiscCurvature;
use crate::params::TranslationRule;
use crate::patch::{Patch, PatchError};
use crate::shape::Shape;
use crate::surface_point::SurfacePoint;

/// A patch with the data that it was made from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PatchFit {
    /// The point on the mesh.
    pub point: SurfacePoint,
    /// The curvature of the disc.
    pub curvature: DiscCurvature,
    /// The requested shape.
    pub shape: Shape,
    /// The patch.
    pub patch: Patch,
    /// The translation was requested but omitted, because a vertex of the base face is too far outside
    /// the patch.
    pub translation_skipped: bool,
}

/// The reason why there is no patch at a point.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// The curvature is undefined.
    #[error(transparent)]
    Curvature(#[from] CurvatureError),
    /// The radius is too large for the curvature.
    #[error(transparent)]
    Patch(#[from] PatchError),
}

/// The largest parameter u of the vertices of the base face for which the translation is computed.
const MAX_VERTEX_U: f64 = 1.5;

impl CurvatureEstimator<'_> {
    /// The patch of this shape and radius at a point, or at the barycentre of a face.
    ///
    /// # Errors
    /// The errors of [`CurvatureEstimator::at`], and [`PatchError::RadiusTooLarge`] if an arc turns by a
    /// quarter circle or more.
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

    /// The patch of this shape for a curvature that was already estimated at `point`.
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

    /// The mean height of the vertices of the base face over the untranslated patch. `None` if a vertex
    /// is too far outside.
    ///
    /// SN10 uses the Euclidean distance, which differs by less than 0.01 % of the radius.
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
