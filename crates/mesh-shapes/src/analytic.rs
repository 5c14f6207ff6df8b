//! The interface of analytic surfaces.

use glam::{DMat3, DVec3};

/// A smooth surface with known curvature.
///
/// The arguments `p` are points of the surface. Rounding errors in them are harmless; the result
/// for points away from the surface is not specified.
pub trait AnalyticSurface: Send + Sync {
    /// The point with parameters `u` and `v`. The turn from the direction of growing `u` to the direction of growing
    /// `v` is counter-clockwise seen from the side of the normal.
    fn point(&self, u: f64, v: f64) -> DVec3;

    /// The unit normal, outward on closed surfaces.
    fn normal(&self, p: DVec3) -> DVec3;

    /// The Gaussian curvature K = κ₁κ₂.
    fn gaussian_curvature(&self, p: DVec3) -> f64;

    /// The mean curvature H = (κ₁ + κ₂) / 2.
    fn mean_curvature(&self, p: DVec3) -> f64;

    /// Both principal curvatures and their directions.
    fn principal_curvatures(&self, p: DVec3) -> PrincipalCurvatures;
}

/// A surface with known distance from any point of space.
pub trait SignedDistance {
    /// Euclidean distance to the surface: positive on the side of the normal, negative behind.
    fn signed_distance(&self, p: DVec3) -> f64;

    /// The nearest point of the surface; one of them if there are several.
    fn closest_point(&self, p: DVec3) -> DVec3;
}

/// The principal curvatures κ₁ ≥ κ₂ at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalCurvatures {
    /// κ₁, the larger one (as a signed number).
    pub max: f64,
    /// κ₂, the smaller one.
    pub min: f64,
    /// Unit tangents of κ₁ and κ₂, each up to sign; none where κ₁ = κ₂ and every direction is
    /// principal.
    pub directions: Option<[DVec3; 2]>,
}

impl PrincipalCurvatures {
    /// A point whose normal curvature is the same in all directions.
    pub(crate) fn umbilic(curvature: f64) -> Self {
        Self { max: curvature, min: curvature, directions: None }
    }

    /// Principal curvatures of a level set f = 0 with unit normal ∇f/|∇f|.
    ///
    /// The derivative of the unit normal along a tangent t is the tangential part of
    /// (D²f / |∇f|) t, so the principal curvatures are the eigenvalues of `tensor` = D²f / |∇f|
    /// restricted to the tangent plane, positive where the surface is convex.
    pub(crate) fn of_level_set(normal: DVec3, tensor: DMat3) -> Self {
        let e = normal.any_orthonormal_vector();
        let f = normal.cross(e);
        let (ee, ef, ff) = (e.dot(tensor * e), e.dot(tensor * f), f.dot(tensor * f));
        let mean = 0.5 * (ee + ff);
        let half_difference = 0.5 * (ee - ff);
        let radius = half_difference.hypot(ef);
        if radius <= 1e-12 * (ee.abs() + ff.abs()) {
            return Self::umbilic(mean);
        }
        let (sin, cos) = (0.5 * ef.atan2(half_difference)).sin_cos();
        let directions = Some([cos * e + sin * f, cos * f - sin * e]);
        Self { max: mean + radius, min: mean - radius, directions }
    }
}
