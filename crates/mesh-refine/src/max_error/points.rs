//! Distances between a mesh and the original, point by point.

use core::ops::Range;

use glam::DVec3;
use mesh_core::{FaceId, TriMesh, parallel};
use mesh_metric::{Surface, SurfaceError, edge_points};

use crate::block_loop::{for_blocks_in_turn, values_in_turn};
use crate::fit::spread::{Spread, area};
use crate::max_error::elements::Elements;

/// Points of the original at which the distance from the mesh is measured. Consecutive numbers are mostly close in
/// space.
pub(super) struct Points<'a> {
    original: &'a Surface,
    /// The vertices, which come first.
    pub(super) vertices: Vec<u32>,
    /// Points on long edges, and samples.
    others: Vec<DVec3>,
    /// The number of the first sample. Samples are uniform by area, and averages are taken over them only.
    pub(super) samples: usize,
}

impl<'a> Points<'a> {
    /// `spacing` is relative to the square root of the mean area of the triangles. The number of samples suits a mesh
    /// of `faces` faces, and is at most one per two triangles or [`LEAST_SAMPLES`], whichever is more.
    pub(super) fn new(original: &'a Surface, spacing: f64, faces: usize) -> Self {
        let count = original.triangle_count();
        let samples = (SAMPLES_PER_FACE * faces).min((count / 2).max(LEAST_SAMPLES));
        let whole = parallel::sum(count, |t| area(&original.triangle(t)));
        let spacing = spacing * (whole / count as f64).sqrt();
        let most = (MAX_ON_EDGES_PER_FACE * count).max(LEAST_ON_EDGES);
        let (mut others, vertices) = parallel::both(
            || edge_points(original, spacing, MAX_ON_EDGE, most),
            || vertices_in_space(original),
        );
        let first = vertices.len() + others.len();
        let corners = |t: u32| original.triangle(t as usize);
        let spread = Spread::even(original.in_space(), corners, samples, SEED);
        others.reserve_exact(spread.len());
        for_blocks_in_turn(
            spread.len(),
            BLOCK,
            |range| spread.points(corners, range),
            |points| others.extend(points),
        );
        Self { original, vertices, others, samples: first }
    }

    pub(super) fn len(&self) -> usize {
        self.vertices.len() + self.others.len()
    }

    #[inline]
    pub(super) fn point(&self, number: usize) -> DVec3 {
        match self.vertices.get(number) {
            Some(&v) => self.original.positions()[v as usize],
            None => self.others[number - self.vertices.len()],
        }
    }

    pub(super) fn points(&self, numbers: Range<usize>) -> Vec<DVec3> {
        numbers.map(|number| self.point(number)).collect()
    }

    /// The statistics for these sums of the distances of all samples and of their squares.
    pub(super) fn heights(&self, largest: f64, [sum, squares]: [f64; 2]) -> Heights {
        let count = (self.len() - self.samples).max(1) as f64;
        Heights { largest, mean: sum / count, rms: (squares / count).max(0.0).sqrt() }
    }
}

/// The vertices that belong to a triangle, ordered so that consecutive vertices are close in space.
fn vertices_in_space(surface: &Surface) -> Vec<u32> {
    let mut is_there = vec![false; surface.positions().len()];
    let mut vertices = Vec::with_capacity(surface.positions().len());
    for &triangle in surface.in_space() {
        for v in surface.triangles()[triangle as usize] {
            if !core::mem::replace(&mut is_there[v as usize], true) {
                vertices.push(v);
            }
        }
    }
    vertices
}

/// The number of points in a block for one thread.
pub(super) const BLOCK: usize = 1024;

const SAMPLES_PER_FACE: usize = 10;
/// This number of samples is allowed even if the original has few triangles.
const LEAST_SAMPLES: usize = 40_000;
const SEED: u64 = 1;

/// The largest number of points on an edge of the original.
const MAX_ON_EDGE: usize = 100;
/// The largest number of points on edges per triangle. Long thin triangles side by side have many long edges; there,
/// points are farther apart.
const MAX_ON_EDGES_PER_FACE: usize = 4;
/// This number of points on edges is allowed even if the original has few triangles.
const LEAST_ON_EDGES: usize = 20_000;

/// Upper limits of the averages.
#[derive(Clone, Copy)]
pub(super) struct Most {
    pub(super) mean: f64,
    pub(super) rms: f64,
}

