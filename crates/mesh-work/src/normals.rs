//! Normals of a simplified mesh: the normals of the file where they still fit.

use glam::DVec3;
use mesh_core::{HalfEdgeId, HalfEdgeMap, TriMesh, UnitScale, VertexId, angle_between};

/// Replaces normals that differ by more than `crease` from the surface, as on the wrong side of a crease. The new
/// normal is the mean over the faces around the vertex that are not across an edge sharper than `crease`. `normals` are
/// by face and corner.
pub(crate) fn settle_normals(normals: &mut [[[f32; 3]; 3]], mesh: &TriMesh, crease: f64) {
    // Sums of areas are no numbers at every size.
    if let Ok(Some(scale)) = UnitScale::of(mesh)
        && let Ok(scaled) = scale.mesh(mesh)
    {
        return settle_normals(normals, &scaled, crease);
    }
    let topology = mesh.topology();
    let mut smooth = topology.half_edge_map(DVec3::ZERO);
    for v in topology.vertices() {
        smooth_corners(mesh, v, crease, &mut smooth);
    }
    for (face, corners) in topology.faces().zip(normals) {
        for (h, normal) in topology.face_half_edges(face).into_iter().zip(corners) {
            let fits = |n: DVec3| n.is_finite() && angle_between(n, smooth[h]) <= crease;
            if !fits(DVec3::from(normal.map(f64::from))) {
                *normal = smooth[h].normalize_or(DVec3::Z).as_vec3().to_array();
            }
        }
    }
}

/// Sums, for each corner at a vertex, the vector areas of the faces that can be reached around the vertex without
/// crossing a crease.
fn smooth_corners(mesh: &TriMesh, v: VertexId, crease: f64, smooth: &mut HalfEdgeMap<DVec3>) {
    let topology = mesh.topology();
    let corners: Vec<HalfEdgeId> =
        topology.outgoing(v).filter(|&h| !topology.is_exterior(h)).collect();
    let normal = |h: HalfEdgeId| topology.face(h).map_or(DVec3::ZERO, |f| mesh.face_cross(f));
    // Between a corner and the previous one, cyclically.
    let breaks = |i: usize| {
        let before = corners[(i + corners.len() - 1) % corners.len()];
        let gap = i == 0 && topology.is_boundary_vertex(v);
        gap || angle_between(normal(before), normal(corners[i])) > crease
    };
    let start = (0..corners.len()).find(|&i| breaks(i)).unwrap_or(0);
    let order = |k: usize| (start + k) % corners.len();
    let mut first = 0;
    while first < corners.len() {
        let ends = (first + 1..corners.len()).find(|&k| breaks(order(k)));
        let end = ends.unwrap_or(corners.len());
        let sum: DVec3 = (first..end).map(|k| normal(corners[order(k)])).sum();
        for k in first..end {
            smooth[corners[order(k)]] = sum;
        }
        first = end;
    }
}
