//! Collapses in regions: side by side, each in the cache of one core, with the same bits on any number
//! of cores.
//!
//! **In:** a mesh, rules, a number of faces. **Out:** a mesh without gaps, what each vertex has become, and
//! on demand the collapses as a log of the mesh that was given.
//!
//! A run is a row of passes. Each cuts the mesh by a partition that depends on its positions alone,
//! looks at a few of the regions to tell which cost leaves as many faces as the pass is to leave, collapses
//! all up to that cost, and puts them together again. The last part is done in one piece, in the order of
//! costs over the whole mesh.
//!
//! Invariants:
//!
//! - An edge collapses in a region only if all faces round both of its ends belong to vertices of that
//!   region. So collapses of different regions neither see nor touch each other, and may be put into any
//!   order that keeps the order within each.
//! - Vertices and faces keep the numbers of the original beside their own, and sides their half-edges as
//!   `mesh_core` would renumber them: the log replays, to the same bits.
//!
//! Uses `collapse` and no other room.
//!
//! The pieces can be used by themselves, to do regions one by one, elsewhere, or from a disk:
//!
//! ```
//! use mesh_core::TriMesh;
//! use simplify::regions::{Ceiling, Region, Rules, Sheet};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let soup = mesh_core::shapes::Sphere { radius: 1.0 }.icosphere(6)?;
//! let mesh = TriMesh::from_soup(&soup)?;
//! let rules = Rules::new(&mesh);
//! let mut sheet = Sheet::new(&mesh);
//! for pass in 0..2 {
//!     let partition = sheet.partition(pass);
//!     let region = |i| Region::new(&sheet, &partition, i, &rules);
//!     let ceiling = Ceiling::leaving(0.4, &[&region(0).forecast(&rules, 0.2)]);
//!     let reduced: Vec<_> =
//!         (0..partition.regions()).map(|i| region(i).reduce(&rules, ceiling)).collect();
//!     sheet = Sheet::join(reduced);
//! }
//! let small = sheet.to_mesh();
//! assert!(small.topology().face_count() < mesh.topology().face_count() / 4);
//! # Ok(())
//! # }
//! ```
//!
//! From the bottom: `corners`, `lanes`, `order`, `waiting`, `rules`; `vertex`; `offers`, `patch`; `tile`, `ceiling`; `sheet`; `partition`; `region`;
//! `pass`; `run`. Beside these, `excerpt` and `driven`: regions for the driver.

mod ceiling;
mod corners;
pub(crate) mod driven;
mod excerpt;
mod lanes;
mod offers;
mod order;
mod partition;
mod pass;
mod patch;
mod region;
mod rules;
pub(crate) mod run;
mod sheet;
mod tile;
mod vertex;
mod waiting;

pub use ceiling::{Ceiling, Forecast};
pub use partition::Partition;
pub use region::{Reduced, Region};
pub use rules::Rules;
pub use sheet::{Fragment, Sheet};
