//! A triangle mesh with positions: the half-edge structure and one point per vertex.

use glam::DVec3;

use crate::compact::{Remap, RemapOf};
use crate::edit::{
    Collapsed, EdgeSplit, FaceSplit, LegalCollapse, LegalEdgeSplit, LegalFaceSplit, LegalFlip,
};
use crate::handle::{FaceId, VertexId};
use crate::pairing::TopologyError;
use crate::soup::PolygonSoup;
use crate::topology::Topology;

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
    #[error("vertex {vertex} is at {position}, which is not finite; remove it or give it a place")]
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
        /// How many corners it has.
        corners: usize,
    },
    /// There are not as many positions as vertices.
    #[error("there are {positions} positions for {vertices} vertices; give one for each")]
    PositionCount {
        /// How many positions were given.
        positions: usize,
        /// How many the topology needs.
        vertices: usize,
    },
}

impl TriMesh {
    /// A mesh from positions and index triples that already form an oriented 2-manifold.
    ///
    /// Use [`crate::build()`] for polygons, for input that may need repairs, and for errors that
    /// list every offence.
    ///
    /// # Errors
    /// A coordinate is not finite, or the triangles do not form an oriented 2-manifold.
    pub fn from_triangles<P: Copy + Into<DVec3>>(
        positions: &[P],
        triangles: &[[u32; 3]],
    ) -> Result<Self, MeshError> {
        let topology = Topology::from_triangles(positions.len(), triangles)?;
        Self::new(topology, positions.iter().map(|&p| p.into()).collect())
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

    /// A mesh from its parts; positions are indexed by vertex, those of removed vertices included.
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

    /// The position of each vertex, to be changed in place. Keep them finite: every computation
    /// on the mesh relies on it.
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
        self.topology.face_vertices(face).map(|v| self.position(v))
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

    /// Closes the gaps of removed elements; see [`Topology::compact`].
    pub fn compact(&mut self) -> Remap {
        let remap = self.topology.compact();
        let mut old = 0_u32;
        self.positions.retain(|_| {
            old += 1;
            remap.new_handle(VertexId::new(old - 1)).is_some()
        });
        remap
    }

    /// Bytes held by topology and positions, capacity slack included.
    #[must_use]
    pub fn heap_bytes(&self) -> usize {
        self.topology.heap_bytes() + size_of::<DVec3>() * self.positions.capacity()
    }
}
