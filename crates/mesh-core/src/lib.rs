//! Half-edge triangle meshes: the layer that everything else in the workspace stands on.
//!
//! - [`PolygonSoup`] is what a file holds: positions and polygons, nothing checked.
//! - [`build()`] turns a soup into a [`TriMesh`], refusing or [repairing](Repair) what is not an
//!   oriented 2-manifold, and saying what it did.
//! - [`TriMesh`] is a [`Topology`], paired half-edges without any notion of place, and a position
//!   per vertex. Data per vertex, edge, half-edge or face lives in [`AttributeMap`]s of the caller.
//! - [`edit`] flips, collapses and splits: check first, then apply.
//! - [`shapes`] makes meshes of surfaces whose curvature is known exactly; [`butterfly`] subdivides.
//!
//! ```
//! use mesh_core::shapes::Torus;
//! use mesh_core::{Repair, build};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let soup = Torus { major: 5.0, minor: 2.0 }.mesh(12, 6)?;
//! let mesh = build(&soup, &Repair::strict())?.mesh;
//! let topology = mesh.topology();
//! assert_eq!(topology.genus(), 1);
//! for vertex in topology.vertices() {
//!     assert_eq!(topology.one_ring(vertex).count(), 6);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # Conventions
//!
//! Positions are `glam::DVec3`, indices are `u32`, angles are in radians and lengths in the units of
//! the model. Faces are counter-clockwise seen from outside, so that the normal of `(a, b, c)` is
//! that of `(b - a) x (c - a)`. Methods that take a handle panic, like slice indexing, when it
//! belongs to no element of the mesh; whatever depends on input returns an error instead.
//!
//! # Features
//!
//! - `rayon` (default): loops whose order does not matter run on all cores. Results are bitwise the
//!   same without it and for any number of threads.
//! - `hull` (default): convex hulls with exact predicates, and the shapes made from them.

pub mod attribute;
pub mod build;
pub mod butterfly;
pub mod circulate;
pub mod compact;
pub mod connectivity;
pub mod crossing;
pub mod diagnose;
mod disjoint_sets;
pub mod edit;
pub mod face_tree;
pub mod fill;
pub mod handle;
pub mod laplacian;
pub mod measure;
pub mod mesh;
pub mod normals;
pub mod pairing;
pub mod parallel;
pub mod pieces;
pub mod position;
pub mod quadrisect;
mod revision;
#[cfg(feature = "serde")]
mod serial;
pub mod shapes;
pub mod soup;
pub mod topology;
pub mod validate;

pub use attribute::{AttributeMap, EdgeMap, Element, FaceMap, HalfEdgeMap, VertexMap};
pub use build::{BuildError, BuildReport, Built, Provenance, Repair, Weld, build};
pub use compact::{Remap, RemapOf};
pub use connectivity::Components;
pub use crossing::triangles_cross;
pub use diagnose::{Diagnosis, diagnose};
pub use face_tree::FaceTree;
pub use glam;
pub use handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};
pub use measure::BoundingBox;
pub use mesh::{MeshError, TriMesh};
pub use normals::angle_between;
pub use pairing::TopologyError;
pub use pieces::Piece;
pub use position::{Position, VertexIndex};
pub use soup::PolygonSoup;
pub use topology::Topology;
pub use validate::BrokenInvariant;
