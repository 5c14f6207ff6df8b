#![doc = include_str!("../README.md")]

mod atan2;

pub mod align;
pub mod angle;
pub mod area;
pub mod ball;
mod ball_faces;
pub mod circumcircle_angle;
pub mod corrected;
pub mod curvatures;
pub mod dihedral;
pub mod edge;
pub mod extrinsic;
pub mod fit;
mod height_points;
mod jet_fit;
pub mod noise;
pub mod principal;
pub mod quantity;
mod scale_choice;
pub mod star;
mod star_batch;
pub mod totals;
pub mod vertex;
mod vertex_loop;
pub mod willmore;

#[doc(inline)]
pub use align::align_directions;
#[doc(inline)]
pub use angle::{corner_angle, triangle_angles};
#[doc(inline)]
pub use area::{VertexArea, corner_area};
#[doc(inline)]
pub use ball::{
    BallCurvature, InvalidRadius, ball_curvature, ball_curvatures, ball_curvatures_until,
    default_ball_radius,
};
#[doc(inline)]
pub use circumcircle_angle::intersection_angle;
#[doc(inline)]
pub use corrected::{
    CorrectedCurvature, corrected_curvature, corrected_curvatures, corrected_curvatures_until,
};
#[doc(inline)]
pub use curvatures::{CurvatureOptions, Curvatures};
#[doc(inline)]
pub use dihedral::{dihedral_angle, hinge_angle};
#[doc(inline)]
pub use edge::{
    dihedral_angles, edge_dihedral_angle, edge_intersection_angle, edge_mean_curvature,
    edge_mean_curvatures, intersection_angles,
};
#[doc(inline)]
pub use extrinsic::{
    ExtrinsicCurvature, extrinsic_curvature, extrinsic_curvatures, total_extrinsic_curvature,
};
#[doc(inline)]
pub use fit::{
    FitScale, FittedCurvature, JetFitOptions, fitted_curvature, fitted_curvatures,
    fitted_curvatures_until,
};
#[doc(inline)]
pub use noise::estimate_noise;
#[doc(inline)]
pub use principal::{PrincipalFrame, principal_frame, principal_frames};
#[doc(inline)]
pub use quantity::{Area, Integral, Pointwise};
#[doc(inline)]
pub use star::{VertexIntegrals, VertexStar};
#[doc(inline)]
pub use totals::Totals;
#[doc(inline)]
pub use vertex::{VertexCurvature, vertex_curvature};
#[doc(inline)]
pub use willmore::{total_willmore_energy, willmore_energies, willmore_energy};
