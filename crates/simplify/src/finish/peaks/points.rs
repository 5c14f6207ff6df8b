//! How far a mesh and the original are from each other, point by point.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_metric::{ClosestPoint, Surface, SurfaceError, edge_points, sample_surface};

/// Points of the original, to be asked how far they are from the mesh.
pub(super) struct Points {
    /// The vertices, points on edges that are longer than most, and samples.
    pub(super) all: Vec<DVec3>,
    /// From here on samples, uniform by area: the averages are those of these.
    samples: usize,
}

impl Points {
    /// `spacing` is in roots of the mean area of the triangles; samples are as many as suit a mesh of
    /// `faces` faces.
    pub(super) fn new(original: &Surface, spacing: f64, faces: usize) -> Self {
        let samples = SAMPLES_PER_FACE * faces;
        let triangles = (0..original.triangle_count()).map(|t| original.triangle(t));
        let area: f64 = triangles.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
        let spacing = spacing * (area / original.triangle_count() as f64).sqrt();
        let vertices = original.used_vertices().into_iter();
        let mut all: Vec<DVec3> = vertices.map(|v| original.positions()[v as usize]).collect();
        all.extend(edge_points(original, spacing, MAX_ON_EDGE));
        let first = all.len();
        all.extend(sample_surface(original, samples, SEED).iter().map(|sample| sample.position));
        Self { all, samples: first }
    }
}

const SAMPLES_PER_FACE: usize = 10;
const SEED: u64 = 1;

/// The most points on an edge of the original.
const MAX_ON_EDGE: usize = 100;

/// How far the averages may rise.
#[derive(Clone, Copy)]
pub(super) struct Most {
    pub(super) mean: f64,
    pub(super) rms: f64,
}

/// Distances of vertices, both ways.
pub(super) struct Peaks<'a> {
    pub(super) points: &'a Points,
    /// For each of the points, what is closest on the mesh.
    pub(super) forward: Vec<ClosestPoint>,
    /// For each vertex of the mesh, what is closest on the original.
    pub(super) backward: Vec<ClosestPoint>,
    /// Faces of the mesh and how far the original is from their centres and from the middle of
    /// their sides.
    pub(super) inner: Vec<(FaceId, f64)>,
    pub(super) largest: f64,
    /// The mean of `forward`, and the root of the mean square.
    pub(super) mean: f64,
    pub(super) rms: f64,
}

impl<'a> Peaks<'a> {
    pub(super) fn new(
        mesh: &TriMesh,
        original: &Surface,
        points: &'a Points,
    ) -> Result<Self, SurfaceError> {
        let forward = Surface::new(mesh)?.closest_points(&points.all);
        let backward = original.closest_points(mesh.positions());
        let (faces, centers): (Vec<FaceId>, Vec<DVec3>) = inner_points(mesh).unzip();
        let inner: Vec<(FaceId, f64)> =
            faces.into_iter().zip(original.distances(&centers)).collect();
        let vertices = forward.iter().chain(&backward).map(|closest| closest.distance);
        let largest =
            vertices.chain(inner.iter().map(|&(_, distance)| distance)).fold(0.0, f64::max);
        let samples = forward.get(points.samples..).unwrap_or_default();
        let sum: f64 = samples.iter().map(|c| c.distance).sum();
        let squares: f64 = samples.iter().map(|c| c.distance * c.distance).sum();
        let count = samples.len().max(1) as f64;
        let (mean, rms) = (sum / count, (squares / count).sqrt());
        Ok(Self { points, forward, backward, inner, largest, mean, rms })
    }
}

/// The centres of the faces and the middle of every edge, with a face that they are on.
fn inner_points(mesh: &TriMesh) -> impl Iterator<Item = (FaceId, DVec3)> {
    let topology = mesh.topology();
    let centers = topology.faces().map(|f| {
        let [a, b, c] = mesh.triangle(f);
        (f, a + ((b - a) + (c - a)) / 3.0)
    });
    let middles = topology.edges().filter_map(|e| {
        let [a, b] = topology.edge_vertices(e).map(|v| mesh.position(v));
        let face = topology.edge_faces(e).into_iter().flatten().next()?;
        Some((face, a + 0.5 * (b - a)))
    });
    centers.chain(middles)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use mesh_core::TriMesh;
    use mesh_metric::{Surface, edge_points};

    use super::{MAX_ON_EDGE, Peaks, Points, SAMPLES_PER_FACE, inner_points};

    const SQUARE: [[f64; 3]; 4] =
        [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 10.0, 0.0], [0.0, 10.0, 0.0]];
    const HALVES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    #[test]
    fn spacing_is_in_roots_of_the_mean_area() {
        let square = Surface::from_triangles(&SQUARE, &HALVES).expect("a square");
        for (spacing, on_edges) in [(0.1, 4 * 14 + 20), (1.0, 4 + 2), (1.5, 1), (3.0, 0)] {
            let points = Points::new(&square, spacing, 7);
            // The halves have an area of 50 each.
            let inside = edge_points(&square, spacing * 50_f64.sqrt(), MAX_ON_EDGE);
            assert_eq!(inside.len(), on_edges);
            assert_eq!(points.samples, 4 + on_edges);
            assert_eq!(points.all[4..points.samples], inside);
            assert_eq!(points.all.len(), points.samples + 7 * SAMPLES_PER_FACE);
        }
    }

    #[test]
    fn centres_and_middles_lie_inside() {
        let corners = [[0.0, 0.0, 0.0], [3.0, 0.0, 3.0], [0.0, 6.0, 9.0]];
        let mesh = TriMesh::from_triangles(&corners, &[[0, 1, 2]]).expect("a triangle");
        let face = mesh.topology().faces().next().expect("a face");
        let mut found: Vec<[f64; 3]> = inner_points(&mesh)
            .map(|(of, point)| {
                assert_eq!(of, face);
                point.to_array()
            })
            .collect();
        found[1..].sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0])));
        let middles = [[1.5, 0.0, 1.5], [0.0, 3.0, 4.5], [1.5, 3.0, 6.0]];
        assert_eq!(found, [&[[1.0, 2.0, 4.0]], &middles[..]].concat());
    }

    #[test]
    fn averages_are_over_the_area_and_the_largest_over_all() {
        // The square at a height of 3, with a needle without area that reaches up to 13.
        let mut corners = SQUARE.map(|[x, y, _]| [x, y, 3.0]).to_vec();
        corners.push([5.0, 5.0, 13.0]);
        let above = Surface::from_triangles(&corners, &[HALVES[0], HALVES[1], [0, 4, 4]]);
        let above = above.expect("a square and a needle");
        let mesh = TriMesh::from_triangles(&SQUARE, &HALVES).expect("a square");
        let points = Points::new(&above, 3.0, 5);
        let peaks = Peaks::new(&mesh, &above, &points).expect("there are faces");
        assert_eq!(peaks.largest, 13.0);
        assert!((peaks.mean - 3.0).abs() < 1e-12 && (peaks.rms - 3.0).abs() < 1e-12);
        assert_eq!(peaks.backward.len(), 4);
        let top = peaks.forward.iter().find(|closest| closest.distance == 13.0);
        assert_eq!(top.map(|closest| closest.point), Some(DVec3::new(5.0, 5.0, 0.0)));
    }
}
