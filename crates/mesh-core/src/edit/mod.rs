//! Changes of a mesh: legal edits, hole filling, subdivision, splitting into components, and compaction.
//!
//! Flips, collapses, splits, and adding and removing faces take two steps: a check that returns a token or the reason
//! why not, and an application of the token that cannot fail.
//!
//! ```
//! use mesh_core::Topology;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut topology = Topology::from_triangles(4, &[[0, 1, 2], [2, 1, 3]])?;
//! let inner = topology.edges().find(|&e| !topology.is_boundary_edge(e)).ok_or("no inner edge")?;
//! let flip = topology.check_flip(inner)?;
//! topology.flip(flip);
//! assert_eq!(topology.edge_vertices(inner).map(|v| v.get()), [0, 3]);
//! # Ok(())
//! # }
//! ```
//!
//! A token belongs to the mesh in its state at the check. Any edit in between makes it stale, and it does not apply to
//! other meshes. Applying such a token panics, since it is a mistake in the program and never depends on the input. A
//! copy of a mesh counts as the same mesh until one of the two is edited; so a flip may be checked on a mesh and tried
//! out on its clone.
//!
//! [`TriMesh::fill_holes`](crate::TriMesh::fill_holes) closes whole holes.

// A token is used up by the edit it allows.
#![allow(clippy::needless_pass_by_value)]

pub mod butterfly;
mod collapse;
pub mod compact;
mod face;
pub mod fill;
mod flip;
mod links;
mod pinched_holes;
mod ring;
mod split;
pub mod split_components;
pub mod subdivide_1_to_4;

pub use collapse::{CollapseRefusal, Collapsed, LegalCollapse};
pub use face::{AddedFace, FaceRefusal, LegalFace, LegalRemoval, RemovalRefusal, RemovedFace};
pub use flip::{FlipRefusal, LegalFlip};
pub use links::NoRoom;
pub(crate) use ring::{Ring, RingOrder};
pub use split::{EdgeSplit, FaceSplit, LegalEdgeSplit, LegalFaceSplit, SplitRefusal};
