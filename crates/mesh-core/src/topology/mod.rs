//! Connectivity: which vertices, edges and faces meet, without positions.
//!
//! [`Topology`] is the half-edge structure. The other modules build it from index triples ([`pairing`]),
//! navigate it ([`circulate`]), check it ([`validate`]), and count components and handles ([`components`]).
//! [`EdgeConnectivity`](edge_connectivity::EdgeConnectivity) counts components and fans of triangles that need
//! not be manifold.

pub mod circulate;
pub mod components;
pub mod disjoint_sets;
pub mod edge_connectivity;
pub mod half_edges;
pub mod handle;
pub mod pairing;
pub(crate) mod revision;
pub mod validate;

#[doc(inline)]
pub use components::Components;
#[doc(inline)]
pub use half_edges::Topology;
