//! The lines of a mesh: its boundary, or its feature edges.

use glam::DVec3;
use mesh_core::{EdgeId, TriMesh, VertexId, parallel};
use mesh_metric::Surface;

/// Some edges of a mesh, prepared for closest-point queries, and the corners where they meet.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The edges, as triangles without area.
    edges: Surface,
    corners: Vec<DVec3>,
}

/// The cosine of 30 degrees: a vertex where a line turns by more is a corner.
const CORNER: f64 = 0.866;

/// The largest number of points on one edge.
const MOST_POINTS: f64 = 1000.0;

impl Curve {
    /// The boundary; `None` when there is none.
    #[must_use]
    pub fn boundary(mesh: &TriMesh) -> Option<Self> {
        Self::of_edges(mesh, |e| mesh.topology().is_boundary_edge(e))
    }

    /// The edges that `is_line` picks; `None` when there are none.
    #[must_use]
    pub fn of_edges(mesh: &TriMesh, is_line: impl Fn(EdgeId) -> bool) -> Option<Self> {
        let topology = mesh.topology();
        let lines: Vec<EdgeId> = topology.edges().filter(|&e| is_line(e)).collect();
        let curve = Self::new(mesh, &lines)?;
        let corners = topology.vertices().filter(|&v| is_corner(mesh, v, &is_line));
        let corners = corners.map(|v| mesh.position(v)).collect();
        Some(Self { corners, ..curve })
    }

    /// These edges, without corners.
    pub fn new(mesh: &TriMesh, lines: &[EdgeId]) -> Option<Self> {
        if lines.is_empty() {
            return None;
        }
        let side = |&e: &EdgeId| {
            let [a, b] = mesh.topology().edge_vertices(e).map(VertexId::get);
            [a, b, b]
        };
        let sides: Vec<[u32; 3]> = lines.iter().map(side).collect();
        let edges = Surface::from_triangles(mesh.positions(), &sides).ok()?;
        Some(Self { edges, corners: Vec::new() })
    }

    /// Points where lines end, fork, or turn by more than 30 degrees.
    #[must_use]
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// The point of the curve that is closest to `point`.
    #[must_use]
    pub fn closest(&self, point: DVec3) -> DVec3 {
        self.edges.closest(point).point
    }

    /// The unit direction of the curve at the point closest to `point`; zero on an edge without length.
    pub fn direction(&self, point: DVec3) -> DVec3 {
        let closest = self.edges.closest(point);
        let [a, b, _] = self.edges.triangle(closest.triangle as usize);
        (b - a).normalize_or_zero()
    }

    /// Points on the edges, evenly spaced on each and at most `spacing` apart, without the ends.
    pub fn points(&self, spacing: f64) -> Vec<DVec3> {
        let mut points = Vec::new();
        for edge in 0..self.edges.triangle_count() {
            let [a, b, _] = self.edges.triangle(edge);
            let count = (a.distance(b) / spacing).ceil().clamp(1.0, MOST_POINTS);
            let part = |i: usize| (i as f64 + 0.5) / count;
            points.extend((0..count as usize).map(|i| a + part(i) * (b - a)));
        }
        points
    }

    /// The sum of the lengths of the edges.
    pub fn length(&self) -> f64 {
        parallel::sum(self.edges.triangle_count(), |edge| {
            let [a, b, _] = self.edges.triangle(edge);
            a.distance(b)
        })
    }

    /// For each point, the index of the closest edge, and the position along that edge, from 0 to 1.
    pub fn closest_edges(&self, points: &[DVec3]) -> Vec<(usize, f64)> {
        let closest = self.edges.closest_points(points).into_iter();
        closest
            .map(|closest| {
                let edge = closest.triangle as usize;
                let [a, b, _] = self.edges.triangle(edge);
                let along = (closest.point - a).dot(b - a) / a.distance_squared(b);
                (edge, if along.is_finite() { along.clamp(0.0, 1.0) } else { 0.5 })
            })
            .collect()
    }

    /// The largest distance from the points to the curve.
    #[must_use]
    pub fn farthest(&self, points: &[DVec3]) -> Option<f64> {
        self.edges.distances(points).into_iter().reduce(f64::max)
    }
}

fn is_corner(mesh: &TriMesh, v: VertexId, is_line: impl Fn(EdgeId) -> bool) -> bool {
    let topology = mesh.topology();
    let mut ends = [DVec3::ZERO; 2];
    let mut count = 0;
    for h in topology.outgoing(v).filter(|h| is_line(h.edge())) {
        if let Some(end) = ends.get_mut(count) {
            *end = mesh.position(topology.target(h)) - mesh.position(v);
        }
        count += 1;
    }
    let [a, b] = ends;
    count > 0 && (count != 2 || -a.dot(b) < CORNER * a.length() * b.length())
}
