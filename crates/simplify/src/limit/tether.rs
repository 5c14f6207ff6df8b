//! What keeps collapses within a distance of the original.
//!
//! Where one surface is a height over the other, their distance is a linear function over each piece in
//! which a face of the one meets a face of the other, and largest at a corner of such a piece: at a
//! vertex of either surface, or where an edge of the one crosses an edge of the other. So vertices and
//! edges are all that is looked at, in both directions, which is much less than what lies between them.
//! Where it is not, what is too far is found when the result is measured, and faces can be proved as well.
//!
//! Every vertex of the original belongs to the face that is closest to it. Every edge belongs to
//! the faces that cover it: divided into parts if need be, both ends of each part are close enough to one
//! of them. The distance from a triangle is a convex function, so that then no point of the part is
//! farther away than its ends. A collapse is allowed when the vertices and edges that belong to the
//! faces it changes are covered again, and the edges that it changes are close enough to the original.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_metric::{
    CertifyOptions, ClosestPoint, Surface, SurfaceError, closest_on_triangle, one_sided_bounds,
};

use crate::collapse::patch::{Collapse, EdgePatch, Place};
use crate::collapse::placement::{Optimal, Placement};
use crate::collapse::policy::{Policy, Scratch};
use crate::collapse::quadric::Quadric;
use crate::collapse::refusal::Refusal;
use crate::finish::face_lists::FaceLists;
use crate::limit::covers::Covers;
use crate::limit::reach::{Reach, Segment, Triangle};
use crate::limit::spokes;

/// What of the original is tied to the faces of a mesh.
pub(crate) struct Tether<'a> {
    original: &'a Surface,
    edges: &'a [[u32; 2]],
    reach: Reach,
    proves: bool,
    /// The vertices of each face, the farthest first: it is the first to be too far.
    vertices: FaceLists,
    covers: Covers,
    /// The vertices and edges of the patch that is about to be collapsed.
    loose_vertices: Vec<u32>,
    loose_edges: Vec<u32>,
}

/// The pieces of faces to look at before a collapse counts as too far.
const MAX_PIECES: usize = 3000;

