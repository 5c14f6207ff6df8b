//! Graphs z = h(x, y) over a square: a plane, a saddle, a wave.

use crate::analytic::{AnalyticSurface, PrincipalCurvatures};
use crate::error::{ShapeError, at_least, positive};
use crate::irregular::Irregular;
use crate::lattice::{Axis, Diagonal, Lattice};
use core::f64::consts::TAU;
use glam::{DMat3, DVec3};
use mesh_core::PolygonSoup;

/// How the cells of a regular grid are cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Diagonals {
    /// All along (1, 1): inner vertices have valence six.
    #[default]
    Uniform,
    /// Alternating between (1, 1) and (-1, 1), as on a Union Jack: inner vertices have valence four and eight.
    Alternating,
}

impl Diagonals {
    fn of_cell(self, row: usize, column: usize) -> Diagonal {
        match self {
            Self::Alternating if (row + column) % 2 == 1 => Diagonal::BD,
            _ => Diagonal::AC,
        }
    }
}

/// The flat patch z = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Half the side of the square around the origin.
    pub half_width: f64,
}

/// The hyperbolic paraboloid z = c (x² - y²). (z = 2c xy is the same surface, turned by 45°.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Saddle {
    /// c; the principal curvatures at the origin are ±2c.
    pub coefficient: f64,
    /// Half the side of the square around the origin.
    pub half_width: f64,
}

/// The egg-box surface z = A cos(2πx/λ) cos(2πy/λ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// A, the height of the crests.
    pub amplitude: f64,
    /// λ, the distance between crests along x and y.
    pub wavelength: f64,
    /// Half the side of the square around the origin.
    pub half_width: f64,
}

/// Value and partial derivatives up to the second order of a height function at a point.
struct Jet {
    h: f64,
    hx: f64,
    hy: f64,
    hxx: f64,
    hxy: f64,
    hyy: f64,
}

impl Jet {
    /// Length of the upward normal (-hx, -hy, 1).
    fn stretch(&self) -> f64 {
        (1.0 + self.hx * self.hx + self.hy * self.hy).sqrt()
    }

    fn normal(&self) -> DVec3 {
        DVec3::new(-self.hx, -self.hy, 1.0) / self.stretch()
    }

    /// K = (hxx hyy - hxy²) / (1 + hx² + hy²)².
    fn gaussian_curvature(&self) -> f64 {
        (self.hxx * self.hyy - self.hxy * self.hxy) / self.stretch().powi(4)
    }

    /// H = -((1 + hy²) hxx - 2 hx hy hxy + (1 + hx²) hyy) / (2 (1 + hx² + hy²)^(3/2)).
    fn mean_curvature(&self) -> f64 {
        let Self { hx, hy, hxx, hxy, hyy, .. } = *self;
        let trace = (1.0 + hy * hy) * hxx - 2.0 * hx * hy * hxy + (1.0 + hx * hx) * hyy;
        -0.5 * trace / self.stretch().powi(3)
    }

    fn principal_curvatures(&self) -> PrincipalCurvatures {
        // The graph is the level set z - h(x, y) = 0.
        let hessian = DMat3::from_cols(
            DVec3::new(-self.hxx, -self.hxy, 0.0),
            DVec3::new(-self.hxy, -self.hyy, 0.0),
            DVec3::ZERO,
        );
        PrincipalCurvatures::of_level_set(self.normal(), hessian * self.stretch().recip())
    }
}

impl Plane {
    fn jet(&self, _: f64, _: f64) -> Jet {
        Jet { h: 0.0, hx: 0.0, hy: 0.0, hxx: 0.0, hxy: 0.0, hyy: 0.0 }
    }

    fn check(&self) -> Result<(), ShapeError> {
        positive("the half width of the plane", self.half_width)
    }
}

