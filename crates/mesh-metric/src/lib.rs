#![doc = include_str!("../README.md")]

mod bvh;
mod bvh_storage;
mod compare;
mod distance_bounds;
mod early_split;
mod farthest;
mod frame;
mod hausdorff;
mod normal_deviation;
mod packet_traversal;
mod polygon_clipping;
mod sampling;
mod signed_distance;
mod simd_distance;
mod slab;
mod surface;

pub use compare::{
    CompareOptions, Comparison, OneSided, SignedSide, Worst, compare, compare_one_way,
    compare_one_way_until, compare_signed_until, compare_until, edge_points, face_distances,
    points_of_edge, sampled_hausdorff, vertex_distances,
};
pub use hausdorff::{
    CertifiedBounds, CertifyOptions, hausdorff_bounds, hausdorff_bounds_until, one_sided_bounds,
};
pub use mesh_core::closest_point::{
    Foot, NoFoot, closest_on_triangle, foot_inside, weights_of_closest,
};
pub use normal_deviation::normal_deviation;
pub use sampling::{SampleStream, SurfaceSample, area_of, sample_surface};
pub use signed_distance::{SignRule, SignedDistance};
pub use surface::{ClosestPoint, Surface, SurfaceError};
