//! Collapses in blocks: parallel, each block in the cache of one core, with bit-identical results for any number of
//! cores.
//!
//! **Input:** a mesh, rules, a number of faces. **Output:** a mesh without gaps, the resulting vertex for each vertex,
//! and on request the collapses as a log of the input mesh.
//!
//! A run is a sequence of passes. Each pass cuts the mesh by a partition that depends only on its positions, samples a
//! few blocks to estimate the cost that leaves the wanted number of faces, collapses all blocks up to that cost, and
//! joins them. The last part is collapsed in one piece, in the order of costs over the whole mesh.
//!
//! Invariants:
//!
//! - An edge collapses in a block only if all faces around both of its ends belong to vertices of that block. So
//!   collapses of different blocks are independent, and may be merged in any order that keeps the order within each
//!   block.
//! - Vertices and faces keep their ids of the original in addition to their own, and sides keep their half-edges as
//!   `mesh_core` would renumber them. So the log can be replayed, with bit-identical results.
//!
//! Uses the other modules of this crate for quadrics, constraints and records. The caller of `block_greedy` passes the
//! greedy loop.
//!
//! The parts can be used separately, to process blocks one by one, on other machines, or from a disk:
//!
//! ```
//! use mesh_core::TriMesh;
//! use mesh_collapse::blocks::{CostThreshold, Block, Rules, FlatMesh};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let soup = mesh_shapes::Sphere { radius: 1.0 }.icosphere(6)?;
//! let mesh = TriMesh::from_soup(&soup)?;
//! let rules = Rules::new(&mesh);
//! let mut flat = FlatMesh::new(&mesh);
//! for pass in 0..2 {
//!     let partition = flat.partition(pass);
//!     let block = |i| Block::new(&flat, &partition, i, &rules);
//!     let threshold = CostThreshold::leaving(0.4, &[&block(0).forecast(&rules, 0.2)]);
//!     let reduced: Vec<_> =
//!         (0..partition.blocks()).map(|i| block(i).reduce(&rules, threshold)).collect();
//!     flat = FlatMesh::join(reduced);
//! }
//! let small = flat.to_mesh();
//! assert!(small.topology().face_count() < mesh.topology().face_count() / 4);
//! # Ok(())
//! # }
//! ```

mod block;
mod block_greedy;
mod block_mesh;
mod block_vertex;
mod bucket_queue;
mod candidates;
mod corner_table;
mod cost_threshold;
mod edge_rows;
mod flat_mesh;
mod lanes;
mod partition;
mod pass;
mod rank_order;
mod rules;
mod run;
mod submesh;

pub use block::{Block, Reduced};
pub use block_greedy::{Drive, collapse_driven};
pub use cost_threshold::{CostThreshold, Forecast};
pub use flat_mesh::{FlatMesh, Fragment};
pub use partition::Partition;
pub use rules::Rules;
pub use run::{BlockRun, Extent, Precision, collapse_flat_mesh, collapse_in_blocks};