impl Saddle {
    fn jet(&self, x: f64, y: f64) -> Jet {
        let c = self.coefficient;
        Jet {
            h: c * (x * x - y * y),
            hx: 2.0 * c * x,
            hy: -2.0 * c * y,
            hxx: 2.0 * c,
            hxy: 0.0,
            hyy: -2.0 * c,
        }
    }

    fn check(&self) -> Result<(), ShapeError> {
        positive("the half width of the saddle", self.half_width)?;
        positive("the coefficient of the saddle", self.coefficient)
    }
}

impl Wave {
    fn jet(&self, x: f64, y: f64) -> Jet {
        let k = TAU / self.wavelength;
        let ((sx, cx), (sy, cy)) = ((k * x).sin_cos(), (k * y).sin_cos());
        let (a, ak, akk) = (self.amplitude, self.amplitude * k, self.amplitude * k * k);
        Jet {
            h: a * cx * cy,
            hx: -ak * sx * cy,
            hy: -ak * cx * sy,
            hxx: -akk * cx * cy,
            hxy: akk * sx * sy,
            hyy: -akk * cx * cy,
        }
    }

    fn check(&self) -> Result<(), ShapeError> {
        positive("the half width of the wave", self.half_width)?;
        positive("the amplitude of the wave", self.amplitude)?;
        positive("the wavelength of the wave", self.wavelength)
    }
}

macro_rules! height_field {
    ($shape:ident) => {
        impl $shape {
            /// Mesh of `cells` x `cells` square cells over [-w, w]², w the half width. Vertices
            /// lie row after row, x growing fastest.
            ///
            /// # Errors
            /// A parameter that is not positive and finite; no cells.
            pub fn mesh(
                &self,
                cells: usize,
                diagonals: Diagonals,
            ) -> Result<PolygonSoup, ShapeError> {
                self.check()?;
                let point = |x, y| self.point(x, y);
                square_mesh(self.half_width, cells, diagonals, None, point)
            }

            /// Irregular mesh with jittered vertices and random diagonals. Vertices of the border move only along it,
            /// and the corners do not move.
            ///
            /// # Errors
            /// As for `mesh`; a jitter out of range.
            pub fn irregular_mesh(
                &self,
                cells: usize,
                irregular: Irregular,
            ) -> Result<PolygonSoup, ShapeError> {
                self.check()?;
                let point = |x, y| self.point(x, y);
                square_mesh(self.half_width, cells, Diagonals::Uniform, Some(irregular), point)
            }
        }

        impl AnalyticSurface for $shape {
            /// The point above x = u, y = v.
            fn point(&self, u: f64, v: f64) -> DVec3 {
                DVec3::new(u, v, self.jet(u, v).h)
            }

            /// The normal on the side of growing z.
            fn normal(&self, p: DVec3) -> DVec3 {
                self.jet(p.x, p.y).normal()
            }

            fn gaussian_curvature(&self, p: DVec3) -> f64 {
                self.jet(p.x, p.y).gaussian_curvature()
            }

            fn mean_curvature(&self, p: DVec3) -> f64 {
                self.jet(p.x, p.y).mean_curvature()
            }

            fn principal_curvatures(&self, p: DVec3) -> PrincipalCurvatures {
                self.jet(p.x, p.y).principal_curvatures()
            }
        }
    };
}

height_field!(Plane);
height_field!(Saddle);
height_field!(Wave);

fn square_mesh(
    half_width: f64,
    cells: usize,
    diagonals: Diagonals,
    irregular: Option<Irregular>,
    point: impl Fn(f64, f64) -> DVec3,
) -> Result<PolygonSoup, ShapeError> {
    at_least("cells along a side", cells, 1)?;
    let axis = Axis { cells, closed: false };
    let lattice = Lattice { rows: axis, columns: axis, transposed: false };
    let coordinate = |i: f64| half_width * (2.0 * i / cells as f64 - 1.0);
    let at = |_, r, c| point(coordinate(c), coordinate(r));
    lattice.mesh(irregular, at, |row, column| diagonals.of_cell(row, column))
}
