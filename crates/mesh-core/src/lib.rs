#![doc = include_str!("../README.md")]

pub mod attribute;
pub mod build;
mod checksum;
pub mod edit;
pub mod index;
pub mod measure;
pub mod mesh;
pub mod parallel;
pub mod position;
pub mod random;
#[cfg(feature = "serde")]
mod serial;
#[cfg(feature = "simd")]
pub mod simd;
pub mod topology;

pub use glam;

#[doc(no_inline)]
pub use build::{diagnose, soup};
#[doc(no_inline)]
pub use edit::{butterfly, compact, fill, split_components, subdivide_1_to_4};
#[doc(no_inline)]
pub use measure::{closest_point, crossing, face_tree, laplacian, normals, triangle_bounds};
#[doc(no_inline)]
pub use topology::{
    circulate, components, disjoint_sets, edge_connectivity, handle, pairing, validate,
};

#[doc(inline)]
pub use attribute::{AttributeMap, EdgeMap, Element, FaceMap, HalfEdgeMap, VertexMap};
#[doc(inline)]
pub use build::diagnose::{Diagnosis, diagnose};
#[doc(inline)]
pub use build::soup::PolygonSoup;
#[doc(inline)]
pub use build::{
    BuildError, BuildReport, Built, Provenance, Repair, Weld, build, cut_non_manifold,
};
#[doc(inline)]
pub use checksum::Checksum;

pub use edit::compact::{Remap, RemapOf};
#[doc(inline)]
pub use edit::split_components::Component;
#[doc(inline)]
pub use index::as_u32;
#[doc(inline)]
pub use measure::BoundingBox;
#[doc(inline)]
pub use measure::any_size::{
    direction, orient2d, orient3d, triangle_normal, unit_sized, unit_sized_points,
};
#[doc(inline)]
pub use measure::crossing::triangles_cross;
#[doc(inline)]
pub use measure::face_tree::FaceTree;
#[doc(inline)]
pub use measure::normals::angle_between;
#[doc(inline)]
pub use measure::slab::Slab;
#[doc(inline)]
pub use measure::triangle_bounds::TriangleBounds;
#[doc(inline)]
pub use measure::unit_scale::{ScaleError, UnitScale};
pub use measure::winding::WindingNumbers;
#[doc(inline)]
pub use mesh::{MeshError, TriMesh};
#[doc(inline)]
pub use position::{Position, VertexIndex};
#[doc(inline)]
pub use random::SplitMix64;
#[doc(inline)]
pub use topology::components::Components;
#[doc(inline)]
pub use topology::half_edges::Topology;
#[doc(inline)]
pub use topology::handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};
#[doc(inline)]
pub use topology::pairing::TopologyError;
#[doc(inline)]
pub use topology::validate::BrokenInvariant;
