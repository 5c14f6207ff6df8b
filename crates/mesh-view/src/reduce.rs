//! Simplification of meshes that are too large for a page.
//!
//! All vertices in a grid cell are replaced by the vertex nearest to their mean (Rossignac and Borrel 1993,
//! Multi-resolution 3D approximations for rendering complex scenes). The method is coarse, but it works for any
//! triangle soup in linear time, and the remaining vertices and faces keep their values and numbers.

use glam::DVec3;
use mesh_core::as_u32;

/// A simplified mesh.
pub(crate) struct Reduced {
    /// The remaining vertices, in ascending order.
    pub(crate) vertices: Vec<u32>,
    /// The remaining faces, in ascending order.
    pub(crate) faces: Vec<u32>,
    /// The corners of these faces, as indices into `vertices`.
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// The mesh with at most `limit` faces, or about the number that a coarse grid leaves.
pub(crate) fn reduce(positions: &[DVec3], triangles: &[[u32; 3]], limit: usize) -> Reduced {
    let used = || triangles.as_flattened().iter().map(|&v| positions[v as usize]);
    let low = used().fold(DVec3::INFINITY, DVec3::min);
    let extent = (used().fold(DVec3::NEG_INFINITY, DVec3::max) - low).max(DVec3::ZERO);
    let longest = extent.max_element().max(f64::MIN_POSITIVE);
    // The number of cells of a surface grows with the square of the number of cells along a side.
    let (mut coarse, mut fine) = (1_u32, 1 << 12);
    let mut best = None;
    while fine - coarse > 1 + coarse / 16 {
        let middle = coarse.midpoint(fine);
        let reduced = cluster(positions, triangles, low, f64::from(middle) / longest);
        if reduced.faces.len() <= limit {
            coarse = middle;
            best = Some(reduced);
        } else {
            fine = middle;
        }
    }
    best.unwrap_or_else(|| cluster(positions, triangles, low, f64::from(coarse) / longest))
}

fn cluster(positions: &[DVec3], triangles: &[[u32; 3]], low: DVec3, density: f64) -> Reduced {
    let cell = |v: u32| -> u64 {
        let place = (positions[v as usize] - low) * density;
        let [x, y, z] = place.to_array().map(|t| t as u64 & 0x1f_ffff);
        (z << 42) | (y << 21) | x
    };
    let mut members: Vec<u32> = triangles.as_flattened().to_vec();
    members.sort_unstable();
    members.dedup();
    let mut of_cell: Vec<(u64, u32)> = members.into_iter().map(|v| (cell(v), v)).collect();
    of_cell.sort_unstable();
    let mut chosen = vec![u32::MAX; positions.len()];
    for group in of_cell.chunk_by(|a, b| a.0 == b.0) {
        let point = |&(_, v): &(u64, u32)| positions[v as usize];
        let mean = group.iter().map(point).sum::<DVec3>() / group.len() as f64;
        let distance = |pair: &(u64, u32)| point(pair).distance_squared(mean);
        let nearest = group.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        for &(_, v) in group {
            chosen[v as usize] = nearest.map_or(v, |n| n.1);
        }
    }
    let kept = triangles.iter().enumerate().filter_map(|(face, corners)| {
        let [a, b, c] = corners.map(|v| chosen[v as usize]);
        (a != b && b != c && c != a).then_some((as_u32(face), [a, b, c]))
    });
    // Of faces that have become equal, only one is kept.
    let mut keyed: Vec<([u32; 3], u32, [u32; 3])> = kept
        .map(|(face, corners)| {
            let mut key = corners;
            key.sort_unstable();
            (key, face, corners)
        })
        .collect();
    keyed.sort_unstable();
    keyed.dedup_by_key(|entry| entry.0);
    keyed.sort_unstable_by_key(|entry| entry.1);
    let faces: Vec<u32> = keyed.iter().map(|entry| entry.1).collect();
    let mut vertices: Vec<u32> = keyed.iter().flat_map(|entry| entry.2).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut place = vec![0; positions.len()];
    for (at, &v) in vertices.iter().enumerate() {
        place[v as usize] = as_u32(at);
    }
    let triangles = keyed.iter().map(|entry| entry.2.map(|v| place[v as usize])).collect();
    Reduced { vertices, faces, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::TriMesh;
    use mesh_shapes::Sphere;

    #[test]
    fn a_sphere_stays_a_sphere_below_the_limit() {
        let mesh = TriMesh::from_soup(&Sphere { radius: 1.0 }.icosphere(6).unwrap()).unwrap();
        let triangles: Vec<_> = mesh.topology().triangles().collect();
        for limit in [200, 5_000, 40_000] {
            let reduced = reduce(mesh.positions(), &triangles, limit);
            assert!(reduced.faces.len() <= limit && reduced.faces.len() > limit / 3, "{limit}");
            let area: f64 = reduced
                .triangles
                .iter()
                .map(|t| {
                    let [a, b, c] =
                        t.map(|v| mesh.positions()[reduced.vertices[v as usize] as usize]);
                    0.5 * (b - a).cross(c - a).length()
                })
                .sum();
            let share = area / (4.0 * std::f64::consts::PI);
            assert!((0.8..1.1).contains(&share), "{limit}: {share}");
        }
    }

    #[test]
    fn a_mesh_without_extent_is_reduced_to_nothing() {
        let reduced = reduce(&[DVec3::ONE; 3], &[[0, 1, 2]; 9], 1);
        assert!(reduced.faces.is_empty() && reduced.vertices.is_empty());
    }
}
