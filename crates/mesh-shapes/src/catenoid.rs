//! The catenoid, a minimal surface.

use crate::analytic::{AnalyticSurface, PrincipalCurvatures};
use crate::cylinder::{RowPhase, revolve};
use crate::error::{ShapeError, positive};
use crate::irregular::Irregular;
use glam::DVec3;
use mesh_core::PolygonSoup;

/// The catenoid around the z axis, between z = -`half_height` and z = `half_height`: the points
/// at distance c cosh(z/c) from the axis.
///
/// `point(u, v)` has angle u and height v. Normals point away from the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Catenoid {
    /// c, the radius at the narrowest place.
    pub waist: f64,
    /// Half the extent along z.
    pub half_height: f64,
}

impl Catenoid {
    /// Mesh of `rows` rows of `sectors` cells; vertex `row * sectors + sector`, rows upwards.
    ///
    /// # Errors
    /// A bad waist or height; no rows; fewer than three sectors.
    pub fn mesh(
        &self,
        rows: usize,
        sectors: usize,
        phase: RowPhase,
    ) -> Result<PolygonSoup, ShapeError> {
        self.revolved(rows, sectors, phase, None)
    }

    /// Irregular mesh with jittered parameters and random diagonals. The rims stay on their
    /// circles.
    ///
    /// # Errors
    /// As [`Catenoid::mesh`]; a jitter out of range.
    pub fn irregular_mesh(
        &self,
        rows: usize,
        sectors: usize,
        irregular: Irregular,
    ) -> Result<PolygonSoup, ShapeError> {
        self.revolved(rows, sectors, RowPhase::Aligned, Some(irregular))
    }

    fn revolved(
        &self,
        rows: usize,
        sectors: usize,
        phase: RowPhase,
        irregular: Option<Irregular>,
    ) -> Result<PolygonSoup, ShapeError> {
        positive("the waist of the catenoid", self.waist)?;
        positive("the half height of the catenoid", self.half_height)?;
        // Beyond this the rims would be infinitely wide.
        positive("the rim radius of the catenoid", self.waist * self.cosh(self.half_height))?;
        let point = |u, t: f64| self.point(u, self.half_height * (2.0 * t - 1.0));
        revolve(rows, sectors, phase, irregular, point)
    }

    fn cosh(&self, z: f64) -> f64 {
        (z / self.waist).cosh()
    }

    /// The larger principal curvature, 1 / (c cosh²(z/c)); the other is its negative.
    fn bend(&self, p: DVec3) -> f64 {
        1.0 / (self.waist * self.cosh(p.z).powi(2))
    }
}

impl AnalyticSurface for Catenoid {
    fn point(&self, u: f64, v: f64) -> DVec3 {
        let distance = self.waist * self.cosh(v);
        DVec3::new(distance * u.cos(), distance * u.sin(), v)
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        let away = DVec3::new(p.x, p.y, 0.0).normalize_or(DVec3::X);
        away / self.cosh(p.z) - (p.z / self.waist).tanh() * DVec3::Z
    }

    /// K = -1 / (c² cosh⁴(z/c)).
    fn gaussian_curvature(&self, p: DVec3) -> f64 {
        -self.bend(p).powi(2)
    }

    /// H = 0.
    fn mean_curvature(&self, _: DVec3) -> f64 {
        0.0
    }

    /// Convex around the axis, concave along the catenary.
    fn principal_curvatures(&self, p: DVec3) -> PrincipalCurvatures {
        let around = DVec3::Z.cross(DVec3::new(p.x, p.y, 0.0).normalize_or(DVec3::X));
        let along = self.normal(p).cross(around);
        let bend = self.bend(p);
        PrincipalCurvatures { max: bend, min: -bend, directions: Some([around, along]) }
    }
}
