//! Moves of vertices, limited by their faces.

use glam::DVec3;
use mesh_collapse::{FaceLimits, NewIntersections};
use mesh_core::{TriMesh, VertexId};

use crate::face_quality::{keeps_height, keeps_side};
use crate::fit::constraints::FitConstraints;
use crate::fit::freedom::Freedom;

/// Moves each vertex by its displacement, by half or a quarter of it, or not at all, so that no face turns too far or
/// becomes a sliver, and the limits hold.
pub(super) fn move_vertices(
    mesh: &mut TriMesh,
    displacements: &[(VertexId, DVec3)],
    freedoms: &[Freedom],
    constraints: &FitConstraints,
    mut found: Option<&mut NewIntersections>,
) {
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
        for part in [1.0, 0.5, 0.25] {
            let free = from + part * displacement;
            // The vertex keeps its distance to the curve.
            let to = curve.map_or(free, |c| from + (c.closest(free) - c.closest(from)));
            let crosses = found.as_ref().is_some_and(|found| found.would_arise_at(mesh, v, to));
            if !crosses && try_move(mesh, &constraints.limits, v, to) {
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

/// Moves a vertex if [`can_move`] allows it.
pub(crate) fn try_move(mesh: &mut TriMesh, limits: &FaceLimits, v: VertexId, to: DVec3) -> bool {
    let fits = can_move(mesh, limits, v, to);
    if fits {
        mesh.positions_mut()[v.index()] = to;
    }
    fits
}

/// Whether no face turns too far or becomes a sliver when a vertex moves, and the limits hold.
pub(crate) fn can_move(mesh: &TriMesh, limits: &FaceLimits, v: VertexId, to: DVec3) -> bool {
    let topology = mesh.topology();
    limits.allow_move(mesh, v, to)
        && topology.faces_of_vertex(v).all(|face| {
            let [p, q, r] = topology.face_vertices(face);
            let old = [mesh.position(p), mesh.position(q), mesh.position(r)];
            let at = |corner: VertexId, old: DVec3| if corner == v { to } else { old };
            let new = [at(p, old[0]), at(q, old[1]), at(r, old[2])];
            keeps_side(cross(new), cross(old)) && keeps_height([new], [old])
        })
}

/// Twice the vector area of a triangle.
pub(crate) fn cross([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}
