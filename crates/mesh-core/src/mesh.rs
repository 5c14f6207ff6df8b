//! A triangle mesh with positions: the half-edge structure and one point per vertex.

use std::borrow::Cow;

use glam::DVec3;

use crate::build::soup::PolygonSoup;
use crate::edit::compact::{Remap, RemapOf};
use crate::edit::{
    AddedFace, Collapsed, EdgeSplit, FaceSplit, LegalCollapse, LegalEdgeSplit, LegalFace,
    LegalFaceSplit, LegalFlip, LegalRemoval, NoRoom, RemovedFace, Ring,
};
use crate::index::as_u32;
use crate::position::{Position, VertexIndex};
use crate::topology::Topology;
use crate::topology::handle::{FaceId, VertexId};
use crate::topology::pairing::TopologyError;

/// A triangle mesh: [`Topology`] and a position for each of its vertices.
///
/// ```
/// use mesh_core::TriMesh;
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = TriMesh::from_triangles(&corners, &[[0, 1, 2]])?;
/// assert_eq!(mesh.area(), 0.5);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct TriMesh {
    topology: Topology,
    positions: Vec<DVec3>,
}

/// Why positions and triangles do not make a mesh.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The triangles do not form an oriented 2-manifold.
    #[error(transparent)]
    Topology(#[from] TopologyError),
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} is at {position}, which is not finite; remove or correct it")]
    NotFinite {
        /// The vertex.
        vertex: usize,
        /// Its position.
        position: DVec3,
    },
    /// A face is not a triangle.
    #[error("face {face} has {corners} corners, not three; use `build`, which splits polygons")]
    NotATriangle {
        /// The face.
        face: usize,
        /// The number of its corners.
        corners: usize,
    },
    /// The length of a flat array is not a multiple of three.
    #[error("there are {count} {what}, which is not a multiple of three")]
    NotInThrees {
        /// The kind of the numbers.
        what: &'static str,
        /// The length of the array.
        count: usize,
    },
    /// There are not as many positions as vertices.
    #[error("there are {positions} positions for {vertices} vertices; give one for each")]
    PositionCount {
        /// The number of positions given.
        positions: usize,
        /// The number of vertices of the topology.
        vertices: usize,
    },
}

impl TriMesh {
    /// A mesh from positions and index triples that already form an oriented 2-manifold.
    ///
    /// [Positions](Position) may be of `f32` or `f64`, indices of any [integer type](VertexIndex).
    /// Use [`crate::build()`] for polygons, for input that may need repairs, and for errors that
    /// list all defects.
    ///
    /// # Errors
    /// A coordinate is not finite, or the triangles do not form an oriented 2-manifold.
    pub fn from_triangles<P: Position, I: VertexIndex>(
        positions: &[P],
        triangles: &[[I; 3]],
    ) -> Result<Self, MeshError> {
        let triangles: Cow<'_, [[u32; 3]]> = I::triangles(triangles);
        let topology = Topology::from_triangles(positions.len(), &triangles)?;
        Self::new(topology, positions.iter().map(Position::to_dvec3).collect())
    }

    /// A mesh from flat arrays: three coordinates per vertex, three indices per triangle; otherwise as
    /// [`TriMesh::from_triangles`].
    ///
    /// ```
    /// use mesh_core::TriMesh;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let mesh = TriMesh::from_flat(&[0_f32, 0., 0., 1., 0., 0., 0., 1., 0.], &[0_usize, 1, 2])?;
    /// assert_eq!(mesh.area(), 0.5);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As there, or the length of an array is not a multiple of three.
    pub fn from_flat<C: Copy + Into<f64>, I: VertexIndex>(
        coordinates: &[C],
        indices: &[I],
    ) -> Result<Self, MeshError> {
        let (positions, []) = coordinates.as_chunks::<3>() else {
            return Err(MeshError::NotInThrees { what: "coordinates", count: coordinates.len() });
        };
        let (triangles, []) = indices.as_chunks::<3>() else {
            return Err(MeshError::NotInThrees { what: "indices", count: indices.len() });
        };
        let positions: Vec<[f64; 3]> = positions.iter().map(|p| p.map(Into::into)).collect();
        Self::from_triangles(&positions, triangles)
    }

