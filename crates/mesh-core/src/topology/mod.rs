//! Connectivity: which vertices, edges and faces meet, and nothing about where they are.
//!
//! [`Topology`] is the half-edge structure. The other files navigate it ([`circulate`]), check it
//! ([`validate`]), build it from index triples ([`pairing`]) and count what it is made of ([`components`]).
//! [`EdgeConnectivity`](edge_connectivity::EdgeConnectivity) does the last for triangles that need not be a
//! manifold.

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
