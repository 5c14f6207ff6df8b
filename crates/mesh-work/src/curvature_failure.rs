//! Why a mesh has no curvatures.

use curvpatch::CurvatureError;
use dcurv::InvalidRadius;
use mesh_core::ScaleError;

/// Why the curvatures of a mesh are not computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurvatureFailure {
    /// Areas or curvatures of a mesh of this size are not numbers.
    #[error(transparent)]
    Scale(#[from] ScaleError),
    /// The radius of balls is out of its range.
    #[error(transparent)]
    Radius(#[from] InvalidRadius),
    /// A parameter of sections or the radius of discs is out of its range.
    #[error(transparent)]
    Sections(#[from] CurvatureError),
}
