//! Faces that a chain of collapses has turned over.
//!
//! A collapse turns no face far, but a chain of collapses can turn a face over. Refinement finds such faces by distances
//! from the whole input. Without refinement this would take longer than the collapses. A face that is turned over has an
//! edge at which the surface folds back, and the faces of the input that were merged around its corners have the opposite
//! normal on average. Both are found in one pass, and only the part of the input around such faces is searched.

use glam::DVec3;
use mesh_collapse::Level;
use mesh_core::{FaceId, TriMesh, VertexId};
use mesh_metric::Surface;
use mesh_refine::faces_at_folds;

/// The rings around the corners of faces at folds that are near.
const RINGS: usize = 3;

/// The part of the input around the folds of a level; `None` if no face is turned over.
pub(crate) fn original_at_folds(input: &TriMesh, level: &Level) -> Option<Surface> {
    let folded = faces_at_folds(&level.mesh);
    let topology = level.mesh.topology();
    // Twice the area vector of the input around each face at a fold.
    let mut around = topology.face_map(None);
    let mut is_near = topology.vertex_map(false);
    let mut near: Vec<VertexId> = Vec::new();
    for &face in &folded {
        around[face] = Some(DVec3::ZERO);
        near.extend(topology.face_vertices(face));
    }
    // `unfold` looks at the two-rings of the faces.
    for _ in 0..=RINGS {
        near.iter().for_each(|&v| is_near[v] = true);
        let ring = near.iter().flat_map(|&v| topology.one_ring(v));
        near = ring.filter(|&w| !is_near[w]).collect();
        near.sort_unstable();
        near.dedup();
    }
    if folded.is_empty() {
        return None;
    }
    let image = |v: VertexId| level.vertex_map.get(v).copied().flatten();
    let mut triangles = Vec::new();
    for face in input.topology().faces() {
        let vertices = input.topology().face_vertices(face);
        let images = vertices.map(image);
        let mut near = images.into_iter().flatten().filter(|&v| is_near[v]).peekable();
        if near.peek().is_none() {
            continue;
        }
        triangles.push(vertices.map(VertexId::get));
        let normal = input.face_cross(face);
        for other in near.flat_map(|v| topology.faces_of_vertex(v)) {
            around[other] = around[other].map(|sum: DVec3| sum + normal);
        }
    }
    let is_turned =
        |&face: &FaceId| around[face].is_some_and(|sum| sum.dot(level.mesh.face_cross(face)) < 0.0);
    folded
        .iter()
        .any(is_turned)
        .then(|| Surface::from_triangles(input.positions(), &triangles).ok())
        .flatten()
}
