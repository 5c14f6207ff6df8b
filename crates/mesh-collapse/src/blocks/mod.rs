//! Collapses in blocks: side by side, each in the cache of one core, with the same bits on any number
//! of cores.
//!
//! **In:** a mesh, rules, a number of faces. **Out:** a mesh without gaps, what each vertex has become, and
//! on demand the collapses as a log of the mesh that was given.
//!
//! A run is a row of passes. Each cuts the mesh by a partition that depends on its positions alone,
//! looks at a few of the blocks to tell which cost leaves as many faces as the pass is to leave, collapses
//! all up to that cost, and puts them together again. The last part is done in one piece, in the order of
//! costs over the whole mesh.
//!
//! Invariants:
//!
//! - An edge collapses in a block only if all faces around both of its ends belong to vertices of that
//!   block. So collapses of different blocks neither see nor touch each other, and may be put into any
//!   order that keeps the order within each.
//! - Vertices and faces keep the numbers of the original beside their own, and sides their half-edges as
//!   `mesh_core` would renumber them: the log replays, to the same bits.
//!
//! Uses `collapse` and no other room.
//!
//! The pieces can be used by themselves, to do blocks one by one, elsewhere, or from a disk:
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
