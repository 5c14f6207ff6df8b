//! Half-edge triangle meshes.
pub mod handle;
pub mod shapes;
pub mod soup;

pub use handle::{EdgeId, FaceId, HalfEdgeId, VertexId};
pub use soup::PolygonSoup;
