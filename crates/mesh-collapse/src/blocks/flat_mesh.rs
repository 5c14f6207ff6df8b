//! A mesh between two passes, as flat arrays.

use std::borrow::Cow;

use glam::DVec3;
use mesh_core::{FaceId, HalfEdgeId, Handle, Topology, TriMesh, VertexId, as_u32, parallel};

use crate::blocks::rank_order::in_order;
use crate::geometry::quadric::Quadric;

/// Vertices and triangles without gaps, with their ids in the original. Before the first pass it refers to the mesh
/// itself, including the gaps of removed elements.
#[derive(Clone, Debug)]
pub struct FlatMesh<'a> {
    /// The mesh before any collapse. While it is set, everything except the positions is empty.
    pub(super) whole: Option<&'a TriMesh>,
    pub(super) positions: Cow<'a, [DVec3]>,
    /// The accumulated quadric of each vertex, about its position.
    pub(super) quadrics: Vec<Quadric>,
    /// The id of each vertex in the original.
    pub(super) vertex_ids: Vec<u32>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The id of each face in the original.
    pub(super) face_ids: Vec<u32>,
    /// The half-edges of the original at the sides of each face, if collapses are recorded.
    pub(super) half_edges: Vec<[u32; 3]>,
    /// The number of held vertices, which are the last ones. They belong elsewhere; neither they nor their neighbours
    /// move.
    pub(super) held: usize,
}

impl<'a> FlatMesh<'a> {
    /// A mesh before its first pass.
    #[must_use]
    pub fn new(mesh: &'a TriMesh) -> Self {
        Self {
            whole: Some(mesh),
            positions: Cow::Borrowed(mesh.positions()),
            quadrics: Vec::new(),
            vertex_ids: Vec::new(),
            triangles: Vec::new(),
            face_ids: Vec::new(),
            half_edges: Vec::new(),
            held: 0,
        }
    }

    /// The number of vertices, counting gaps.
    pub(super) fn vertex_capacity(&self) -> usize {
        self.positions.len()
    }

    /// The number of faces, counting gaps.
    pub(super) fn face_capacity(&self) -> usize {
        self.whole.map_or(self.triangles.len(), |mesh| mesh.topology().face_capacity())
    }

    /// The number of faces.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.whole.map_or(self.triangles.len(), |mesh| mesh.topology().face_count())
    }

    /// The vertices.
    pub(super) fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        let is_there = |&v: &u32| {
            self.whole.is_none_or(|mesh| mesh.topology().contains_vertex(VertexId::new(v)))
        };
        (0..as_u32(self.vertex_capacity())).filter(is_there)
    }

    /// The corners of a face, if it is there.
    #[inline]
    pub(super) fn triangle(&self, face: usize) -> Option<[u32; 3]> {
        let Some(mesh) = self.whole else { return Some(self.triangles[face]) };
        let face = FaceId::from_index(face);
        let is_there = mesh.topology().contains_face(face);
        is_there.then(|| {
            let [a, b, c] = mesh.topology().face_vertices(face);
            [a.get(), b.get(), c.get()]
        })
    }

    /// The half-edges of the original at the sides of a face.
    #[inline]
    pub(super) fn half_edges(&self, face: usize) -> [u32; 3] {
        match self.whole {
            Some(mesh) => {
                mesh.topology().face_half_edges(FaceId::from_index(face)).map(HalfEdgeId::get)
            }
            None => self.half_edges.get(face).copied().unwrap_or_default(),
        }
    }

    pub(super) fn vertex_id(&self, v: u32) -> u32 {
        if self.whole.is_some() { v } else { self.vertex_ids[v as usize] }
    }

    pub(super) fn face_id(&self, face: usize) -> u32 {
        if self.whole.is_some() { as_u32(face) } else { self.face_ids[face] }
    }

    /// The vertices that may be collapsed: all except the held ones.
    pub(super) fn own_vertices(&self) -> impl Iterator<Item = u32> + '_ {
        self.vertices().take(self.vertex_capacity() - self.held)
    }

    /// The flat mesh as a mesh, with vertices and faces in the order of the original.
    #[must_use]
    pub fn to_mesh(&self) -> TriMesh {
        self.to_ordered_mesh().mesh
    }

    pub(super) fn to_ordered_mesh(&self) -> Ordered {
        let (vertices, faces) = parallel::both(
            || in_order(&Vec::from_iter(self.vertices().map(|v| (self.vertex_id(v), v)))),
            || {
                let faces = (0..self.face_capacity()).filter(|&f| self.triangle(f).is_some());
                in_order(&Vec::from_iter(faces.map(|f| (self.face_id(f), as_u32(f)))))
            },
        );
        let mut number = vec![u32::MAX; self.vertex_capacity()];
        for (new, &(_, v)) in vertices.iter().enumerate() {
            number[v as usize] = as_u32(new);
        }
        let positions =
            parallel::collect(vertices.len(), |v| self.positions[vertices[v].1 as usize]);
        let triangles = parallel::collect(faces.len(), |f| {
            self.triangle(faces[f].1 as usize).unwrap_or_default().map(|v| number[v as usize])
        });
        #[expect(clippy::expect_used, reason = "collapses that are legal leave a manifold")]
        let mesh = TriMesh::from_triangles(&positions, &triangles).expect("a manifold");
        Ordered { mesh, vertices, faces }
    }
}

