//! The ellipsoid: the sphere's meshes, stretched along the axes.

use crate::analytic::{AnalyticSurface, PrincipalCurvatures};
use crate::error::{ShapeError, positive};
use crate::irregular::Irregular;
use crate::sphere::Sphere;
use glam::{DMat3, DVec3};
use mesh_core::PolygonSoup;

/// The ellipsoid (x/a)² + (y/b)² + (z/c)² = 1.
///
/// `point(u, v)` is the unit sphere's point with longitude u and latitude v, stretched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// The semi-axes a, b, c along x, y, z.
    pub semi_axes: DVec3,
}

impl Ellipsoid {
    /// [`Sphere::uv_mesh`], stretched.
    ///
    /// # Errors
    /// Bad semi-axes; as [`Sphere::uv_mesh`].
    pub fn uv_mesh(&self, bands: usize, sectors: usize) -> Result<PolygonSoup, ShapeError> {
        self.stretched(|sphere| sphere.uv_mesh(bands, sectors))
    }

    /// [`Sphere::icosphere`], stretched.
    ///
    /// # Errors
    /// Bad semi-axes; as [`Sphere::icosphere`].
    pub fn icosphere(&self, level: u32) -> Result<PolygonSoup, ShapeError> {
        self.stretched(|sphere| sphere.icosphere(level))
    }

    /// [`Sphere::irregular_icosphere`], stretched.
    ///
    /// # Errors
    /// Bad semi-axes; as [`Sphere::irregular_icosphere`].
    pub fn irregular_icosphere(
        &self,
        level: u32,
        irregular: Irregular,
    ) -> Result<PolygonSoup, ShapeError> {
        self.stretched(|sphere| sphere.irregular_icosphere(level, irregular))
    }

    /// [`Sphere::random_hull`], stretched, which keeps it convex up to rounding.
    ///
    /// # Errors
    /// Bad semi-axes; as [`Sphere::random_hull`].
    pub fn random_hull(&self, points: usize, seed: u64) -> Result<PolygonSoup, ShapeError> {
        self.stretched(|sphere| sphere.random_hull(points, seed))
    }

    fn stretched(
        &self,
        mesh: impl FnOnce(Sphere) -> Result<PolygonSoup, ShapeError>,
    ) -> Result<PolygonSoup, ShapeError> {
        for axis in self.semi_axes.to_array() {
            positive("a semi-axis of the ellipsoid", axis)?;
        }
        let mut soup = mesh(Sphere::UNIT)?;
        for point in soup.positions_mut() {
            *point *= self.semi_axes;
        }
        Ok(soup)
    }

    /// Half the gradient of (x/a)² + (y/b)² + (z/c)².
    fn half_gradient(&self, p: DVec3) -> DVec3 {
        p / (self.semi_axes * self.semi_axes)
    }
}

impl AnalyticSurface for Ellipsoid {
    fn point(&self, u: f64, v: f64) -> DVec3 {
        self.semi_axes * Sphere::UNIT.point(u, v)
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        self.half_gradient(p).normalize_or(DVec3::Z)
    }

    /// K = 1 / (a b c w)² with w = x²/a⁴ + y²/b⁴ + z²/c⁴.
    fn gaussian_curvature(&self, p: DVec3) -> f64 {
        let w = self.half_gradient(p).length_squared();
        (self.semi_axes.element_product() * w).powi(-2)
    }

    /// H = (a² + b² + c² - |p|²) / (2 (a b c)² w^(3/2)) with w as for K.
    fn mean_curvature(&self, p: DVec3) -> f64 {
        let root = self.half_gradient(p).length();
        let axes = self.semi_axes;
        (axes.length_squared() - p.length_squared())
            / (2.0 * axes.element_product().powi(2) * root.powi(3))
    }

    fn principal_curvatures(&self, p: DVec3) -> PrincipalCurvatures {
        let axes = self.semi_axes;
        let hessian = (axes * axes * self.half_gradient(p).length()).recip();
        PrincipalCurvatures::of_level_set(self.normal(p), DMat3::from_diagonal(hessian))
    }
}
