#![doc = include_str!("../README.md")]

mod blocks;
mod boxes;
mod bvh;
mod closest;
mod compare;
mod farthest;
mod hausdorff;
mod needles;
mod packet;
mod prism;
mod proved;
mod sampling;
mod signed;
mod slab;
mod surface;
mod wide;

pub use closest::{Foot, NoFoot, closest_on_triangle, foot_inside, weights_of_closest};
pub use compare::{
    CompareOptions, Comparison, OneSided, Worst, compare, compare_until, edge_points,
    points_of_edge, sampled_hausdorff, vertex_distances,
};
pub use hausdorff::{
    CertifiedBounds, CertifyOptions, hausdorff_bounds, hausdorff_bounds_until, one_sided_bounds,
};
pub use sampling::{SampleStream, SurfaceSample, area_of, sample_surface};
pub use signed::SignedDistance;
pub use surface::{ClosestPoint, Surface, SurfaceError};
