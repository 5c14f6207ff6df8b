//! The open circular cylinder.

use crate::analytic::{AnalyticSurface, PrincipalCurvatures, SignedDistance};
use crate::error::{ShapeError, at_least, fits, positive};
use crate::irregular::Irregular;
use crate::lattice::{Axis, Diagonal, Lattice};
use core::f64::consts::{PI, TAU};
use glam::DVec3;
use mesh_core::PolygonSoup;

/// The cylinder around the z axis from z = 0 to z = height, without its end disks.
///
/// `point(u, v)` = (r cos u, r sin u, v). Normals point away from the axis. Distances are measured to the infinite
/// cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// The radius r.
    pub radius: f64,
    /// The height.
    pub height: f64,
}

/// The relative rotation of the rows of vertices of a surface of revolution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RowPhase {
    /// Vertices above each other; all cells are cut in the same way.
    #[default]
    Aligned,
    /// Every other row turned by half a step, which makes the triangles isosceles.
    Staggered,
}

impl RowPhase {
    /// Turn of a row, in steps.
    fn turn(self, row: usize) -> f64 {
        if self == Self::Staggered && !row.is_multiple_of(2) { 0.5 } else { 0.0 }
    }

    fn diagonal(self, row: usize) -> Diagonal {
        if self == Self::Staggered && row.is_multiple_of(2) { Diagonal::BD } else { Diagonal::AC }
    }
}

/// Mesh of an open surface of revolution: `point(angle, share of the height)`.
pub(crate) fn revolve(
    rows: usize,
    sectors: usize,
    phase: RowPhase,
    irregular: Option<Irregular>,
    point: impl Fn(f64, f64) -> DVec3,
) -> Result<PolygonSoup, ShapeError> {
    at_least("rows of cells", rows, 1)?;
    at_least("sectors", sectors, 3)?;
    let lattice = Lattice {
        rows: Axis { cells: rows, closed: false },
        columns: Axis { cells: sectors, closed: true },
        transposed: false,
    };
    let at = |row, r, c| point(TAU * (c + phase.turn(row)) / sectors as f64, r / rows as f64);
    lattice.mesh(irregular, at, |row, _| phase.diagonal(row))
}

impl Cylinder {
    /// Mesh of `rows` rows of `sectors` cells; vertex `row * sectors + sector`, rows upwards.
    ///
    /// # Errors
    /// A bad radius or height; no rows; fewer than three sectors.
    pub fn mesh(
        &self,
        rows: usize,
        sectors: usize,
        phase: RowPhase,
    ) -> Result<PolygonSoup, ShapeError> {
        self.check()?;
        revolve(rows, sectors, phase, None, |u, t| self.point(u, self.height * t))
    }

    /// Irregular mesh with jittered parameters and random diagonals. The rims stay on their
    /// circles.
    ///
    /// # Errors
    /// As [`Cylinder::mesh`]; a jitter out of range.
    pub fn irregular_mesh(
        &self,
        rows: usize,
        sectors: usize,
        irregular: Irregular,
    ) -> Result<PolygonSoup, ShapeError> {
        self.check()?;
        let point = |u, t| self.point(u, self.height * t);
        revolve(rows, sectors, RowPhase::Aligned, Some(irregular), point)
    }

    /// The half y ≥ 0 with vertices on the two rims only, so that every triangle has the length of the cylinder
    /// (Szilvási-Nagy 2010, Fig. 7): `segments` + 1 vertices at z = 0 with angles from 0 to π, then the same number
    /// above them.
    /// # Errors
    /// A bad radius or height; no segments.
    pub fn half_with_bare_sides(&self, segments: usize) -> Result<PolygonSoup, ShapeError> {
        self.check()?;
        at_least("segments of a half cylinder", segments, 1)?;
        fits(segments.checked_mul(2))?;
        let lattice = Lattice {
            rows: Axis { cells: 1, closed: false },
            columns: Axis { cells: segments, closed: false },
            transposed: false,
        };
        let point = |_, r: f64, c: f64| self.point(PI * c / segments as f64, self.height * r);
        lattice.mesh(None, point, |_, _| Diagonal::AC)
    }

    fn check(&self) -> Result<(), ShapeError> {
        positive("the radius of the cylinder", self.radius)?;
        positive("the height of the cylinder", self.height)
    }
}

impl AnalyticSurface for Cylinder {
    fn point(&self, u: f64, v: f64) -> DVec3 {
        DVec3::new(self.radius * u.cos(), self.radius * u.sin(), v)
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        DVec3::new(p.x, p.y, 0.0).normalize_or(DVec3::X)
    }

    /// K = 0.
    fn gaussian_curvature(&self, _: DVec3) -> f64 {
        0.0
    }

    /// H = 1 / (2 r).
    fn mean_curvature(&self, _: DVec3) -> f64 {
        0.5 / self.radius
    }

    fn principal_curvatures(&self, p: DVec3) -> PrincipalCurvatures {
        let around = DVec3::Z.cross(self.normal(p));
        PrincipalCurvatures {
            max: self.radius.recip(),
            min: 0.0,
            directions: Some([around, DVec3::Z]),
        }
    }
}

impl SignedDistance for Cylinder {
    fn signed_distance(&self, p: DVec3) -> f64 {
        p.x.hypot(p.y) - self.radius
    }

    fn closest_point(&self, p: DVec3) -> DVec3 {
        self.radius * self.normal(p) + DVec3::new(0.0, 0.0, p.z)
    }
}
