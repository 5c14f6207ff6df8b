//! Result of the curvature estimation at a point.

use glam::DVec3;

/// The type of a surface point, by its principal curvatures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum PointClass {
    /// |κ| `r_g` < 10⁻³ for both principal curvatures: the disc is planar.
    Flat,
    /// κ₁ - κ₂ < 0.05 max(|κ₁|, |κ₂|): the principal directions are undefined.
    Umbilic,
    /// min(|κ₁|, |κ₂|) < 0.05 max(|κ₁|, |κ₂|): the surface is curved in one direction only.
    Parabolic,
    /// κ₁ κ₂ > 0.
    Elliptic,
    /// κ₁ κ₂ < 0.
    Hyperbolic,
}

/// Principal curvatures of the mesh over a disc around a point.
///
/// Curvatures are pointwise, in 1 / length, and positive where the surface is convex seen from the side
/// of the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DiscCurvature {
    /// The centre of the disc.
    pub center: DVec3,
    /// The orthonormal, right-handed frame e₁, e₂, e₃: the directions of κ₁ and κ₂, and the normal.
    ///
    /// The tangents are defined up to a common sign. At umbilics they are arbitrary.
    pub frame: [DVec3; 3],
    /// The principal curvatures κ₁ ≥ κ₂.
    ///
    /// SN10 calls the curvature with the larger absolute value κ₁.
    pub curvatures: [f64; 2],
    /// The radius `r_g` of the disc: the arc length of each half-section.
    ///
    /// For [`DiscSize::Local`](crate::DiscSize::Local), the root mean square length of the half-sections.
    pub radius: f64,
    /// At least one arc ends at the boundary of the mesh.
    pub truncated: bool,
    /// At least one section returns to its first face before its full length: the disc is too large for
    /// this component of the mesh.
    pub wrapped: bool,
    /// The face normal is used, because the slopes of the sections do not determine a disc normal.
    pub face_normal_kept: bool,
}

impl DiscCurvature {
    /// The normal.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.frame[2]
    }

    /// Gaussian curvature K = κ₁ κ₂, in 1 / length².
    #[must_use]
    pub fn gaussian(&self) -> f64 {
        self.curvatures[0] * self.curvatures[1]
    }

    /// Mean curvature H = (κ₁ + κ₂) / 2, in 1 / length.
    #[must_use]
    pub fn mean(&self) -> f64 {
        0.5 * (self.curvatures[0] + self.curvatures[1])
    }

    /// The type of the point: the first class of [`PointClass`] whose condition holds. It does not depend
    /// on the unit of length.
    #[must_use]
    pub fn class(&self) -> PointClass {
        let [k1, k2] = self.curvatures;
        let (large, small) = (k1.abs().max(k2.abs()), k1.abs().min(k2.abs()));
        if large * self.radius < 1e-3 {
            PointClass::Flat
        } else if k1 - k2 < 0.05 * large {
            PointClass::Umbilic
        } else if small < 0.05 * large {
            PointClass::Parabolic
        } else if self.gaussian() > 0.0 {
            PointClass::Elliptic
        } else {
            PointClass::Hyperbolic
        }
    }
}
