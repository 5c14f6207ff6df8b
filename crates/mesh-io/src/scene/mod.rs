//! glTF documents that are kept whole: what enters as a scene leaves as one.
//!
//! A [`Scene`] holds the JSON of a document and the bytes of its buffers as they were read. Only the vertices and
//! triangles of meshes can be replaced; everything else is written as it was.
//!
//! Layers, lowest first: `vertex_data`; `document`, reading and access; `references`, the places of a document that
//! hold indices of accessors, views and buffers, and `extensions`, which of them are known; `colors` of
//! files that do not mark them; `geometry`, the content of
//! a mesh; `placement`, where meshes are drawn, and `poses`, the shapes that
//! they take there; `prune`, which drops what nothing refers to any more; `replace`;
//! `divide`, copies of shared meshes; `levels` in one document; `disjoint` sets; `influences` of skins, `grids` of positions and `quantize`;
//! `reorder` and `compress`; `write`.

mod check;
mod colors;
mod compress;
mod disjoint;
mod divide;
mod document;
mod extensions;
mod geometry;
mod grids;
mod influences;
mod levels;
mod placement;
mod poses;
mod prune;
mod quantize;
mod references;
mod reorder;
mod replace;
mod vertex_data;
mod write;

pub use document::{Scene, SceneNode};
pub use geometry::{SceneMesh, ScenePrimitive};
pub use placement::SceneDraw;
pub use poses::ScenePose;
pub use quantize::QuantizedScene;
pub use replace::{NewMesh, NewPrimitive};
pub use vertex_data::VertexData;
