//! The points around a vertex as heights over its tangent plane.

use glam::{DVec2, DVec3};
use mesh_core::{HalfEdgeId, Topology, TriMesh, VertexId};

use crate::principal::TangentFrame;

/// The largest factor by which [`HeightPoint::at`] exceeds the projection. Points above it are not on a graph over the
/// tangent plane.
const MOST_STRETCH: f64 = 3.0;

/// The smallest cosine of the angle between the normals of a point and of the vertex, beyond the neighbours of the
/// vertex. Where the angle is larger, the surface is hardly a graph over the tangent plane, or there is a crease
/// between.
const LEAST_COSINE: f64 = 0.34;

/// A point near a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeightPoint {
    /// The place in the tangent plane: in the direction of the projection, at the distance of the point itself.
    ///
    /// On a sphere of radius `R`, the height of a point at distance `d` is exactly `d²/2R`, so spheres and circular
    /// sections are fitted without error however coarse the mesh is. The distance differs from the length of the
    /// projection by terms of third order, so the second derivatives at the vertex are equal if the plane is tangent.
    pub(crate) at: DVec2,
    /// The height over the tangent plane.
    pub(crate) z: f64,
}

/// The half-edges around the origin of a half-edge, alternately to its left and to its right, up to the boundary or
/// without end.
fn beside(topology: &Topology, first: HalfEdgeId) -> impl Iterator<Item = HalfEdgeId> + '_ {
    let clockwise = move |h: HalfEdgeId| {
        let twin = h.twin();
        (!topology.is_exterior(twin)).then(|| topology.next(twin))
    };
    let back = move |h: HalfEdgeId| (!topology.is_exterior(h)).then(|| topology.previous(h).twin());
    let mut ends = [Some(first); 2];
    core::iter::from_fn(move || {
        ends = [ends[0].and_then(clockwise), ends[1].and_then(back)];
        ends.iter().any(Option::is_some).then_some(ends)
    })
    .flat_map(|ends| ends.into_iter().flatten())
}

/// Collects the vertices around a vertex.
pub(crate) struct Neighbourhood<'a> {
    mesh: &'a TriMesh,
    /// The normals of all vertices, unless they are computed where they are needed.
    normals: Option<&'a [DVec3]>,
    /// The number of the last collection that contains this vertex.
    seen: Vec<u32>,
    collections: u32,
    vertices: Vec<VertexId>,
    /// For each collected vertex except the first one, the half-edge to the vertex that it was reached from.
    back: Vec<HalfEdgeId>,
    /// The result of [`Neighbourhood::heights`], nearest points first.
    pub(crate) points: Vec<HeightPoint>,
}

impl<'a> Neighbourhood<'a> {
    /// `normals` are the normals of all vertices, if many vertices are visited.
    pub(crate) fn new(mesh: &'a TriMesh, normals: Option<&'a [DVec3]>) -> Self {
        let seen = vec![0; mesh.topology().vertex_capacity()];
        Self {
            mesh,
            normals,
            seen,
            collections: 0,
            vertices: Vec::new(),
            back: Vec::new(),
            points: Vec::new(),
        }
    }

    /// The normal of a vertex.
    pub(crate) fn normal(&self, vertex: VertexId) -> DVec3 {
        let known = self.normals.and_then(|normals| normals.get(vertex.index()).copied());
        known.unwrap_or_else(|| self.mesh.vertex_normal(vertex))
    }

    /// Collects rings of neighbours: at least `rings`, then as long as there are fewer than `least` vertices, and
    /// beyond each vertex that is not farther than `radius`. At most about `most`; at a vertex with more neighbours,
    /// only the ones beside the edge that leads there, so that no vertex takes longer because of a distant fan.
    pub(crate) fn collect(
        &mut self,
        vertex: VertexId,
        rings: usize,
        least: usize,
        radius: f64,
        most: usize,
    ) {
        let (topology, center) = (self.mesh.topology(), self.mesh.position(vertex));
        if self.collections == u32::MAX {
            self.seen.fill(0);
            self.collections = 0;
        }
        self.collections += 1;
        self.seen[vertex.index()] = self.collections;
        self.vertices.clear();
        self.vertices.push(vertex);
        self.back.clear();
        let normal = self.normal(vertex);
        let (mut start, mut ring) = (0, 0);
        loop {
            let end = self.vertices.len();
            for i in start..end {
                let from = self.vertices[i];
                let is_far = self.mesh.position(from).distance(center) > radius;
                if ring >= rings && self.vertices.len() > least && is_far {
                    continue;
                }
                if self.vertices.len() > most {
                    break;
                }
                let came = i.checked_sub(1).map(|place| self.back[place]);
                match came.filter(|_| topology.one_ring(from).nth(most).is_some()) {
                    None => {
                        topology.outgoing(from).for_each(|h| self.visit(h, ring == 0, normal));
                    }
                    Some(back) => {
                        let enough = if radius > 0.0 { most } else { least };
                        let beside = beside(topology, back).take(enough);
                        beside.for_each(|h| self.visit(h, false, normal));
                    }
                }
            }
            if self.vertices.len() == end {
                return;
            }
            (start, ring) = (end, ring + 1);
        }
    }

    /// Collects the target of a half-edge, if it is new, and a neighbour or turned like the first vertex.
    fn visit(&mut self, h: HalfEdgeId, is_neighbour: bool, normal: DVec3) {
        let next = self.mesh.topology().target(h);
        let seen = &mut self.seen[next.index()];
        let is_new = core::mem::replace(seen, self.collections) != self.collections;
        if is_new && (is_neighbour || self.normal(next).dot(normal) >= LEAST_COSINE) {
            self.vertices.push(next);
            self.back.push(h.twin());
        }
    }

    /// The collected points over a tangent plane through the vertex, without the vertex itself and points
    /// perpendicularly above it.
    pub(crate) fn heights(&mut self, tangent: &TangentFrame) {
        self.stretched_heights(tangent, MOST_STRETCH);
    }

    /// As [`heights`](Self::heights), but at the projections of the points.
    pub(crate) fn projected_heights(&mut self, tangent: &TangentFrame) {
        self.stretched_heights(tangent, 1.0);
    }

    fn stretched_heights(&mut self, tangent: &TangentFrame, most_stretch: f64) {
        self.points.clear();
        let Some((&vertex, others)) = self.vertices.split_first() else { return };
        let center = self.mesh.position(vertex);
        for &other in others {
            let offset = self.mesh.position(other) - center;
            let DVec3 { x, y, z } = tangent.coordinates(offset);
            let (flat, length) = (DVec2::new(x, y).length(), offset.length());
            if flat > 1e-6 * length {
                let stretch = (length / flat).min(most_stretch);
                self.points.push(HeightPoint { at: DVec2::new(x, y) * stretch, z });
            }
        }
        let square = |point: &HeightPoint| point.at.length_squared();
        self.points.sort_unstable_by(|a, b| square(a).total_cmp(&square(b)));
    }

    /// Whether all collected vertices are at the boundary, as on a strip of one row of faces.
    pub(crate) fn is_strip(&self) -> bool {
        self.vertices.iter().all(|&v| self.mesh.topology().is_boundary_vertex(v))
    }

    /// The distance of the farthest point; 0 without points.
    pub(crate) fn reach(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point.at.length())
    }
}
