//! The costs of the papers, and other costs for comparison.

mod abs_extrinsic;
mod abs_mean;
mod edge_sum;
mod edge_term;
mod face_cost;
mod simd_batch;
mod vertex_cost;
mod virtual_willmore;
mod willmore;

pub use abs_extrinsic::AbsExtrinsic;
pub use abs_mean::AbsMean;
pub use face_cost::{FaceCost, FaceFunction};
pub use vertex_cost::{VertexCost, VertexCostCache, VertexFunction};
pub use virtual_willmore::VirtualWillmore;
pub use willmore::Willmore;
