//! Tests for self-intersections of the mesh, before and after a flip.

use mesh_core::{FaceId, FaceTree, TriMesh, TriangleBounds, triangles_cross};

use crate::quad::Quad;

/// A face that one of the two new triangles of a flip would cross. If the new triangles would cross each
/// other, one of the faces of the edge.
pub(crate) fn crossed_by_flip(tree: &FaceTree, mesh: &TriMesh, quad: &Quad) -> Option<FaceId> {
    let topology = mesh.topology();
    let own = topology.edge_faces(quad.edge);
    let new = quad.flipped_triangles().map(|t| (t, t.map(|v| mesh.position(v))));
    if triangles_cross(new[0], new[1]) {
        return own[0];
    }
    new.into_iter().find_map(|triangle| {
        tree.find_crossing(mesh, &TriangleBounds::new(triangle), |face| {
            let other = (topology.face_vertices(face), mesh.triangle(face));
            !own.contains(&Some(face)) && triangles_cross(triangle, other)
        })
    })
}

/// Whether a face crosses another face.
pub(crate) fn face_crosses(tree: &FaceTree, mesh: &TriMesh, face: FaceId) -> bool {
    let triangle = |face: FaceId| (mesh.topology().face_vertices(face), mesh.triangle(face));
    let own = triangle(face);
    let crosses = |other: FaceId| other != face && triangles_cross(own, triangle(other));
    tree.find_crossing(mesh, &TriangleBounds::new(own), crosses).is_some()
}
