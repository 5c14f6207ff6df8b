//! Why there is no curvature at a point.

use mesh_core::FaceId;

/// Why there is no curvature at a point.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurvatureError {
    /// Fewer than three normal planes were asked for.
    #[error("{planes} normal planes determine no curvature tensor; use at least 3")]
    TooFewPlanes {
        /// How many were asked for.
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
    /// Barycentric coordinates that describe no point inside the face.
    #[error("barycentric coordinates {barycentric:?} of face {face} must be positive and finite")]
    BadPoint {
        /// The face.
        face: FaceId,
        /// The coordinates.
        barycentric: [f64; 3],
    },
    /// The face has no area, and so no normal.
    #[error("face {face} has no area and so no normal; collapse or flip one of its edges")]
    DegenerateFace {
        /// The face.
        face: FaceId,
    },
    /// The mesh ends in all but one or two directions.
    #[error(
        "the disc of face {face} has both arcs in fewer than 3 normal planes; the face is cut off from its neighbours"
    )]
    TooFewDirections {
        /// The face.
        face: FaceId,
    },
    /// A curvature that double precision does not hold.
    #[error("lengths at face {face} overflow double precision; scale the mesh")]
    Overflow {
        /// The face.
        face: FaceId,
    },
}

/// Refuses a radius that no disc has.
pub(crate) fn check_radius(radius: f64) -> Result<(), CurvatureError> {
    if radius > 0.0 && radius.is_finite() {
        return Ok(());
    }
    Err(CurvatureError::BadRadius { radius })
}
