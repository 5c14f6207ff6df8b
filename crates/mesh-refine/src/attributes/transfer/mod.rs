//! Finds the points of the original that correspond to the corners of a simplified mesh, so that texture coordinates,
//! normals and colours can be transferred.
//!
//! Every vertex of the result stands for a connected cluster of vertices of the original. The search starts at this
//! cluster and walks from face to face, but never across a seam. So it cannot confuse texture charts that touch in
//! space.
//!
//! - A vertex inside a chart maps to the closest point of the faces at its cluster.
//! - A vertex on a seam maps to the closest point of the seam edges at its cluster. Its corners on either side take
//!   their values from the face on that side.
//! - Vertices at which seams end, fork or cross have not moved. Each of their corners takes the value of the original
//!   corner between the same seams.
//! - Where collapses crossed the border of two charts, a face may have corners in both. It takes all its values from
//!   the chart at its centroid.

mod clusters;
pub(crate) mod seams;

use glam::DVec3;
use mesh_core::{EdgeMap, FaceId, FaceMap, HalfEdgeId, HalfEdgeMap, TriMesh, VertexId, VertexMap};
use mesh_metric::{closest_on_triangle, weights_of_closest};

use crate::attributes::transfer::clusters::Clusters;
use crate::attributes::transfer::seams::{SeamLines, clockwise_border};

/// A point of a face of the original.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerSource {
    /// The face.
    pub face: FaceId,
    /// Barycentric weights, in the order of [`mesh_core::Topology::face_half_edges`]; their sum is 1.
    pub weights: [f64; 3],
}

/// Finds the point of the original for every corner of a simplified mesh.
///
/// `seams` are edges of the original whose two sides must not be mixed. They must have been feature edges of the
/// simplification, and their [`seam_nodes`](crate::seam_nodes) must have been locked. `became` maps vertices of the
/// original to vertices of the result (`Simplified::vertex_map` of the crate `simplify`).
///
/// `charts` are the charts of the faces of the original if there are borders of charts that are not among the seams.
///
/// The source is `None` for half-edges without a face, and for corners of faces none of whose vertices come from the
/// original.
#[must_use]
pub fn corner_sources(
    original: &TriMesh,
    seams: &EdgeMap<bool>,
    charts: Option<&FaceMap<u32>>,
    result: &TriMesh,
    vertex_map: &VertexMap<Option<VertexId>>,
) -> HalfEdgeMap<Option<CornerSource>> {
    let transfer = Transfer {
        clusters: Clusters::new(vertex_map, result.topology().vertex_capacity()),
        lines: SeamLines::new(original.topology(), seams),
        original,
        result,
    };
    let borders = transfer.borders(vertex_map);
    let mut sources = result.topology().half_edge_map(None);
    let mut open = Vec::new();
    for v in result.topology().vertices() {
        if transfer.clusters.of(v).is_empty() {
            open.push(v);
        } else {
            transfer.place(v, &borders, &mut sources);
        }
    }
    transfer.place_new(open, &mut sources);
    if let Some(charts) = charts {
        transfer.settle_charts(charts, &mut sources);
    }
    sources
}

struct Transfer<'a> {
    original: &'a TriMesh,
    result: &'a TriMesh,
    lines: SeamLines,
    clusters: Clusters,
}

type Sources = HalfEdgeMap<Option<CornerSource>>;