/// The edges of a surface, each once.
pub(crate) fn edges_of(surface: &Surface) -> Vec<[u32; 2]> {
    let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let mut edges: Vec<_> = surface.triangles().iter().flat_map(sides).map(sorted).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

impl<'a> Tether<'a> {
    /// Ties an original, whose edges are given, to the faces of a mesh. With `proves`, new faces are looked at
    /// between their edges, too.
    pub(crate) fn new(
        mesh: &TriMesh,
        original: &'a Surface,
        edges: &'a [[u32; 2]],
        distance: f64,
        proves: bool,
    ) -> Result<Self, SurfaceError> {
        let reach = Reach::new(distance, original.bounding_box());
        let surface = Surface::new(mesh)?;
        let faces = mesh.topology().face_capacity();
        let closest = surface.closest_points(original.positions());
        let mut vertices = FaceLists::new(faces, original.positions().len());
        let used = original.used_vertices().into_iter();
        add_farthest_last(
            used.map(|v| (closest[v as usize].distance, v, closest[v as usize].face)).collect(),
            &mut vertices,
        );
        let mut covers = Covers::new(faces, edges.len());
        for (edge, face) in find_covers(&surface, original, edges, &closest, reach) {
            covers.add(edge, face);
        }
        let (loose_vertices, loose_edges) = (Vec::new(), Vec::new());
        Ok(Self { original, edges, reach, proves, vertices, covers, loose_vertices, loose_edges })
    }

    fn vertex(&self, vertex: u32) -> DVec3 {
        self.original.positions()[vertex as usize]
    }

    fn segment(&self, edge: u32) -> Segment {
        self.edges[edge as usize].map(|v| self.vertex(v))
    }

    /// Whether what belongs to the patch is covered when the edge is collapsed to `x`, and the new
    /// edges are close enough.
    fn holds(&self, patch: &EdgePatch<'_>, x: DVec3) -> bool {
        let hub = patch.origin() + x;
        // Most places that do not hold are too far themselves.
        if self.original.distance(hub) > self.reach.distance() {
            return false;
        }
        let at = |corner: DVec3| patch.origin() + corner;
        let remaining = patch.remaining_faces().iter();
        let new: Vec<Triangle> =
            remaining.map(|face| [hub, at(face.corners[1]), at(face.corners[2])]).collect();
        let mut last = 0;
        let mut is_near = |v: u32| {
            let found = self.reach.find(self.vertex(v), &new, [last, 0]);
            last = found.unwrap_or(last);
            found.is_some()
        };
        if !faces_of(patch).flat_map(|face| self.vertices.of_face(face)).all(&mut is_near) {
            return false;
        }
        let mut rim: Vec<DVec3> = Vec::with_capacity(new.len() + 2);
        for &[_, from, to] in &new {
            // They go round clockwise, each from where the next one goes to.
            if rim.last() != Some(&to) {
                rim.push(to);
            }
            rim.push(from);
        }
        spokes::are_within(hub, &rim, self.original, self.reach.distance(), self.reach.least())
            && self.covers_edges(patch, &new)
            && (!self.proves || self.is_proved(&new))
    }

    /// Whether no point of some faces is too far from the original.
    fn is_proved(&self, faces: &[Triangle]) -> bool {
        let corners: Vec<[u32; 3]> =
            (0..faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let Ok(surface) = Surface::from_triangles(faces.as_flattened(), &corners) else {
            return false;
        };
        let options = CertifyOptions {
            limit: Some(self.reach.distance()),
            max_pieces: MAX_PIECES,
            ..CertifyOptions::default()
        };
        one_sided_bounds(&surface, self.original, &options).upper <= self.reach.distance()
    }

    /// Whether the edges that belong to the patch are covered when its faces are these.
    fn covers_edges(&self, patch: &EdgePatch<'_>, new: &[Triangle]) -> bool {
        let around: Vec<FaceId> = faces_of(patch).collect();
        let (count, mut candidates, mut last) = (new.len(), new.to_vec(), [0; 2]);
        self.edges_of_faces(around.iter().copied()).into_iter().all(|edge| {
            candidates.truncate(count);
            let others = self.covers.of_edge(edge).filter(|face| !around.contains(face));
            candidates.extend(others.map(|face| patch.mesh().triangle(face)));
            self.reach.cover(self.segment(edge), &candidates, &mut last, &mut |_| {})
        })
    }

    /// The edges that belong to some faces, each once.
    fn edges_of_faces(&self, faces: impl Iterator<Item = FaceId>) -> Vec<u32> {
        let mut all: Vec<u32> = faces.flat_map(|face| self.covers.of_face(face)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

/// Puts vertices into the lists of their faces, by their distances from these.
fn add_farthest_last(mut all: Vec<(f64, u32, FaceId)>, vertices: &mut FaceLists) {
    all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (_, vertex, face) in all {
        vertices.push(face, vertex);
    }
}

/// The faces of a patch before the collapse.
fn faces_of<'p>(patch: &EdgePatch<'p>) -> impl Iterator<Item = FaceId> + 'p {
    let topology = patch.mesh().topology();
    patch.faces().iter().filter_map(|face| topology.face(face.side))
}

/// The faces of a surface that cover each edge of the original, whose vertices are closest to the points
/// that are given. What is beyond the distance belongs to the closest.
fn find_covers(
    surface: &Surface,
    original: &Surface,
    edges: &[[u32; 2]],
    closest: &[ClosestPoint],
    reach: Reach,
) -> Vec<(u32, FaceId)> {
    /// A part of an edge, and what is closest to its ends.
    struct Part {
        edge: u32,
        ends: Segment,
        closest: [ClosestPoint; 2],
    }
    let mut found = Vec::with_capacity(edges.len());
    let whole = |(edge, &ends): (u32, &[u32; 2])| Part {
        edge,
        ends: ends.map(|v| original.positions()[v as usize]),
        closest: ends.map(|v| closest[v as usize]),
    };
    let mut parts: Vec<Part> = (0..).zip(edges).map(whole).collect();
    while !parts.is_empty() {
        let mut open = Vec::new();
        for part in parts {
            let covers = |closest: &&ClosestPoint| {
                reach.covers(&surface.triangle(closest.triangle as usize), &part.ends)
            };
            let is_near = part.closest.iter().all(|end| end.distance <= reach.distance());
            if let Some(closest) = part.closest.iter().find(covers) {
                found.push((part.edge, closest.face));
            } else if let Some(halves) = reach.halves(&part.ends).filter(|_| is_near) {
                open.push((part, halves));
            } else {
                found.extend(part.closest.map(|closest| (part.edge, closest.face)));
            }
        }
        let middles: Vec<DVec3> = open.iter().map(|(_, [[_, middle], _])| *middle).collect();
        let middles = surface.closest_to_neighbours(&middles);
        let halves = |((part, halves), middle): ((Part, [Segment; 2]), ClosestPoint)| {
            let [first, second] = part.closest;
            let closest = [[first, middle], [middle, second]];
            let half = |i: usize| Part { edge: part.edge, ends: halves[i], closest: closest[i] };
            [half(0), half(1)]
        };
        parts = open.into_iter().zip(middles).flat_map(halves).collect();
    }
    found.sort_unstable();
    found.dedup();
    found
}

impl Policy for Tether<'_> {
    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        let around: Vec<FaceId> = mesh.topology().faces_of_vertex(collapse.kept).collect();
        let new: Vec<Triangle> = around.iter().map(|&face| mesh.triangle(face)).collect();
        let closest = |&v: &u32| {
            let squares =
                new.iter().map(|t| closest_on_triangle(self.vertex(v), t).length_squared());
            let nearest = squares.zip(&around).min_by(|a, b| a.0.total_cmp(&b.0));
            nearest.map(|(squared, &face)| (squared, v, face))
        };
        let found = self.loose_vertices.iter().filter_map(closest).collect();
        add_farthest_last(found, &mut self.vertices);
        let (count, mut candidates, mut last) = (new.len(), new, [0; 2]);
        let mut used = Vec::new();
        for &edge in &self.loose_edges {
            candidates.truncate(count);
            candidates.extend(self.covers.of_edge(edge).map(|face| mesh.triangle(face)));
            used.clear();
            self.reach.cover(self.segment(edge), &candidates, &mut last, &mut |i| used.push(i));
            used.sort_unstable();
            used.dedup();
            // The others have it already.
            for &face in used.iter().filter_map(|&i| around.get(i)) {
                self.covers.add(edge, face);
            }
        }
    }
}

impl Placement for Tether<'_> {
    /// The best by the quadric.
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        cost: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        Optimal { keep_volume: true }.place(patch, quadric, cost)
    }

    fn check(&self, patch: &EdgePatch<'_>, x: DVec3) -> Result<(), Refusal> {
        if self.holds(patch, x) { Ok(()) } else { Err(Refusal::Distance) }
    }

    /// Where the best place does not hold, the ends.
    fn instead(&self, refused: usize) -> Option<Place> {
        [Place::Kept, Place::Removed].get(refused).copied()
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) {
        self.loose_edges = self.edges_of_faces(faces_of(patch));
        self.loose_vertices.clear();
        for face in faces_of(patch) {
            self.loose_vertices.extend(self.vertices.of_face(face));
            self.vertices.clear(face);
            self.covers.clear(face);
        }
    }
}
