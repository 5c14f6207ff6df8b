#![doc = include_str!("../README.md")]

mod atan2;

pub mod angle;
pub mod area;
pub mod ball;
pub mod curvatures;
pub mod dihedral;
pub mod edge;
pub mod fit;
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
pub use ball::{
    BallCurvature, InvalidRadius, ball_curvature, ball_curvatures, ball_curvatures_until,
};
pub use curvatures::{CurvatureOptions, Curvatures};
pub use dihedral::{dihedral_angle, hinge_angle};
pub use edge::{
    dihedral_angles, edge_dihedral_angle, edge_intersection_angle, edge_mean_curvature,
    edge_mean_curvatures, intersection_angles,
};
pub use fit::{FitOptions, fitted_frame, fitted_frames, fitted_frames_until};
pub use intersection::intersection_angle;
pub use principal::{PrincipalFrame, principal_frame, principal_frames};
pub use quantity::{Area, Integral, Pointwise};
pub use star::{VertexIntegrals, VertexStar};
pub use totals::Totals;
pub use vertex::{VertexCurvature, vertex_curvature};
pub use willmore::{total_willmore_energy, willmore_energies, willmore_energy};