impl Transfer<'_> {
    /// The labels of the seams of the result, taken from the seam edges of the original that join two clusters.
    fn borders(&self, vertex_map: &VertexMap<Option<VertexId>>) -> HalfEdgeMap<Option<u32>> {
        let (old, new) = (self.original.topology(), self.result.topology());
        let mut borders = new.half_edge_map(None);
        for (h, label) in self.lines.label.iter().filter(|(_, label)| label.is_some()) {
            let ends = [old.origin(h), old.target(h)].map(|v| vertex_map.get(v).copied().flatten());
            if let [Some(from), Some(to)] = ends
                && from != to
                && let Some(side) = new.find_half_edge(from, to)
            {
                borders[side] = *label;
            }
        }
        borders
    }

    /// Finds the sources of the corners at a vertex.
    fn place(&self, v: VertexId, borders: &HalfEdgeMap<Option<u32>>, sources: &mut Sources) {
        let topology = self.result.topology();
        let cluster = self.clusters.of(v);
        let at = self.result.position(v);
        let old = self.original.topology();
        let node = cluster.iter().copied().find(|&u| self.lines.is_node(old, u));
        let corners = topology.outgoing(v).filter(|&h| !topology.is_exterior(h));
        if let Some(node) = node {
            for h in corners {
                let border = clockwise_border(topology, h, |side| borders[side].is_some());
                let label = border.and_then(|side| borders[side]);
                sources[h] = self.corner_at(node, label);
            }
        } else if let Some(side) = self.closest_seam(cluster, at) {
            let forward = self.lines.label[side];
            for h in corners {
                let border = clockwise_border(topology, h, |side| borders[side].is_some());
                let label = border.and_then(|side| borders[side]);
                let side = if label == forward { side } else { side.twin() };
                sources[h] = self.along(side, at);
            }
        } else {
            let source = self.closest_face(cluster, at);
            for h in corners {
                sources[h] = source;
            }
        }
    }

    /// The corner at a vertex of the original that comes, counter-clockwise, after the seam with this label, or after
    /// the boundary if there is no label.
    fn corner_at(&self, v: VertexId, label: Option<u32>) -> Option<CornerSource> {
        let topology = self.original.topology();
        let mut corners = topology.outgoing(v).filter(|&h| !topology.is_exterior(h));
        let follows = |h: &HalfEdgeId| match label {
            Some(_) => self.lines.label[*h] == label,
            None => topology.is_exterior(h.twin()),
        };
        let corner = corners.clone().find(follows).or_else(|| corners.next())?;
        self.on_face(topology.face(corner)?, self.original.position(v))
    }

    /// The seam half-edge closest to a point, among the seam edges at the cluster and farther along their lines.
    fn closest_seam(&self, cluster: &[VertexId], at: DVec3) -> Option<HalfEdgeId> {
        let topology = self.original.topology();
        let sides = cluster.iter().flat_map(|&u| topology.outgoing(u));
        let start = sides.filter(|&h| self.lines.label[h].is_some());
        let mut best = self.closest_of(start, at)?;
        let line = |h: HalfEdgeId| self.lines.label[h].map(|label| label / 2);
        loop {
            let ends = [topology.origin(best.1), topology.target(best.1)].into_iter();
            let sides = ends.flat_map(|v| topology.outgoing(v));
            let same_line = sides.filter(|&h| line(h) == line(best.1));
            match self.closest_of(same_line, at) {
                Some(next) if next.0 < best.0 => best = next,
                _ => return Some(best.1),
            }
        }
    }

    /// The closest of some edges to a point, with its squared distance.
    fn closest_of(
        &self,
        sides: impl Iterator<Item = HalfEdgeId>,
        at: DVec3,
    ) -> Option<(f64, HalfEdgeId)> {
        let topology = self.original.topology();
        let distance = |h: HalfEdgeId| {
            let [a, b] =
                [topology.origin(h), topology.target(h)].map(|v| self.original.position(v));
            closest_on_triangle(at, &[a, b, b]).length_squared()
        };
        sides.map(|h| (distance(h), h)).min_by(|p, q| p.0.total_cmp(&q.0))
    }

    /// The point of a seam edge that is closest to `at`, on the face to the left.
    fn along(&self, side: HalfEdgeId, at: DVec3) -> Option<CornerSource> {
        let topology = self.original.topology();
        let face = topology.face(side)?;
        let [from, to] =
            [topology.origin(side), topology.target(side)].map(|v| self.original.position(v));
        let t = ((at - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
        let t = if t.is_nan() { 0.0 } else { t };
        let weights = topology.face_half_edges(face).map(|h| {
            if h == side {
                1.0 - t
            } else if h == topology.next(side) {
                t
            } else {
                0.0
            }
        });
        Some(CornerSource { face, weights })
    }

    /// The closest point on the faces at a cluster, or on faces that a walk from there reaches.
    fn closest_face(&self, cluster: &[VertexId], at: DVec3) -> Option<CornerSource> {
        let topology = self.original.topology();
        let faces = cluster.iter().flat_map(|&u| topology.faces_of_vertex(u));
        let distances = faces.map(|face| (self.squared_distance(face, at), face));
        let (_, start) = distances.min_by(|p, q| p.0.total_cmp(&q.0))?;
        self.on_face(self.descend(start, at, |_| true), at)
    }

    /// Gives all corners of a face sources in one chart.
    fn settle_charts(&self, charts: &FaceMap<u32>, sources: &mut Sources) {
        let topology = self.result.topology();
        for face in topology.faces() {
            let sides = topology.face_half_edges(face);
            let [Some(a), Some(b), Some(c)] = sides.map(|h| sources[h]) else { continue };
            let faces = [a, b, c].map(|source| source.face);
            if faces.iter().all(|&f| charts[f] == charts[faces[0]]) {
                continue;
            }
            let corners = self.result.triangle(face);
            let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
            let near = faces.into_iter().min_by(|&f, &g| {
                self.squared_distance(f, centroid).total_cmp(&self.squared_distance(g, centroid))
            });
            let Some(near) = near else { continue };
            let middle = self.descend(near, centroid, |_| true);
            for (h, at) in sides.into_iter().zip(corners) {
                let within = self.descend(middle, at, |f| charts[f] == charts[middle]);
                sources[h] = self.on_face(within, at);
            }
        }
    }

    /// Walks over allowed faces towards a point, without crossing seams, as long as the distance falls. Faces that share
    /// only a corner are neighbours too: if the corner is the closest point of two faces, closer faces may lie beyond
    /// it.
    fn descend(&self, start: FaceId, at: DVec3, is_allowed: impl Fn(FaceId) -> bool) -> FaceId {
        let topology = self.original.topology();
        let (mut face, mut least) = (start, self.squared_distance(start, at));
        loop {
            let corners = topology.face_half_edges(face).into_iter();
            let next = corners
                .flat_map(|corner| self.fan(corner))
                .filter(|&f| is_allowed(f))
                .map(|f| (self.squared_distance(f, at), f))
                .min_by(|p, q| p.0.total_cmp(&q.0));
            match next {
                Some((distance, closer)) if distance < least => (face, least) = (closer, distance),
                _ => return face,
            }
        }
    }

    /// The other faces at the origin of a half-edge, on this side of seams.
    fn fan(&self, corner: HalfEdgeId) -> impl Iterator<Item = FaceId> + '_ {
        let topology = self.original.topology();
        let across = move |side: HalfEdgeId| {
            (self.lines.label[side].is_none() && !topology.is_exterior(side.twin()))
                .then(|| side.twin())
        };
        let clockwise = move |&h: &HalfEdgeId| across(h).map(|twin| topology.next(twin));
        let counterclockwise = move |&h: &HalfEdgeId| across(topology.next(topology.next(h)));
        let turn = move |first: Option<HalfEdgeId>| first.filter(move |&h| h != corner);
        let one = core::iter::successors(turn(clockwise(&corner)), move |h| turn(clockwise(h)));
        let other = core::iter::successors(turn(counterclockwise(&corner)), move |h| {
            turn(counterclockwise(h))
        });
        one.chain(other).filter_map(|h| topology.face(h))
    }

    fn squared_distance(&self, face: FaceId, at: DVec3) -> f64 {
        closest_on_triangle(at, &self.original.triangle(face)).length_squared()
    }

    /// The point of a face that is closest to `at`: exactly a corner if `at` is one.
    fn on_face(&self, face: FaceId, at: DVec3) -> Option<CornerSource> {
        let triangle = self.original.triangle(face);
        let weights = match triangle.iter().position(|&corner| corner == at) {
            Some(corner) => core::array::from_fn(|i| if i == corner { 1.0 } else { 0.0 }),
            None => weights_of_closest(at, &triangle).to_array(),
        };
        Some(CornerSource { face, weights })
    }

    /// Places new vertices, which stand for no vertex of the original, by means of their neighbours.
    fn place_new(&self, mut open: Vec<VertexId>, sources: &mut Sources) {
        let topology = self.result.topology();
        loop {
            let before = open.len();
            open.retain(|&v| {
                let corners = topology.outgoing(v).filter(|&h| !topology.is_exterior(h));
                let known = corners.clone().find_map(|h| sources[topology.next(h)]);
                let Some(known) = known else { return true };
                let at = self.result.position(v);
                let source = self.on_face(self.descend(known.face, at, |_| true), at);
                corners.for_each(|h| sources[h] = source);
                false
            });
            if open.is_empty() || open.len() == before {
                return;
            }
        }
    }
}
