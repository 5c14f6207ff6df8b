//! Moving vertices as far as their faces allow.

use glam::DVec3;
use mesh_collapse::NewIntersections;
use mesh_core::{TriMesh, VertexId};

use crate::fit::constraints::FitConstraints;
use crate::fit::freedom::Freedom;

/// The smallest cosine between the normals of faces before and after a flip or a move.
const MIN_COSINE: f64 = 0.5;

/// Whether a face with the vector area `new` is turned by less than sixty degrees from `old`.
pub(super) fn keeps_side(new: DVec3, old: DVec3) -> bool {
    new.dot(old) > MIN_COSINE * new.length() * old.length()
}

/// Moves each vertex by its displacement, or by half or a quarter of it, or not at all, so that no
/// face turns too far.
pub(super) fn move_vertices(
    mesh: &mut TriMesh,
    displacements: &[(VertexId, DVec3)],
    freedoms: &[Freedom],
    constraints: &FitConstraints,
    mut found: Option<&mut NewIntersections>,
) {
    let mut before: Vec<DVec3> = Vec::new();
    for &(v, displacement) in displacements {
        if displacement == DVec3::ZERO || !displacement.is_finite() {
            continue;
        }
        let from = mesh.position(v);
        let curve = freedoms[v.index()].curve(constraints);
        let displacement = match curve {
            Some(_) => displacement.clamp_length_max(0.5 * shortest_edge(mesh, v)),
            None => displacement,
        };
        before.clear();
        before.extend(mesh.topology().faces_of_vertex(v).map(|f| mesh.face_cross(f)));
        for part in [1.0, 0.5, 0.25] {
            let free = from + part * displacement;
            // As far from the curve as it was.
            let to = curve.map_or(free, |c| from + (c.closest(free) - c.closest(from)));
            let crosses = found.as_ref().is_some_and(|found| found.would_arise_at(mesh, v, to));
            if !crosses && try_move(mesh, v, to, &before) {
                if let Some(found) = &mut found {
                    found.update(mesh, mesh.topology().faces_of_vertex(v));
                }
                break;
            }
        }
    }
}

fn shortest_edge(mesh: &TriMesh, v: VertexId) -> f64 {
    let lengths = mesh.topology().one_ring(v).map(|w| mesh.position(w).distance(mesh.position(v)));
    lengths.fold(f64::INFINITY, f64::min)
}

/// Moves a vertex unless that turns a face too far from its normal before.
pub(crate) fn try_move(mesh: &mut TriMesh, v: VertexId, to: DVec3, before: &[DVec3]) -> bool {
    let from = mesh.position(v);
    mesh.positions_mut()[v.index()] = to;
    let faces = mesh.topology().faces_of_vertex(v);
    let fits = faces.zip(before).all(|(f, old)| keeps_side(mesh.face_cross(f), *old));
    if !fits {
        mesh.positions_mut()[v.index()] = from;
    }
    fits
}
