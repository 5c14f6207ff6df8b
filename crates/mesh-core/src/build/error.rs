//! Why a polygon soup cannot become a mesh.

use core::fmt;

use crate::build::sample::{Sample, VertexPair};
use crate::mesh::MeshError;

/// Why [`crate::build()`] refused a polygon soup: what is wrong, where, and which repair helps.
///
/// Faces and vertices are numbered as in the soup, from zero.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// More elements than 32-bit indices can address.
    #[error(
        "the mesh has {count} {what}, but 32-bit indices allow only {limit}; split it into parts"
    )]
    TooManyElements {
        /// The kind of the elements.
        what: &'static str,
        /// Their number.
        count: usize,
        /// The largest allowed number.
        limit: usize,
    },
    /// A weld distance that is negative, infinite or not a number.
    #[error("the weld distance is {distance}; it must be finite and not negative")]
    InvalidWeldDistance {
        /// The distance asked for.
        distance: f64,
    },
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} is at ({}, {}, {}), which is not finite ({}); `drop_not_finite` drops such vertices with their faces", position[0], position[1], position[2], such(vertices, "vertex", "vertices"))]
    NonFiniteCoordinate {
        /// The first such vertex.
        vertex: u32,
        /// Its position.
        position: [f64; 3],
        /// All such vertices.
        vertices: Sample<u32>,
    },
    /// A face refers to a vertex that does not exist.
    #[error(
        "face {face} refers to vertex {index}, but there are only {vertex_count} vertices ({}); `drop_out_of_range` drops such faces",
        such(faces, "face", "faces")
    )]
    IndexOutOfRange {
        /// The first such face.
        face: u32,
        /// The index it holds.
        index: u32,
        /// The number of vertices.
        vertex_count: usize,
        /// All such faces.
        faces: Sample<u32>,
    },
    /// A face has fewer than three corners.
    #[error(
        "face {face} has {corners} corners instead of 3 or more ({}); `drop_degenerate` drops such faces",
        such(faces, "face", "faces")
    )]
    TooFewCorners {
        /// The first such face.
        face: u32,
        /// The number of its corners.
        corners: usize,
        /// All such faces.
        faces: Sample<u32>,
    },
    /// A face, or a triangle that a polygon has to be cut into, uses a vertex twice.
    #[error(
        "face {face} is degenerate: it uses vertex {vertex} twice ({}); `drop_degenerate` drops such triangles",
        such(faces, "face", "faces")
    )]
    RepeatedVertex {
        /// The first such face.
        face: u32,
        /// The vertex that it repeats.
        vertex: u32,
        /// All such faces, once for each triangle.
        faces: Sample<u32>,
    },
    /// Two faces have the same vertices.
    #[error(
        "face {face} is a duplicate of face {original} ({}); `drop_duplicates` keeps the first of each",
        such(duplicates, "face", "faces")
    )]
    DuplicateFace {
        /// The first face that repeats another.
        face: u32,
        /// The earlier face with the same vertices.
        original: u32,
        /// All faces that repeat an earlier one.
        duplicates: Sample<u32>,
    },
    /// More than two faces share an edge.
    #[error(
        "edge {edge} is non-manifold: {} faces share it, more than two ({}); `cut_non_manifold` cuts the surface along such edges",
        faces.count(),
        such(edges, "edge", "edges")
    )]
    NonManifoldEdge {
        /// The first such edge.
        edge: VertexPair,
        /// Its faces.
        faces: Sample<u32>,
        /// All such edges.
        edges: Sample<VertexPair>,
    },
    /// Two neighbours traverse their common edge in the same direction. Reversing some faces makes all agree.
    #[error(
        "faces {} and {} have opposite orientations: both traverse edge {edge} in the same direction ({}); `reorient` reverses faces until neighbours agree",
        faces[0], faces[1], such(edges, "edge", "edges")
    )]
    InconsistentOrientation {
        /// The first such edge.
        edge: VertexPair,
        /// Its two faces.
        faces: [u32; 2],
        /// All such edges.
        edges: Sample<VertexPair>,
    },
    /// The surface is not orientable, like a Möbius strip: no choice of orientations makes all neighbours agree.
    #[error(
        "the surface is not orientable: faces {} and {} disagree at edge {edge} however faces are reversed ({}); `reorient` with `cut_non_manifold` cuts the surface there",
        faces[0], faces[1], such(edges, "edge", "edges")
    )]
    NonOrientable {
        /// The first edge that stays inconsistent.
        edge: VertexPair,
        /// Its two faces.
        faces: [u32; 2],
        /// The edges that one attempt at orienting left inconsistent.
        edges: Sample<VertexPair>,
    },
    /// Several surfaces touch only at a vertex: its faces form several fans.
    #[error(
        "vertex {vertex} is non-manifold: {fans} surfaces touch only at this point ({}); `cut_non_manifold` separates them",
        such(vertices, "vertex", "vertices")
    )]
    PinchedVertex {
        /// The first such vertex.
        vertex: u32,
        /// The number of fans at it.
        fans: usize,
        /// All such vertices.
        vertices: Sample<u32>,
    },
    /// The half-edge structure refused the triangles although no defect was found.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// `1 such vertex`, or `3 such vertices: 4, 8, 15`.
fn such<T: fmt::Display>(sample: &Sample<T>, one: &str, many: &str) -> String {
    match sample.count() {
        1 => format!("1 such {one}"),
        count => format!("{count} such {many}: {}", sample.listed()),
    }
}
