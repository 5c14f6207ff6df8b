//! Discrete curvature of triangle meshes.

mod atan2;

pub mod angle;
pub mod area;
pub mod dihedral;
pub mod quantity;
pub mod star;
pub mod willmore;

pub use angle::corner_angle;
pub use area::{VertexArea, corner_area};
pub use dihedral::dihedral_angle;
pub use quantity::{Area, Integral, Pointwise};
pub use star::{VertexIntegrals, VertexStar};
pub use willmore::intersection_angle;