/// A part of a mesh that is collapsed separately, as arrays. A [`FlatMesh`] is made from it and can be turned back into
/// it.
///
/// It contains every face with a corner among its own vertices. Its other vertices, which come after its own, belong to
/// other parts and are corners of the faces only. Neither the other vertices nor their neighbours move, so the parts do
/// not affect each other.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Fragment {
    /// Positions of the vertices, the own ones first.
    pub positions: Vec<DVec3>,
    /// Number of own vertices.
    pub own: usize,
    /// The accumulated quadric of each own vertex, about its position; empty before the first pass.
    pub quadrics: Vec<Quadric>,
    /// The faces, by vertices.
    pub triangles: Vec<[u32; 3]>,
    /// For a part made from another one, the index of each vertex there.
    pub vertex_ids: Vec<u32>,
}

impl FlatMesh<'static> {
    /// A part of a mesh before a pass. Its vertex ids are indices into this part; earlier ids are dropped.
    ///
    /// # Panics
    /// A triangle has an invalid vertex, or the number of quadrics is neither zero nor the number of own vertices.
    #[must_use]
    pub fn from_fragment(fragment: Fragment) -> Self {
        let Fragment { positions, own, mut quadrics, triangles, vertex_ids: _ } = fragment;
        let count = positions.len();
        assert!(quadrics.is_empty() || quadrics.len() == own, "a quadric for each own vertex");
        let is_there = |&v: &u32| (v as usize) < count;
        assert!(triangles.as_flattened().iter().all(is_there), "triangles of vertices");
        if !quadrics.is_empty() {
            quadrics.resize(count, Quadric::default());
        }
        Self {
            whole: None,
            positions: Cow::Owned(positions),
            quadrics,
            vertex_ids: (0..as_u32(count)).collect(),
            face_ids: (0..as_u32(triangles.len())).collect(),
            triangles,
            half_edges: Vec::new(),
            held: count - own,
        }
    }

    /// Numbers the sides of the faces as the mesh of this flat mesh does, so that collapses can be recorded.
    pub fn number_half_edges(&mut self) {
        #[expect(clippy::expect_used, reason = "collapses that are legal leave a manifold")]
        let topology = Topology::from_triangles(self.positions.len(), &self.triangles)
            .expect("an oriented manifold");
        let sides = |face| topology.face_half_edges(face).map(HalfEdgeId::get);
        self.half_edges = topology.faces().map(sides).collect();
    }

    /// The flat mesh as arrays. The vertex ids are indices into the fragment that the first flat mesh was made from.
    #[must_use]
    pub fn into_fragment(self) -> Fragment {
        let Self { positions, mut quadrics, vertex_ids, triangles, held, .. } = self;
        let positions = positions.into_owned();
        let own = positions.len() - held;
        quadrics.truncate(own);
        Fragment { positions, own, quadrics, triangles, vertex_ids }
    }
}

/// A flat mesh as a mesh, with pairs of the original id and the flat-mesh id of its vertices and faces.
pub(super) struct Ordered {
    pub(super) mesh: TriMesh,
    pub(super) vertices: Vec<(u32, u32)>,
    pub(super) faces: Vec<(u32, u32)>,
}
