//! Signs of principal directions that agree along a mesh.
//!
//! A principal direction is a line: its sign is arbitrary. Lines of curvature can be followed, and directions
//! interpolated, if the signs of neighbours agree. From a first vertex of each connected component, each
//! neighbour gets the sign that turns its direction least against the direction it is reached from. The directions are
//! compared after parallel transport: the turn by which one normal becomes the other.
//!
//! Around umbilics of odd index no signs agree everywhere, so on a closed curve around one the signs of one edge
//! differ.

use glam::{DQuat, DVec3};
use mesh_core::{TriMesh, VertexId, VertexMap};

use crate::principal::PrincipalFrame;

/// Turns frames by 180° about their normals where the larger principal direction of neighbours is opposite.
/// Sequential, in linear time. Vertices without a frame separate components.
///
/// ```
/// use dcurv::{JetFitOptions, align_directions, fitted_curvatures};
/// use mesh_core::TriMesh;
/// use mesh_shapes::Torus;
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let torus = TriMesh::from_soup(&Torus { major: 2.0, minor: 0.5 }.mesh(40, 20)?)?;
/// let mut frames = fitted_curvatures(&torus, &JetFitOptions::default()).map(|fit| fit.map(|fit| fit.frame));
/// align_directions(&torus, &mut frames);
/// for edge in torus.topology().edges() {
///     let [a, b] = torus.topology().edge_vertices(edge).map(|v| frames[v].map(|f| f.direction_max));
///     assert!(a.ok_or("no frame")?.dot(b.ok_or("no frame")?) > 0.0);
/// }
/// # Ok(())
/// # }
/// ```
pub fn align_directions(mesh: &TriMesh, frames: &mut VertexMap<Option<PrincipalFrame>>) {
    let topology = mesh.topology();
    let mut is_done = topology.vertex_map(false);
    let mut open: Vec<VertexId> = Vec::new();
    for first in topology.vertices() {
        if is_done[first] || frames[first].is_none() {
            continue;
        }
        is_done[first] = true;
        open.push(first);
        // In the order of discovery, so that signs spread evenly.
        let mut next = 0;
        while let Some(&vertex) = open.get(next) {
            next += 1;
            let Some(from) = frames[vertex] else { continue };
            for neighbour in topology.one_ring(vertex) {
                let Some(frame) = frames[neighbour].as_mut().filter(|_| !is_done[neighbour]) else {
                    continue;
                };
                is_done[neighbour] = true;
                if transported(from.direction_max, from.normal, frame.normal)
                    .dot(frame.direction_max)
                    < 0.0
                {
                    frame.direction_max = -frame.direction_max;
                    frame.direction_min = -frame.direction_min;
                }
                open.push(neighbour);
            }
        }
        open.clear();
    }
}

/// A tangent after the smallest turn that takes one normal to another.
fn transported(tangent: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    DQuat::from_rotation_arc(from, to) * tangent
}
