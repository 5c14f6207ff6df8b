//! Errors of the curvature estimation at a point.

use mesh_core::FaceId;

/// The reason why the curvature at a point is undefined.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurvatureError {
    /// Fewer than three normal planes were requested.
    #[error("{planes} normal planes determine no curvature tensor; use at least 3")]
    TooFewPlanes {
        /// Number of requested planes.
        planes: u16,
    },
    /// The radius of the disc is zero, negative or not finite.
    #[error("the radius of a disc is {radius}, but it must be positive and finite")]
    BadRadius {
        /// The radius.
        radius: f64,
    },
    /// The face is not in the mesh.
    #[error("face {face} is not in the mesh")]
    NotInMesh {
        /// The face.
        face: FaceId,
    },
    /// The barycentric coordinates do not belong to an interior point of the face.
    #[error("barycentric coordinates {barycentric:?} of face {face} must be positive and finite")]
    BadPoint {
        /// The face.
        face: FaceId,
        /// The coordinates.
        barycentric: [f64; 3],
    },
    /// The face has no area and therefore no normal.
    #[error("face {face} has no area and therefore no normal; collapse or flip one of its edges")]
    DegenerateFace {
        /// The face.
        face: FaceId,
    },
    /// Fewer than three normal planes have both arcs.
    #[error(
        "the disc of face {face} has both arcs in fewer than 3 normal planes; the face is cut off from its neighbours"
    )]
    TooFewDirections {
        /// The face.
        face: FaceId,
    },
    /// The curvature overflows double precision.
    #[error("lengths at face {face} overflow double precision; scale the mesh")]
    Overflow {
        /// The face.
        face: FaceId,
    },
}

/// Checks that a radius is positive and finite.
pub(crate) fn check_radius(radius: f64) -> Result<(), CurvatureError> {
    if radius > 0.0 && radius.is_finite() {
        return Ok(());
    }
    Err(CurvatureError::BadRadius { radius })
}
