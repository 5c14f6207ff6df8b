//! The torus.

use crate::analytic::{AnalyticSurface, PrincipalCurvatures, SignedDistance};
use crate::error::{ShapeError, at_least, fits, positive};
use crate::irregular::Irregular;
use crate::lattice::{Axis, Diagonal, Lattice};
use core::f64::consts::TAU;
use glam::{DVec2, DVec3};
use mesh_core::{PolygonSoup, as_u32};

/// The torus around the z axis.
///
/// `point(u, v)` = ((R + r cos v) cos u, (R + r cos v) sin u, r sin v).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torus {
    /// R, the distance of the tube's centre line from the axis.
    pub major: f64,
    /// r, the radius of the tube; less than `major`.
    pub minor: f64,
}

impl Torus {
    /// Regular mesh of `rings` x `sides` vertices. Vertex `i * sides + j` has parameters
    /// 2π (i / rings, j / sides); all cells are cut the same way, so every vertex has valence six.
    ///
    /// # Errors
    /// Radii that describe no torus; fewer than three `rings` or `sides`.
    pub fn mesh(&self, rings: usize, sides: usize) -> Result<PolygonSoup, ShapeError> {
        self.lattice_mesh(rings, sides, None)
    }

    /// Irregular mesh with jittered parameters and random diagonals.
    ///
    /// # Errors
    /// As [`Torus::mesh`]; a jitter out of range.
    pub fn irregular_mesh(
        &self,
        rings: usize,
        sides: usize,
        irregular: Irregular,
    ) -> Result<PolygonSoup, ShapeError> {
        self.lattice_mesh(rings, sides, Some(irregular))
    }

    /// The mesh of Dyn, Hormann, Kim and Levin 2001, Fig. 5: as [`Torus::mesh`], but every other ring is turned by half
    /// a step in v, and the triangles still join equal j. Table 1 of the paper uses `rings` = 12 and `sides` = 6 on
    /// radii 5 and 2.
    ///
    /// With an odd number of `rings`, both the last and the first are not turned.
    ///
    /// # Errors
    /// As [`Torus::mesh`].
    pub fn shifted_mesh(&self, rings: usize, sides: usize) -> Result<PolygonSoup, ShapeError> {
        let triangles = self.check(rings, sides)?;
        let mut soup = PolygonSoup::with_capacity(triangles / 2, triangles, 3 * triangles);
        for i in 0..rings {
            let turn = if i % 2 == 0 { 0.0 } else { 0.5 };
            for j in 0..sides {
                let u = TAU * i as f64 / rings as f64;
                let v = TAU * (j as f64 + turn) / sides as f64;
                soup.push_vertex(self.point(u, v));
            }
        }
        let vertex = |i: usize, j: usize| as_u32((i % rings) * sides + j % sides);
        for i in 0..rings {
            for j in 0..sides {
                soup.push_face(&[vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)])?;
                soup.push_face(&[vertex(i, j + 1), vertex(i + 1, j), vertex(i + 1, j + 1)])?;
            }
        }
        Ok(soup)
    }

    fn lattice_mesh(
        &self,
        rings: usize,
        sides: usize,
        irregular: Option<Irregular>,
    ) -> Result<PolygonSoup, ShapeError> {
        self.check(rings, sides)?;
        let lattice = Lattice {
            rows: Axis { cells: rings, closed: true },
            columns: Axis { cells: sides, closed: true },
            transposed: true,
        };
        let point = |_, i, j| self.point(TAU * i / rings as f64, TAU * j / sides as f64);
        lattice.mesh(irregular, point, |_, _| Diagonal::AC)
    }

    /// The number of triangles, if radii and counts are valid.
    fn check(&self, rings: usize, sides: usize) -> Result<usize, ShapeError> {
        positive("the major radius of the torus", self.major)?;
        positive("the minor radius of the torus", self.minor)?;
        if self.minor >= self.major {
            return Err(ShapeError::TubeTooThick { major: self.major, minor: self.minor });
        }
        at_least("rings of a torus", rings, 3)?;
        at_least("sides of a torus", sides, 3)?;
        fits(rings.checked_mul(sides).and_then(|cells| cells.checked_mul(2)))
    }

    /// The direction away from the axis, and the offset from the tube's centre line: outward in
    /// the plane through the axis, and along it.
    fn section(&self, p: DVec3) -> (DVec3, DVec2) {
        let away = DVec3::new(p.x, p.y, 0.0).normalize_or(DVec3::X);
        (away, DVec2::new(p.x.hypot(p.y) - self.major, p.z))
    }

    /// The cosine of the parameter v and the distance of the surface point from the axis.
    fn latitude(&self, p: DVec3) -> (f64, f64) {
        let cos = self.section(p).1.normalize_or(DVec2::X).x;
        (cos, self.major + self.minor * cos)
    }
}

impl AnalyticSurface for Torus {
    fn point(&self, u: f64, v: f64) -> DVec3 {
        let distance = self.major + self.minor * v.cos();
        DVec3::new(u.cos() * distance, u.sin() * distance, self.minor * v.sin())
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        let (away, offset) = self.section(p);
        let offset = offset.normalize_or(DVec2::X);
        offset.x * away + offset.y * DVec3::Z
    }

    /// K = cos v / (r (R + r cos v)).
    fn gaussian_curvature(&self, p: DVec3) -> f64 {
        let (cos, distance) = self.latitude(p);
        cos / (self.minor * distance)
    }

    /// H = (R + 2 r cos v) / (2 r (R + r cos v)).
    fn mean_curvature(&self, p: DVec3) -> f64 {
        let (cos, distance) = self.latitude(p);
        (self.major + 2.0 * self.minor * cos) / (2.0 * self.minor * distance)
    }

    /// κ₁ = 1 / r around the tube, κ₂ = cos v / (R + r cos v) along it.
    fn principal_curvatures(&self, p: DVec3) -> PrincipalCurvatures {
        let (cos, distance) = self.latitude(p);
        let along = DVec3::Z.cross(self.section(p).0);
        let around = along.cross(self.normal(p));
        PrincipalCurvatures {
            max: 1.0 / self.minor,
            min: cos / distance,
            directions: Some([around, along]),
        }
    }
}

impl SignedDistance for Torus {
    fn signed_distance(&self, p: DVec3) -> f64 {
        self.section(p).1.length() - self.minor
    }

    fn closest_point(&self, p: DVec3) -> DVec3 {
        let (away, _) = self.section(p);
        self.major * away + self.minor * self.normal(p)
    }
}
