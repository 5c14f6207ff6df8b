//! Discrete curvature of triangle meshes.

mod atan2;

pub mod angle;
pub mod area;
pub mod curvatures;
pub mod dihedral;
pub mod edge;
pub mod principal;
pub mod quantity;
pub mod star;
pub mod totals;
pub mod vertex;
pub mod willmore;

pub use angle::corner_angle;
pub use area::{VertexArea, corner_area};
pub use curvatures::{CurvatureOptions, Curvatures};
pub use dihedral::dihedral_angle;
pub use edge::{
    dihedral_angles, edge_dihedral_angle, edge_intersection_angle, edge_mean_curvature,
    edge_mean_curvatures, intersection_angles,
};
pub use principal::{PrincipalFrame, principal_frame, principal_frames};
pub use quantity::{Area, Integral, Pointwise};
pub use star::{VertexIntegrals, VertexStar};
pub use totals::Totals;
pub use vertex::{VertexCurvature, vertex_curvature};
pub use willmore::{intersection_angle, total_willmore_energy, willmore_energies, willmore_energy};
