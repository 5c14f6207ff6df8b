//! Normal noise on the vertices of a mesh.

use glam::DVec3;
use mesh_core::SplitMix64;

use mesh_core::PolygonSoup;

/// The mean length of the edges, each counted once even if several faces share it; zero without faces.
#[must_use]
pub fn mean_edge_length(soup: &PolygonSoup) -> f64 {
    let mut edges: Vec<(u32, u32)> = Vec::with_capacity(soup.corners().len());
    for face in soup.faces() {
        let after = face.iter().cycle().skip(1);
        edges.extend(face.iter().zip(after).map(|(&a, &b)| (a.min(b), a.max(b))));
    }
    edges.sort_unstable();
    edges.dedup();
    let points = soup.positions();
    let length = |&(a, b): &(u32, u32)| points[a as usize].distance(points[b as usize]);
    edges.iter().map(length).sum::<f64>() / edges.len().max(1) as f64
}

/// Moves every vertex along its area-weighted normal by a normally distributed amount with
/// standard deviation `relative` mean edge lengths. Vertices without faces stay.
///
/// # Panics
/// When a face has an index out of range.
pub fn add_normal_noise(soup: &mut PolygonSoup, relative: f64, seed: u64) {
    let sigma = relative * mean_edge_length(soup);
    let mut normals = vec![DVec3::ZERO; soup.vertex_count()];
    for face in soup.faces() {
        let point = |i: usize| soup.positions()[face[i] as usize];
        let area = (2..face.len())
            .map(|i| (point(i - 1) - point(0)).cross(point(i) - point(0)))
            .sum::<DVec3>();
        for &vertex in face {
            normals[vertex as usize] += area;
        }
    }
    let mut random = SplitMix64::new(seed);
    for (point, normal) in soup.positions_mut().iter_mut().zip(normals) {
        *point += sigma * random.normal() * normal.normalize_or_zero();
    }
}