    /// A mesh from a soup of triangles that already form an oriented 2-manifold; otherwise as
    /// [`TriMesh::from_triangles`].
    ///
    /// # Errors
    /// As there, or a face is not a triangle.
    pub fn from_soup(soup: &PolygonSoup) -> Result<Self, MeshError> {
        let triangle = |(face, corners): (usize, &[u32])| {
            let count = corners.len();
            corners.try_into().map_err(|_| MeshError::NotATriangle { face, corners: count })
        };
        let triangles: Vec<[u32; 3]> =
            soup.faces().enumerate().map(triangle).collect::<Result<_, _>>()?;
        Self::from_triangles(soup.positions(), &triangles)
    }

    /// A mesh from its parts; positions are indexed by vertex, including removed vertices.
    ///
    /// # Errors
    /// The number of positions does not match, or a coordinate is not finite.
    pub fn new(topology: Topology, positions: Vec<DVec3>) -> Result<Self, MeshError> {
        if positions.len() != topology.vertex_capacity() {
            let vertices = topology.vertex_capacity();
            return Err(MeshError::PositionCount { positions: positions.len(), vertices });
        }
        match positions.iter().position(|p| !p.is_finite()) {
            Some(vertex) => Err(MeshError::NotFinite { vertex, position: positions[vertex] }),
            None => Ok(Self { topology, positions }),
        }
    }

    /// The triangles as a soup, for files and [`crate::build()`]. Removed elements are left out, and everything else
    /// keeps its order: vertex `i` of the soup is the `i`-th of [`Topology::vertices`], face `j` the `j`-th of
    /// [`Topology::faces`], with its corners in the order of [`Topology::face_vertices`]. Isolated vertices stay.
    ///
    /// ```
    /// use mesh_core::TriMesh;
    /// use mesh_shapes::polyhedra;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let mut mesh = TriMesh::from_soup(&polyhedra::octahedron())?;
    /// let half_edge = mesh.topology().half_edges().next().ok_or("no half-edge")?;
    /// let collapse = mesh.topology().check_collapse(half_edge)?;
    /// mesh.collapse(collapse, [0.0; 3].into());
    /// let soup = mesh.to_soup();
    /// assert_eq!((soup.vertex_count(), soup.face_count()), (5, 6));
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn to_soup(&self) -> PolygonSoup {
        let topology = &self.topology;
        if topology.is_compact() {
            return PolygonSoup::of_triangles(self.positions.clone(), topology.triangles());
        }
        let mut new_index = topology.vertex_map(0);
        let mut positions = Vec::with_capacity(topology.vertex_count());
        for vertex in topology.vertices() {
            new_index[vertex] = as_u32(positions.len());
            positions.push(self.position(vertex));
        }
        let triangle = |face| topology.face_vertices(face).map(|v| new_index[v]);
        PolygonSoup::of_triangles(positions, topology.faces().map(triangle))
    }

    /// The topology and the positions.
    #[must_use]
    pub fn into_parts(self) -> (Topology, Vec<DVec3>) {
        (self.topology, self.positions)
    }

    /// The connectivity.
    #[must_use]
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The position of each vertex, indexed by vertex.
    #[must_use]
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Mutable access to the positions, indexed by vertex. Keep them finite: all computations rely on it.
    #[must_use]
    pub fn positions_mut(&mut self) -> &mut [DVec3] {
        &mut self.positions
    }

    /// The position of a vertex.
    #[inline]
    #[must_use]
    pub fn position(&self, vertex: VertexId) -> DVec3 {
        self.positions[vertex.index()]
    }

    /// The positions of a face's three vertices, counter-clockwise.
    #[inline]
    #[must_use]
    pub fn triangle(&self, face: FaceId) -> [DVec3; 3] {
        // `map` is not always inlined here, and a call costs more than three loads.
        let [a, b, c] = self.topology.face_vertices(face);
        [self.position(a), self.position(b), self.position(c)]
    }

    /// Flips an edge; see [`Topology::flip`].
    ///
    /// # Panics
    /// When the mesh was edited after the flip was checked.
    pub fn flip(&mut self, flip: LegalFlip) {
        self.topology.flip(flip);
    }

