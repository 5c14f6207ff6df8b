//! Unit normals of faces and vertices.

use glam::DVec3;

use crate::attribute::{FaceMap, VertexMap};
use crate::measure::any_size::{triangle_normal, unit_sized};
use crate::mesh::TriMesh;
use crate::parallel;
use crate::topology::handle::{FaceId, HalfEdgeId, Handle, VertexId};

/// The angle between two vectors, in radians, from 0 to pi; 0 when one of them is zero.
///
/// The arc tangent of cross and dot product keeps full relative precision for small angles, where
/// the arc cosine loses all of it.
#[inline]
#[must_use]
pub fn angle_between(a: DVec3, b: DVec3) -> f64 {
    let (sine, cosine) = (a.cross(b).length(), a.dot(b));
    let size = sine.max(cosine.abs());
    if size > 1e-140 && size < 1e140 { sine.atan2(cosine) } else { far_angle(a, b) }
}

/// The angle between two vectors whose product may overflow or vanish.
#[cold]
fn far_angle(a: DVec3, b: DVec3) -> f64 {
    let ([a], [b]) = (unit_sized([a]), unit_sized([b]));
    a.cross(b).length().atan2(a.dot(b))
}

impl TriMesh {
    /// The unit normal of a face; zero for a face without area. Seen against the normal, the vertices are
    /// counter-clockwise.
    #[inline]
    #[must_use]
    pub fn face_normal(&self, face: FaceId) -> DVec3 {
        triangle_normal(self.triangle(face))
    }

    /// The unit normals of all faces; zero for faces without area and for removed ones.
    #[must_use]
    pub fn face_normals(&self) -> FaceMap<DVec3> {
        FaceMap::from_vec(parallel::collect(self.topology().face_capacity(), |index| {
            let face = FaceId::from_index(index);
            if self.topology().contains_face(face) { self.face_normal(face) } else { DVec3::ZERO }
        }))
    }

    /// The interior angle of a face at the origin of one of its half-edges, in radians; 0 where a side has no
    /// length. For an exterior half-edge: the angle between it and the vector to the end of the next half-edge.
    #[inline]
    #[must_use]
    pub fn corner_angle(&self, half_edge: HalfEdgeId) -> f64 {
        let topology = self.topology();
        let origin = self.position(topology.origin(half_edge));
        let along = self.position(topology.target(half_edge)) - origin;
        let back = self.position(topology.target(topology.next(half_edge))) - origin;
        angle_between(along, back)
    }

    /// The unit normal of a vertex: the face normals weighted by the angles of the faces at the vertex (Thürmer and
    /// Wüthrich 1998), so that it does not depend on the triangulation around the vertex. Zero for isolated vertices.
    #[must_use]
    pub fn vertex_normal(&self, vertex: VertexId) -> DVec3 {
        let topology = self.topology();
        let weighted = topology.outgoing(vertex).filter_map(|h| {
            topology.face(h).map(|face| self.corner_angle(h) * self.face_normal(face))
        });
        weighted.sum::<DVec3>().normalize_or_zero()
    }

    /// The angle-weighted unit normals of all vertices; see [`TriMesh::vertex_normal`].
    #[must_use]
    pub fn vertex_normals(&self) -> VertexMap<DVec3> {
        VertexMap::from_vec(parallel::collect(self.topology().vertex_capacity(), |index| {
            self.vertex_normal(VertexId::from_index(index))
        }))
    }
}
