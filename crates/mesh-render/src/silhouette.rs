//! Outlines: the silhouette, the boundary and sharp edges of a surface.

use core::f64::consts::PI;

use glam::DVec3;
use mesh_core::{TriMesh, VertexMap, angle_between};

/// The pieces of the outline seen from a direction.
///
/// With vertex normals, the surface turns away where the interpolated normal is at right angles to the direction, which
/// is inside of faces (Hertzmann and Zorin 2000). Without, it turns away at the edges between a face towards the camera
/// and a face away from it.
pub(crate) fn outline(
    mesh: &TriMesh,
    toward: DVec3,
    vertex_normals: Option<&VertexMap<DVec3>>,
    crease: Option<f64>,
) -> Vec<[DVec3; 2]> {
    let topology = mesh.topology();
    let face_normals = mesh.face_normals();
    let mut pieces = Vec::new();
    for edge in topology.edges() {
        let is_drawn = match topology.edge_faces(edge) {
            [Some(a), Some(b)] => {
                let [a, b] = [face_normals[a], face_normals[b]];
                let is_sharp = crease.is_some_and(|crease| angle_between(a, b) > crease.min(PI));
                let turns = (a.dot(toward) < 0.0) != (b.dot(toward) < 0.0);
                is_sharp || (turns && vertex_normals.is_none())
            }
            _ => true,
        };
        if is_drawn {
            pieces.push(topology.edge_vertices(edge).map(|v| mesh.position(v)));
        }
    }
    if let Some(normals) = vertex_normals {
        for face in topology.faces() {
            let corners = topology.face_vertices(face);
            let facing = corners.map(|v| normals[v].dot(toward));
            pieces.extend(zero_line(corners.map(|v| mesh.position(v)), facing));
        }
    }
    pieces
}

/// The piece of a triangle where a linear function with these values at the corners is zero.
fn zero_line(points: [DVec3; 3], values: [f64; 3]) -> Option<[DVec3; 2]> {
    let changes = |&(i, j): &(usize, usize)| (values[i] < 0.0) != (values[j] < 0.0);
    let zero =
        |(i, j): (usize, usize)| points[i].lerp(points[j], values[i] / (values[i] - values[j]));
    let mut ends = [(0, 1), (1, 2), (2, 0)].into_iter().filter(changes).map(zero);
    Some([ends.next()?, ends.next()?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_shapes::Sphere;

    /// The outline of a ball is a great circle from any direction.
    #[test]
    fn the_outline_of_a_sphere_is_as_long_as_its_equator() {
        let soup = Sphere { radius: 2.0 }.icosphere(4).unwrap();
        let mesh = TriMesh::from_soup(&soup).unwrap();
        let length =
            |pieces: &[[DVec3; 2]]| pieces.iter().map(|[a, b]| a.distance(*b)).sum::<f64>();
        let toward = DVec3::new(0.3, 0.5, 0.8).normalize();
        let smooth = outline(&mesh, toward, Some(&mesh.vertex_normals()), None);
        let equator = 4.0 * PI;
        assert!((length(&smooth) / equator - 1.0).abs() < 2e-3, "{}", length(&smooth));
        // Along edges, the outline zigzags.
        let ratio = length(&outline(&mesh, toward, None, None)) / equator;
        assert!((1.0..1.5).contains(&ratio), "{ratio}");
        let all = outline(&mesh, toward, None, Some(0.0));
        assert_eq!(all.len(), mesh.topology().edge_count());
    }
}