    /// Collapses an edge and puts the remaining vertex at `position`; see [`Topology::collapse`].
    ///
    /// # Panics
    /// When the mesh was edited after the collapse was checked.
    pub fn collapse(&mut self, collapse: LegalCollapse, position: DVec3) -> Collapsed {
        let collapsed = self.topology.collapse(collapse);
        self.positions[collapsed.kept_vertex.index()] = position;
        collapsed
    }

    /// Splits an edge at a new vertex with this position; see [`Topology::split_edge`].
    ///
    /// # Panics
    /// When the mesh was edited after the split was checked.
    pub fn split_edge(&mut self, split: LegalEdgeSplit, position: DVec3) -> EdgeSplit {
        self.positions.push(position);
        self.topology.split_edge(split)
    }

    /// Splits a face at a new vertex with this position; see [`Topology::split_face`].
    ///
    /// # Panics
    /// When the mesh was edited after the split was checked.
    pub fn split_face(&mut self, split: LegalFaceSplit, position: DVec3) -> FaceSplit {
        self.positions.push(position);
        self.topology.split_face(split)
    }

    /// Adds an isolated vertex at this position, which must be finite.
    ///
    /// # Errors
    /// Indices run out.
    pub fn add_vertex(&mut self, position: impl Position) -> Result<VertexId, NoRoom> {
        let vertex = self.topology.add_vertex()?;
        self.positions.push(position.to_dvec3());
        Ok(vertex)
    }

    /// Adds a face; see [`Topology::check_add_face`].
    ///
    /// # Panics
    /// When the mesh was edited after the face was checked.
    pub fn add_face(&mut self, face: LegalFace) -> AddedFace {
        self.topology.add_face(face)
    }

    /// Removes a face; see [`Topology::check_remove_face`].
    ///
    /// # Panics
    /// When the mesh was edited after the removal was checked.
    pub fn remove_face(&mut self, removal: LegalRemoval) -> RemovedFace {
        self.topology.remove_face(removal)
    }

    /// Removes all vertices without edges, and returns their number.
    pub fn remove_isolated_vertices(&mut self) -> usize {
        self.topology.remove_isolated_vertices()
    }

    /// Cuts a vertex off the ring around a hole; see [`Topology::cut_off`].
    pub(crate) fn cut_off(&mut self, ring: &mut Ring, place: u32) -> FaceId {
        self.topology.cut_off(ring, place)
    }

    /// Closes the ring around a hole with a new vertex; see [`Topology::close_with_fan`].
    pub(crate) fn close_with_fan(
        &mut self,
        ring: &mut Ring,
        position: DVec3,
    ) -> (VertexId, Vec<FaceId>) {
        self.positions.push(position);
        self.topology.close_with_fan(ring)
    }

    /// Joins copies of vertices where holes meet; see [`Topology::join_pinched_holes`].
    pub(crate) fn join_pinched_holes(&mut self, copies: Vec<Vec<VertexId>>) -> Vec<Vec<VertexId>> {
        self.topology.join_pinched_holes(copies)
    }

    /// Cuts joined copies that no faces join; see [`Topology::cut_open_fans`].
    pub(crate) fn cut_open_fans(&mut self, joined: &[Vec<VertexId>]) {
        self.topology.cut_open_fans(joined);
    }

    /// Closes the gaps of removed elements; see [`Topology::compact`].
    pub fn compact(&mut self) -> Remap {
        let remap = self.topology.compact();
        let mut old = 0_u32;
        self.positions.retain(|_| {
            old += 1;
            remap.new_handle(VertexId::new(old - 1)).is_some()
        });
        self.positions.shrink_to_fit();
        remap
    }

    /// Bytes held by topology and positions, capacity slack included.
    #[must_use]
    pub fn heap_bytes(&self) -> usize {
        self.topology.heap_bytes() + size_of::<DVec3>() * self.positions.capacity()
    }
}

/// As [`TriMesh::to_soup`].
impl From<&TriMesh> for PolygonSoup {
    fn from(mesh: &TriMesh) -> Self {
        mesh.to_soup()
    }
}
