//! Distances between triangle meshes.
//!
//! - [`Surface`]: triangles in a bounding volume hierarchy, with exact closest points;
//! - [`SignedDistance`]: negative inside, positive outside a closed mesh;
//! - [`compare`]: mean, root mean square and maximum distance of two surfaces from samples, both
//!   ways, as Metro measures them;
//! - [`hausdorff_bounds`]: numbers that the Hausdorff distance is proved to lie between.
//!
//! All lengths are in model units. Results are bitwise the same for any number of threads.
//!
//! ```
//! use mesh_core::TriMesh;
//! use mesh_metric::{CompareOptions, Surface, compare};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let square = |z| {
//!     let corners = [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
//!     TriMesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]])
//! };
//! let (floor, ceiling) = (Surface::new(&square(0.0)?)?, Surface::new(&square(2.5)?)?);
//! let result = compare(&floor, &ceiling, &CompareOptions::default());
//! assert_eq!(result.hausdorff(), 2.5);
//! assert!((result.forward.mean - 2.5).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```

mod blocks;
mod bvh;
mod closest;
mod compare;
mod hausdorff;
mod packet;
mod sampling;
mod signed;
mod surface;
mod wide;

pub use closest::{closest_on_triangle, weights_of_closest};
pub use compare::{
    CompareOptions, Comparison, OneSided, Worst, compare, edge_points, vertex_distances,
};
pub use hausdorff::{CertifiedBounds, CertifyOptions, hausdorff_bounds, one_sided_bounds};
pub use sampling::{SurfaceSample, sample_surface};
pub use signed::SignedDistance;
pub use surface::{ClosestPoint, Surface, SurfaceError};
