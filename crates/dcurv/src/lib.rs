//! Discrete curvature of triangle meshes.
//!
//! ```
//! use dcurv::{CurvatureOptions, Curvatures};
//! use mesh_core::TriMesh;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let corners = [[1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]];
//! let faces = [[4, 0, 2], [4, 2, 1], [4, 1, 3], [4, 3, 0], [5, 2, 0], [5, 1, 2], [5, 3, 1], [5, 0, 3]];
//! let octahedron = TriMesh::from_triangles(&corners, &faces)?;
//! let curvatures = Curvatures::of(&octahedron, &CurvatureOptions::default());
//! let totals = curvatures.totals();
//! assert!((totals.gaussian.value() - 4.0 * core::f64::consts::PI).abs() < 1e-12);
//! for vertex in octahedron.topology().vertices() {
//!     let [k1, k2] = curvatures[vertex].principal();
//!     assert!(k1 >= k2 && k2.value() > 0.0);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! | what | formula | where |
//! |---|---|---|
//! | integral Gaussian curvature | `K̄ = 2 pi - sum of angles`, on the boundary `pi - ...` | [`star`] |
//! | integral mean curvature, signed | `H̄ = 1/4 sum of \|e\| beta` | [`star`] |
//! | integral absolute mean curvature | `\|H̄\| = 1/4 sum of \|e\| \|beta\|` | [`star`] |
//! | signed dihedral angle `beta` | | [`dihedral`], of mesh edges [`edge`] |
//! | Voronoi and barycentric area `S` | | [`area`] |
//! | pointwise `K`, `H`, `k1`, `k2`, shape index, curvedness | `K̄/S`, `H̄/S`, `H ± sqrt(H² - K)` | [`vertex`] |
//! | a whole mesh | | [`curvatures`] |
//! | costs F1, F2, F3; norms; totals | | [`totals`] |
//! | Bobenko's intersection angle `beta` | | [`intersection`] |
//! | Bobenko's Willmore energy | `sum of beta(e) - 2 pi` | [`willmore`] |
//! | principal directions | quadratic fit | [`principal`] |
//!
//! The angle-weighted vertex normal is [`mesh_core::TriMesh::vertex_normal`].
//!
//! # Integrated or pointwise
//!
//! Integrals and pointwise values have different types; see [`quantity`]. Angles are in radians and
//! lengths in model units. Convex is positive: a sphere of radius r with outward normals has
//! `H = 1/r` and `K = 1/r²`.
//!
//! # What converges
//!
//! Integrals over a fixed region converge to those of the surface when the mesh is refined, with
//! about the second order, on regular and irregular meshes alike. The pointwise values of the
//! papers do so, with the second order, where the star of a vertex tends to a point-symmetric one:
//! on grids of parameters whose vertices have valence six. At other vertices (valence five of a
//! stretched icosphere, random triangles) their error does **not** fall; it stays at some percent
//! of the curvature. The fitted curvatures of [`principal`] converge everywhere.
//!
//! # Speed and reproducibility
//!
//! Everything is computed with basic arithmetic and square roots, in a fixed order: results have
//! the same bits on any number of threads, with and without the `rayon` feature, and on any
//! platform that follows IEEE 754. (Principal directions use the platform's sine and arc tangent.)
//!
//! # Sources
//!
//! - DHKL01: Dyn, Hormann, Kim, Levin 2001, Optimizing 3D triangulations using discrete curvature
//!   analysis.
//! - KKL02: Kim, Kim, Levin 2002, Surface simplification using a discrete curvature norm.
//! - BAR06: Brink, Alboul, Rodrigues 2006, Mesh optimisation based on Willmore energy.

mod atan2;

pub mod angle;
pub mod area;
pub mod curvatures;
pub mod dihedral;
pub mod edge;
pub mod intersection;
pub mod principal;
pub mod quantity;
pub mod star;
mod star_block;
pub mod totals;
pub mod vertex;
pub mod willmore;

pub use angle::{corner_angle, triangle_angles};
pub use area::{VertexArea, corner_area};
pub use curvatures::{CurvatureOptions, Curvatures};
pub use dihedral::{dihedral_angle, hinge_angle};
pub use edge::{
    dihedral_angles, edge_dihedral_angle, edge_intersection_angle, edge_mean_curvature,
    edge_mean_curvatures, intersection_angles,
};
pub use intersection::intersection_angle;
pub use principal::{PrincipalFrame, principal_frame, principal_frames};
pub use quantity::{Area, Integral, Pointwise};
pub use star::{VertexIntegrals, VertexStar};
pub use totals::Totals;
pub use vertex::{VertexCurvature, vertex_curvature};
pub use willmore::{total_willmore_energy, willmore_energies, willmore_energy};
