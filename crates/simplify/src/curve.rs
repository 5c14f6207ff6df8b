//! The lines of a mesh: its boundary, or its feature edges.

use glam::DVec3;
use mesh_core::{EdgeId, TriMesh, VertexId};
use mesh_metric::Surface;

/// Some edges of a mesh, to be asked for closest points, and the corners where they meet.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Edges as triangles without area.
    edges: Surface,
    corners: Vec<DVec3>,
}

/// The cosine of the turn from which on a vertex of a line is a corner: 30 degrees.
const CORNER: f64 = 0.866;

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
        let lines = topology.edges().filter(|&e| is_line(e));
        let sides: Vec<[u32; 3]> = lines
            .map(|e| {
                let [a, b] = topology.edge_vertices(e).map(VertexId::get);
                [a, b, b]
            })
            .collect();
        let edges = Surface::from_triangles(mesh.positions(), &sides).ok()?;
        let corners = topology.vertices().filter(|&v| is_corner(mesh, v, &is_line));
        let corners = corners.map(|v| mesh.position(v)).collect();
        Some(Self { edges, corners })
    }

    /// Where lines end, fork, or turn by more than 30 degrees.
    #[must_use]
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// The point of the curve that is closest to `point`.
    #[must_use]
    pub fn closest(&self, point: DVec3) -> DVec3 {
        self.edges.closest(point).point
    }

    /// The largest distance of any of the points to the curve.
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
