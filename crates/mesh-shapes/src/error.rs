//! Errors in the parameters of a shape.

use mesh_core::soup::TooManyCorners;

/// The parameters do not describe a shape.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A length is zero, negative, infinite or not a number.
    #[error("{what} is {value}, but it must be positive and finite")]
    NotPositive {
        /// The name of the parameter.
        what: &'static str,
        /// The value it had.
        value: f64,
    },
    /// A value lies outside its range (or is not a number).
    #[error("{what} is {value}, but it must be at least {least} and {upper} {limit}")]
    OutOfRange {
        /// The name of the parameter.
        what: &'static str,
        /// The value it had.
        value: f64,
        /// The least allowed value.
        least: f64,
        /// `"below"` or `"at most"`, as it applies to `limit`.
        upper: &'static str,
        /// The upper end of the range.
        limit: f64,
    },
    /// The tube of a torus is so thick that the surface meets itself.
    #[error(
        "the minor radius {minor} of the torus is not below its major radius {major}; the surface would meet itself"
    )]
    TubeTooThick {
        /// Distance of the tube's centre line from the axis.
        major: f64,
        /// Radius of the tube.
        minor: f64,
    },
    /// Too few vertices, segments or cells to enclose anything.
    #[error("{got} {what} are too few; at least {least} are needed")]
    TooFew {
        /// The kind of the elements.
        what: &'static str,
        /// The number asked for.
        got: usize,
        /// The least number that works.
        least: usize,
    },
    /// The mesh would not fit 32-bit indices.
    #[error(transparent)]
    TooLarge(#[from] TooManyCorners),
    /// A random point is not a corner of the hull of all points, because of rounding or because
    /// it was drawn twice.
    #[error(
        "random point {vertex} is not a corner of the convex hull in double precision; use another seed or fewer points"
    )]
    NotOnHull {
        /// Index of the point.
        vertex: u32,
    },
    /// The points have no hull with a volume.
    #[error(transparent)]
    Hull(#[from] crate::hull::HullError),
}

/// Refuses a length that is not positive and finite.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<(), ShapeError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(ShapeError::NotPositive { what, value })
}

/// Refuses a count below `least`.
pub(crate) fn at_least(what: &'static str, got: usize, least: usize) -> Result<(), ShapeError> {
    if got >= least {
        return Ok(());
    }
    Err(ShapeError::TooFew { what, got, least })
}

/// Refuses a number of triangles (`None`: it overflowed) whose corners exceed 32-bit indices, before memory is
/// allocated.
pub(crate) fn fits(triangles: Option<usize>) -> Result<usize, ShapeError> {
    const MOST: usize = (u32::MAX as usize - 2) / 3;
    triangles.filter(|&count| count <= MOST).ok_or(ShapeError::TooLarge(TooManyCorners))
}
