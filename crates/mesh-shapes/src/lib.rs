//! Analytic test shapes: surfaces with exact curvature, and meshes whose vertices lie on them.
//!
//! A *surface* ([`Sphere`], [`Ellipsoid`], [`Torus`], [`Cylinder`], [`Catenoid`], [`Saddle`], [`Wave`], [`Plane`]) has
//! its normal and curvatures in closed form ([`AnalyticSurface`]); some also have distances ([`SignedDistance`]). Its
//! mesh methods return a [`PolygonSoup`](mesh_core::PolygonSoup) of triangles, counter-clockwise seen from the side of
//! the normal. Each surface has a *regular* family, for convergence under refinement, and an *irregular* one, made from
//! an explicit seed ([`Irregular`]).
//!
//! Free functions make point sets and meshes without an analytic surface: the platonic solids ([`polyhedra`]),
//! [`inset_cube`], the seven points of [`seven_points`]. [`add_normal_noise`] and [`scramble`] perturb the vertices and
//! the triangulation of a mesh.
//!
//! **Signs.** Curvatures are positive where the surface is convex seen from the side of its
//! normal: a sphere of radius r has H = 1/r and K = 1/r². Every value is pointwise, in one over
//! length (K: one over length squared).

mod analytic;
mod catenoid;
mod cylinder;
mod ellipsoid;
mod error;
mod height_field;
mod hull;
mod inset_cube;
mod irregular;
mod lattice;
mod noise;
pub mod polyhedra;
mod scramble;
pub mod seven_points;
mod sphere;
mod torus;

pub use analytic::{AnalyticSurface, PrincipalCurvatures, SignedDistance};
pub use catenoid::Catenoid;
pub use cylinder::{Cylinder, RowPhase};
pub use ellipsoid::Ellipsoid;
pub use error::ShapeError;
pub use height_field::{Diagonals, Plane, Saddle, Wave};
pub use hull::{HullError, convex_hull};
pub use inset_cube::inset_cube;
pub use irregular::Irregular;
pub use noise::{add_normal_noise, mean_edge_length};
pub use scramble::scramble;
pub use sphere::Sphere;
pub use torus::Torus;