/// Statistics of the distances between a mesh and the original.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Heights {
    /// The largest of all distances, in both directions.
    pub(super) largest: f64,
    /// The mean of the samples.
    pub(super) mean: f64,
    pub(super) rms: f64,
}

/// Distances of a mesh without gaps, in both directions.
#[derive(Clone)]
pub(super) struct Peaks<'a> {
    pub(super) points: &'a Points<'a>,
    /// For each point, the closest face of the mesh and the distance.
    pub(super) forward: Vec<Closest>,
    pub(super) elements: Elements,
    /// Sums of the distances of the samples, and of their squares.
    pub(super) sums: [f64; 2],
    pub(super) heights: Heights,
}

/// The closest face of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Closest {
    pub(super) distance: f64,
    pub(super) face: FaceId,
}

impl<'a> Peaks<'a> {
    pub(super) fn new(
        mesh: &TriMesh,
        original: &Surface,
        points: &'a Points<'a>,
    ) -> Result<Self, SurfaceError> {
        let surface = Surface::new(mesh)?;
        let forward = values_in_turn(points.len(), BLOCK, |range| {
            let closest = surface.closest_to_neighbours(&points.points(range)).into_iter();
            closest.map(|c| Closest { distance: c.distance, face: c.face }).collect()
        });
        let faces: Vec<FaceId> = mesh.topology().faces().collect();
        let order: Vec<FaceId> = surface.in_space().iter().map(|&i| faces[i as usize]).collect();
        drop(surface);
        let mut elements = Elements::unknown(mesh.topology());
        elements.ask(mesh, original, &order);
        let samples = forward.get(points.samples..).unwrap_or_default();
        let sums = parallel::fold(
            samples.len(),
            [0.0; 2],
            |i| [samples[i].distance, samples[i].distance * samples[i].distance],
            |[a, b], [c, d]| [a + c, b + d],
        );
        let distances = forward.iter().map(|closest| closest.distance).chain(elements.distances());
        let heights = points.heights(distances.fold(0.0, f64::max), sums);
        Ok(Self { points, forward, elements, sums, heights })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use mesh_shapes::Plane;

    pub(in crate::max_error) fn plane(
        half_width: f64,
        cells: usize,
        place: impl Fn(DVec3) -> DVec3,
    ) -> TriMesh {
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
            let on_edges = edge_points(&surface, spacing, 100, usize::MAX).len();
            assert_eq!(on_edges == 0, times == 3.0);
            let points = Points::new(&surface, times, 20);
            assert_eq!(points.samples, mesh.topology().vertex_count() + on_edges);
            assert_eq!(points.len(), points.samples + 200);
        }
    }

    #[test]
    fn distances_are_those_of_points_vertices_centres_and_middles() {
        // The plane z = x, with a square below it: the distance at x is x / sqrt 2.
        let tilted = Surface::new(&plane(8.0, 8, |p| p.with_z(p.x))).unwrap();
        let mesh = plane(1.0, 1, |p| p);
        let points = Points::new(&tilted, 3.0, 1);
        let max_error = Peaks::new(&mesh, &tilted, &points).unwrap();
        let (height, topology) = (|x: f64| x.abs() / 2.0_f64.sqrt(), mesh.topology());
        for f in topology.faces() {
            let x = mesh.triangle(f).iter().map(|p| p.x).sum::<f64>() / 3.0;
            assert!((max_error.elements.of_face[f.index()] - height(x)).abs() < 1e-12);
        }
        for e in topology.edges() {
            let [a, b] = topology.edge_vertices(e).map(|v| mesh.position(v).x);
            assert!((max_error.elements.of_edge[e.index()] - height(0.5 * (a + b))).abs() < 1e-12);
        }
        for v in topology.vertices() {
            let x = mesh.position(v).x;
            assert!((max_error.elements.of_vertex[v.index()] - height(x)).abs() < 1e-12);
        }
        let forward = || max_error.forward.iter().map(|closest| closest.distance);
        assert_eq!(max_error.heights.largest, forward().fold(0.0, f64::max));
        let samples: Vec<f64> = forward().skip(points.samples).collect();
        let count = samples.len() as f64;
        assert_eq!(count, 10.0);
        assert!((max_error.heights.mean - samples.iter().sum::<f64>() / count).abs() < 1e-12);
        let square = samples.iter().map(|d| d * d).sum::<f64>() / count;
        assert!((max_error.heights.rms - square.sqrt()).abs() < 1e-12);
    }
}
