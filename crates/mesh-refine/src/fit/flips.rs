//! Edge flips that reduce the distance to the samples of the original, measured by a mean of some order.
//!
//! All edges are evaluated in parallel. Edges next to a flip are evaluated again when their turn comes, so the result
//! equals a sequential run.

use mesh_collapse::{ChangedFace, NewIntersections};
use mesh_core::edit::LegalFlip;
use mesh_core::{EdgeId, FaceId, Handle, TriMesh, parallel};
use mesh_metric::closest_on_triangle;

use crate::face_quality::{keeps_height, keeps_side};
use crate::fit::constraints::FitConstraints;
use crate::fit::moves::cross;
use crate::fit::pairs::Pairs;
use crate::norm::Power;

/// Flips every edge whose flip lowers the sum of the powers of the distances of the targets of its two faces.
pub(super) fn flip_edges(
    mesh: &mut TriMesh,
    paired: &mut Pairs<'_>,
    constraints: &FitConstraints,
    power: Power,
    mut found: Option<&mut NewIntersections>,
) -> usize {
    let mut sums: Vec<f64> = parallel::collect(mesh.topology().face_capacity(), |index| {
        paired.sum_of(FaceId::from_index(index), power)
    });
    let may_flip = |mesh: &TriMesh, edge: EdgeId| {
        !constraints.is_held(edge)
            && mesh.topology().contains_edge(edge)
            && constraints.limits.allow_flip(mesh, edge)
    };
    let helps: Vec<bool> = parallel::collect(mesh.topology().edge_capacity(), |index| {
        let edge = EdgeId::from_index(index);
        may_flip(mesh, edge) && flip_is_closer(mesh, paired, &sums, power, edge)
    });
    let mut is_new = vec![false; mesh.topology().face_capacity()];
    let mut scratch = Vec::new();
    let mut flips = 0;
    for (index, helped) in helps.into_iter().enumerate() {
        let edge = EdgeId::from_index(index);
        if !mesh.topology().contains_edge(edge) {
            continue;
        }
        let mut faces = mesh.topology().edge_faces(edge).into_iter().flatten();
        let helps = match faces.any(|face| is_new[face.index()]) {
            true => may_flip(mesh, edge) && flip_is_closer(mesh, paired, &sums, power, edge),
            false => helped,
        };
        if !helps {
            continue;
        }
        let Ok(legal) = mesh.topology().check_flip(edge) else { continue };
        // Flips elsewhere have changed the valences.
        if !constraints.limits.allow_flip(mesh, edge) {
            continue;
        }
        if found.as_ref().is_some_and(|found| flip_crosses(mesh, found, &legal)) {
            continue;
        }
        mesh.flip(legal);
        flips += 1;
        if let Some(found) = &mut found {
            found.update(mesh, mesh.topology().edge_faces(edge).into_iter().flatten());
        }
        if let [Some(left), Some(right)] = mesh.topology().edge_faces(edge) {
            paired.redistribute(mesh, [left, right], &mut scratch);
            for face in [left, right] {
                is_new[face.index()] = true;
                sums[face.index()] = paired.sum_of(face, power);
            }
        }
    }
    flips
}

/// Whether a flip lowers the sum; `sums` are the current sums of all faces.
fn flip_is_closer(
    mesh: &TriMesh,
    paired: &Pairs<'_>,
    sums: &[f64],
    power: Power,
    edge: EdgeId,
) -> bool {
    let topology = mesh.topology();
    if !topology.contains_edge(edge) {
        return false;
    }
    let [h, twin] = edge.half_edges();
    let (Some(c), Some(d)) = (topology.apex(h), topology.apex(twin)) else { return false };
    let [a, b] = topology.edge_vertices(edge);
    let [a, b, c, d] = [mesh.position(a), mesh.position(b), mesh.position(c), mesh.position(d)];
    let (old, new) = ([[a, b, c], [b, a, d]], [[c, a, d], [d, b, c]]);
    let normal = cross(old[0]) + cross(old[1]);
    if !new.into_iter().all(|triangle| keeps_side(cross(triangle), normal))
        || !keeps_height(new, old)
    {
        return false;
    }
    let faces = || topology.edge_faces(edge).into_iter().flatten();
    let before: f64 = faces().map(|face| sums[face.index()]).sum();
    let limit = before * (1.0 - 1e-9);
    let points =
        || faces().flat_map(|face| paired.of_face(face)).map(|(point, _, weight)| (point, weight));
    let planes = new.map(|triangle| (triangle[0], cross(triangle).normalize_or_zero()));
    let to_planes = points().map(|(point, weight)| {
        let [first, second] = planes.map(|(on, normal)| normal.dot(point - on));
        weight * power.of((first * first).min(second * second))
    });
    let to_triangles = points().map(|(point, weight)| {
        let [first, second] = new.each_ref().map(|t| closest_on_triangle(point, t));
        weight * power.of(first.length_squared().min(second.length_squared()))
    });
    // No triangle is closer than its plane, and the distance to the plane is cheaper to compute.
    is_below(limit, to_planes) && is_below(limit, to_triangles)
}

/// Whether the sum of some non-negative numbers is less than a limit. Most flips raise the sum, and the first few
/// targets show that.
#[inline]
fn is_below(limit: f64, numbers: impl Iterator<Item = f64>) -> bool {
    let mut left = limit;
    for number in numbers {
        left -= number;
        if left <= 0.0 || left.is_nan() {
            return false;
        }
    }
    limit > 0.0
}

/// Whether a flip makes faces intersect that did not before.
pub(crate) fn flip_crosses(mesh: &TriMesh, found: &NewIntersections, flip: &LegalFlip) -> bool {
    let [a, b, c, d] = flip.quad();
    let faces = mesh.topology().edge_faces(flip.edge()).into_iter().flatten();
    let changed: Vec<ChangedFace> = faces
        .zip([[c, a, d], [d, b, c]])
        .map(|(face, vertices)| {
            let triangle = (vertices, vertices.map(|v| mesh.position(v)));
            ChangedFace { face, triangle }
        })
        .collect();
    found.would_arise(mesh, &changed, &[])
}
