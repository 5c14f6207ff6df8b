//! Size of the disc over which a curvature is estimated.

use crate::curvature_error::CurvatureError;

/// Size of the disc around a point: the length of its half-sections.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum DiscSize {
    /// The same length `r_g` in all directions, in model units, as in SN10.
    Radius(f64),
    /// Four local edge lengths, measured separately in each direction, and at least two lengths of the edges along the
    /// curvature.
    ///
    /// Let M be the mean of e eᵀ over the edges e of the face and its three neighbours, in the tangent
    /// plane. The half-length in the direction t is 4 √(2 / (tᵀ M⁻¹ t)). A first estimate of the curvature gives
    /// the least half-length: 2 √(2 dᵀ M d |κ| / max |κ|), the larger one of both principal directions d. Without it,
    /// sections across long triangles around a tube would stay in one facet. A half-section ends earlier where it turns
    /// by more than 75° (creases not counted), after 128 faces, and at a quarter of its length if it closes on itself.
    /// Cylinders, spheres and tori are recovered with triangles of any aspect ratio up
    /// to 300. The time per face is bounded.
    ///
    /// With the rules of [`Params::robust`](crate::Params::robust), one quadric is fitted to points of all sections.
    /// Sections that end at the boundary on one side count as well, so the error of a cylinder at its boundary is
    /// below 2 % if its triangles turn by less than 23°.
    #[default]
    Local,
}

impl From<f64> for DiscSize {
    fn from(radius: f64) -> Self {
        Self::Radius(radius)
    }
}

impl DiscSize {
    /// Checks that a radius is positive and finite.
    pub(crate) fn check(self) -> Result<(), CurvatureError> {
        match self {
            Self::Radius(radius) => crate::curvature_error::check_radius(radius),
            Self::Local => Ok(()),
        }
    }
}
