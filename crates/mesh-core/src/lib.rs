//! Half-edge triangle meshes.
pub mod attribute;
pub mod circulate;
pub mod compact;
pub mod connectivity;
pub mod edit;
pub mod handle;
pub mod measure;
pub mod mesh;
pub mod normals;
pub mod pairing;
pub mod parallel;
pub mod shapes;
pub mod soup;
pub mod topology;
pub mod validate;

pub use attribute::{AttributeMap, EdgeMap, FaceMap, HalfEdgeMap, RemapOf, VertexMap};
pub use compact::Remap;
pub use connectivity::Components;
pub use handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};
pub use measure::BoundingBox;
pub use mesh::{MeshError, TriMesh};
pub use normals::angle_between;
pub use pairing::TopologyError;
pub use soup::PolygonSoup;
pub use topology::Topology;
pub use validate::BrokenInvariant;
