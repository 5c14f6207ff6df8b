//! Sizes, normals and operators of meshes; boxes, search trees and exact intersection tests of triangles.

pub mod any_size;
pub mod bounding_box;
pub mod closest_point;
mod containment;
pub mod cracks;
pub mod crossing;
mod direction_box;
pub mod face_tree;
pub mod facing;
mod fan;
pub mod laplacian;
pub mod normals;
pub mod size;
pub mod slab;
pub mod triangle_bounds;
pub mod unit_scale;
mod visibility;
pub mod winding;

#[doc(inline)]
pub use bounding_box::BoundingBox;
#[doc(inline)]
pub use facing::{Facing, Facings};
#[doc(inline)]
pub use size::SoupMeasures;
