#![doc = include_str!("../README.md")]

pub mod attribute;
pub mod build;
pub mod butterfly;
pub mod circulate;
pub mod compact;
pub mod connectivity;
pub mod crossing;
pub mod diagnose;
mod directions;
pub mod disjoint_sets;
pub mod edit;
pub mod extent;
pub mod face_tree;
mod fan;
pub mod fill;
pub mod handle;
pub mod hinges;
pub mod laplacian;
pub mod measure;
pub mod mesh;
pub mod normals;
pub mod pairing;
pub mod parallel;
pub mod pieces;
pub mod position;
pub mod quadrisect;
pub mod random;
mod revision;
#[cfg(feature = "serde")]
mod serial;
pub mod soup;
pub mod topology;
pub mod validate;

#[doc(inline)]
pub use attribute::{AttributeMap, EdgeMap, Element, FaceMap, HalfEdgeMap, VertexMap};
#[doc(inline)]
pub use build::{BuildError, BuildReport, Built, Provenance, Repair, Weld, build};
#[doc(inline)]
pub use compact::{Remap, RemapOf};
#[doc(inline)]
pub use connectivity::Components;
#[doc(inline)]
pub use crossing::triangles_cross;
#[doc(inline)]
pub use diagnose::{Diagnosis, diagnose};
#[doc(inline)]
pub use extent::Extent;
#[doc(inline)]
pub use face_tree::FaceTree;
pub use glam;
#[doc(inline)]
pub use handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};
#[doc(inline)]
pub use measure::BoundingBox;
#[doc(inline)]
pub use mesh::{MeshError, TriMesh};
#[doc(inline)]
pub use normals::angle_between;
#[doc(inline)]
pub use pairing::TopologyError;
#[doc(inline)]
pub use pieces::Piece;
#[doc(inline)]
pub use position::{Position, VertexIndex};
#[doc(inline)]
pub use random::SplitMix64;
#[doc(inline)]
pub use soup::PolygonSoup;
#[doc(inline)]
pub use topology::Topology;
#[doc(inline)]
pub use validate::BrokenInvariant;
