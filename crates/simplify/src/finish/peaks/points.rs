//! How far a mesh and the original are from each other, point by point.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh, VertexId};
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
    /// The vertices of the mesh that have faces, each with what is closest on the original.
    pub(super) backward: Vec<(VertexId, ClosestPoint)>,
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
        let topology = mesh.topology();
        let used = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v));
        let (used, places): (Vec<VertexId>, Vec<DVec3>) =
            used.map(|v| (v, mesh.position(v))).unzip();
        let backward: Vec<(VertexId, ClosestPoint)> =
            used.into_iter().zip(original.closest_points(&places)).collect();
        let (faces, centers): (Vec<FaceId>, Vec<DVec3>) = inner_points(mesh).unzip();
        let inner: Vec<(FaceId, f64)> =
            faces.into_iter().zip(original.distances(&centers)).collect();
        let back = backward.iter().map(|(_, closest)| closest);
        let vertices = forward.iter().chain(back).map(|closest| closest.distance);
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
    use super::*;
    use mesh_core::shapes::Plane;

    fn plane(half_width: f64, cells: usize, place: impl Fn(DVec3) -> DVec3) -> TriMesh {
        let soup = Plane { half_width }.mesh(cells, Default::default()).unwrap();
        let mut mesh = TriMesh::from_soup(&soup).unwrap();
        mesh.positions_mut().iter_mut().for_each(|p| *p = place(*p));
        mesh
    }

    #[test]
    fn points_are_spaced_by_the_mean_area_of_the_triangles() {
        let mesh = plane(1.0, 4, |p| p);
        let surface = Surface::new(&mesh).unwrap();
        for times in [0.3, 0.9, 3.0] {
            let triangles = mesh.topology().face_count() as f64;
            let spacing = times * (4.0 / triangles).sqrt();
            let on_edges = edge_points(&surface, spacing, 100).len();
            assert_eq!(on_edges == 0, times == 3.0);
            let points = Points::new(&surface, times, 20);
            assert_eq!(points.samples, mesh.topology().vertex_count() + on_edges);
            assert_eq!(points.all.len(), points.samples + 200);
        }
    }

    #[test]
    fn distances_are_those_of_points_vertices_centres_and_middles() {
        // The plane z = x, and below it a square: the distance at x is x / sqrt 2.
        let tilted = Surface::new(&plane(8.0, 8, |p| p.with_z(p.x))).unwrap();
        let mesh = plane(1.0, 1, |p| p);
        let points = Points::new(&tilted, 3.0, 1);
        let peaks = Peaks::new(&mesh, &tilted, &points).unwrap();
        let (height, topology) = (|x: f64| x.abs() / 2.0_f64.sqrt(), mesh.topology());
        let mut expected: Vec<f64> = topology
            .faces()
            .map(|f| mesh.triangle(f).iter().map(|p| p.x).sum::<f64>() / 3.0)
            .collect();
        expected.extend(topology.edges().map(|e| {
            let [a, b] = topology.edge_vertices(e).map(|v| mesh.position(v).x);
            0.5 * (a + b)
        }));
        assert_eq!(peaks.inner.len(), topology.face_count() + topology.edge_count());
        for ((_, found), x) in peaks.inner.iter().zip(expected) {
            assert!((found - height(x)).abs() < 1e-12);
        }
        for (v, closest) in &peaks.backward {
            assert!((closest.distance - height(mesh.position(*v).x)).abs() < 1e-12);
        }
        let forward = || peaks.forward.iter().map(|closest| closest.distance);
        assert_eq!(peaks.largest, forward().fold(0.0, f64::max));
        let samples: Vec<f64> = forward().skip(points.samples).collect();
        let count = samples.len() as f64;
        assert_eq!(count, 10.0);
        assert!((peaks.mean - samples.iter().sum::<f64>() / count).abs() < 1e-12);
        let square = samples.iter().map(|d| d * d).sum::<f64>() / count;
        assert!((peaks.rms - square.sqrt()).abs() < 1e-12);
    }
}
