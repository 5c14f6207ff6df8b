//! Why a polygon soup cannot become a mesh.

use crate::build::sample::{Sample, VertexPair};
use crate::mesh::MeshError;

/// Why [`crate::build()`] refused a polygon soup: what is wrong, where, and what would cure it.
///
/// Faces and vertices are those of the soup, counted from zero.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// More elements than 32-bit indices can address.
    #[error(
        "the mesh has {count} {what}, more than the {limit} that 32-bit indices allow; split it into parts"
    )]
    TooManyElements {
        /// What there are too many of.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A weld distance that is negative, infinite or not a number.
    #[error("the weld distance is {distance}; it must be a finite number that is not negative")]
    InvalidWeldDistance {
        /// The distance asked for.
        distance: f64,
    },
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} has the position ({}, {}, {}), which is not finite; vertices like this: {vertices}; correct the input, no repair invents coordinates", position[0], position[1], position[2])]
    NonFiniteCoordinate {
        /// The first such vertex.
        vertex: u32,
        /// Its position.
        position: [f64; 3],
        /// All such vertices.
        vertices: Sample<u32>,
    },
    /// A face refers to a vertex that is not there.
    #[error(
        "face {face} refers to vertex {index}, but there are {vertex_count} vertices; faces like this: {faces}; `drop_out_of_range` drops them"
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
        "face {face} has {corners} corners; faces with fewer than 3: {faces}; `drop_degenerate` drops them"
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
        "face {face} uses vertex {vertex} twice; faces like this: {faces}; `drop_degenerate` drops such triangles"
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
        "face {face} has the same vertices as face {original}; duplicate faces: {duplicates}; `drop_duplicates` keeps the first of each"
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
        "the edge between vertices {edge} belongs to {faces} faces; edges with more than two faces: {edges}; `cut_non_manifold` cuts the surface along them"
    )]
    NonManifoldEdge {
        /// The first such edge.
        edge: VertexPair,
        /// Its faces.
        faces: Sample<u32>,
        /// All such edges.
        edges: Sample<VertexPair>,
    },
    /// Neighbouring faces run along their common edge in the same direction; reversing some of the
    /// faces would make all agree.
    #[error("faces {} and {} run along the edge between vertices {edge} in the same direction; edges like this: {edges}; `reorient` reverses faces until neighbours agree", faces[0], faces[1])]
    InconsistentOrientation {
        /// The first such edge.
        edge: VertexPair,
        /// Its two faces.
        faces: [u32; 2],
        /// All such edges.
        edges: Sample<VertexPair>,
    },
    /// No choice of orientations makes all neighbouring faces agree, as on a Möbius strip.
    #[error("the surface cannot be oriented: however faces are reversed, some neighbours disagree, such as faces {} and {} at the edge between vertices {edge}; edges left over: {edges}; `reorient` with `cut_non_manifold` cuts the surface along them", faces[0], faces[1])]
    NonOrientable {
        /// The first edge that stays inconsistent.
        edge: VertexPair,
        /// Its two faces.
        faces: [u32; 2],
        /// The edges that one attempt at orienting left inconsistent.
        edges: Sample<VertexPair>,
    },
    /// Surfaces touch in a vertex only: its faces form several fans.
    #[error(
        "the faces at vertex {vertex} form {fans} fans that touch only there; vertices like this: {vertices}; `cut_non_manifold` takes them apart"
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
