//! The constraint that keeps collapses within a distance of the original.
//!
//! Where one surface is a height field over the other, their distance is linear on each piece in which a face of one
//! meets a face of the other. It is largest at a corner of such a piece: at a vertex of either surface, or where an
//! edge of one crosses an edge of the other. So only vertices and edges are checked, in both directions. This is much
//! less work than checking faces. Elsewhere the measurement of the result finds points that are too far away, and
//! faces can be proved as well.
//!
//! Every vertex of the original belongs to the face that is closest to it. Every edge belongs to the faces that cover
//! it: the edge is divided into parts if need be, and both ends of each part are close enough to one of these faces.
//! The distance from a triangle is a convex function, so no point of the part is farther away than its ends. A collapse
//! is allowed if the vertices and edges that belong to the faces it changes are covered again, and if the edges it
//! changes are close enough to the original.
//!
//! At a boundary this is not enough: if all edges of a face also lie on other parts of the mesh, the face could
//! disappear. So the incenter of each face at a boundary counts as a vertex.

use glam::DVec3;
use mesh_collapse::{EdgePatch, Optimal, Place, Placement, Policy, Quadric, Rejection, Scratch};
use mesh_core::{EdgeId, FaceId, HalfEdgeId, Handle, Topology, TriMesh, as_u32, parallel};
use mesh_metric::{ClosestPoint, Surface, SurfaceError};
use mesh_refine::FaceLists;

use crate::tolerance::coverage::{Segment, Tolerance};
use crate::tolerance::edge_coverage;
use crate::tolerance::edge_face_incidence::EdgeFaceIncidence;
use crate::tolerance::prepared_triangle::{Prepared, Triangle};
use crate::tolerance::proofs::{Proofs, are_proved};

/// The constraint, with the vertices and edges of the original that belong to each face of a mesh.
pub(crate) struct DistanceConstraint<'a> {
    original: &'a Surface,
    /// Topology of the original.
    topology: &'a Topology,
    /// Incenters of its faces at boundaries. Their numbers as vertices follow the vertices.
    incenters: Vec<DVec3>,
    tolerance: Tolerance,
    proofs: Proofs<'a>,
    /// The vertices of each face, the farthest first, since it is the most likely to be too far away.
    vertices: FaceLists,
    incidence: EdgeFaceIncidence,
    holds_all: bool,
    /// Number of collapses so far.
    collapses: u32,
    /// For each face, the number of the last collapse that changed it, counted from 1; 0 if none did.
    changed: Vec<u32>,
    /// For each face, whether it must stay as it is.
    kept: Vec<bool>,
}

/// The vertices and edges of the original that a collapse would assign to the faces of its patch.
#[derive(Default)]
struct Ties {
    /// The faces that remain, after the collapse, in the order of the patch.
    faces: Vec<Prepared>,
    /// Edges, each with the index of the face that covers it.
    edges: Vec<(u32, usize)>,
    /// The vertices that belong to the patch, each with the index of its closest face, the closest vertices first.
    vertices: Vec<(f64, u32, usize)>,
    /// Collapses of one edge that were checked. The fields above belong to the last of them.
    asked: Vec<Asked>,
    /// The faces outside the patch that the answers depend on.
    others: Vec<FaceId>,
}

/// The edges that the faces of a patch would cover after its collapse, and the faces outside the patch, as in [`Ties`].
#[derive(Default)]
struct Covered {
    edges: Vec<(u32, usize)>,
    others: Vec<FaceId>,
}

/// A collapse that was checked, and whether it is allowed.
struct Asked {
    half_edge: HalfEdgeId,
    x: DVec3,
    holds: bool,
    /// Number of collapses before the check.
    collapses: u32,
}

impl<'a> DistanceConstraint<'a> {
    /// Assigns an original with this topology to the faces of a mesh. Where proofs are needed, the interior of new
    /// faces is checked as well.
    pub(crate) fn new(
        mesh: &TriMesh,
        topology: &'a Topology,
        original: &'a Surface,
        distance: f64,
        proofs: Proofs<'a>,
    ) -> Result<Self, SurfaceError> {
        let tolerance = Tolerance::new(distance, original.bounding_box());
        let surface = Surface::new(mesh)?;
        let faces = mesh.topology().face_capacity();
        let mut closest = Vec::with_capacity(original.positions().len());
        for some in original.positions().chunks(POINTS) {
            closest.extend(surface.closest_points(some).iter().map(Foot::new));
        }
        let incenters = incenters_at_boundaries(topology, original);
        let first = as_u32(original.positions().len());
        let mut vertices = FaceLists::new(faces, original.positions().len() + incenters.len());
        let used = original.used_vertices().into_iter().map(|v| (v, closest[v as usize]));
        let feet = surface.closest_points(&incenters);
        let feet = (first..).zip(feet.iter().map(Foot::new));
        let foot = |(v, foot): (u32, Foot)| (foot.distance, v, foot.face);
        let mut all: Vec<(f64, u32, FaceId)> = used.chain(feet).map(foot).collect();
        sort_by_distance(&mut all);
        for (_, vertex, face) in all {
            vertices.push(face, vertex);
        }
        let mut incidence = EdgeFaceIncidence::new(faces, topology.edge_capacity());
        let holds_all =
            add_incidence(&mut incidence, &surface, topology, original, &closest, tolerance);
        let (collapses, changed, kept) = (0, vec![0; faces], Vec::new());
        Ok(Self {
            original,
            topology,
            incenters,
            tolerance,
            proofs,
            vertices,
            incidence,
            holds_all,
            collapses,
            changed,
            kept,
        })
    }

    /// Keeps faces as they are: every collapse that changes one of them is rejected. `kept` has an entry for each face.
    pub(crate) fn keep(&mut self, kept: Vec<bool>) {
        self.kept = kept;
    }

    /// Whether every edge of the original was close enough to the mesh at the start.
    pub(crate) fn holds_all(&self) -> bool {
        self.holds_all
    }

    fn vertex(&self, vertex: u32) -> DVec3 {
        let (vertex, vertices) = (vertex as usize, self.original.positions());
        vertices.get(vertex).copied().unwrap_or_else(|| self.incenters[vertex - vertices.len()])
    }

    fn segment(&self, edge: u32) -> Segment {
        let ends = self.topology.edge_vertices(EdgeId::from_index(edge as usize));
        ends.map(|v| self.vertex(v.get()))
    }

    /// The earlier answer of [`DistanceConstraint::holds`], if all faces it depends on are unchanged. A positive answer
    /// counts only if it was the last one, because its ties are overwritten by the next check.
    fn answer(&self, patch: &EdgePatch<'_>, x: DVec3, ties: &Ties) -> Option<bool> {
        let is_same = |asked: &Asked| asked.half_edge == patch.half_edge() && asked.x == x;
        let place = ties.asked.iter().position(is_same)?;
        let Asked { holds, collapses, .. } = ties.asked[place];
        let mut all = faces_of(patch).chain(ties.others.iter().copied());
        let is_still_so = (!holds || place + 1 == ties.asked.len())
            && all.all(|face| self.changed[face.index()] <= collapses);
        is_still_so.then_some(holds)
    }

    /// Whether everything that belongs to the patch is covered after the edge is collapsed to `x`, and whether the new
    /// edges are close enough. Stores the new ties, and the faces outside the patch that the answer depends on.
    fn holds(&self, patch: &EdgePatch<'_>, x: DVec3, ties: &mut Ties) -> bool {
        if faces_of(patch).any(|face| self.kept.get(face.index()).is_some_and(|&kept| kept)) {
            return false;
        }
        let hub = patch.origin() + x;
        // Most rejected positions are too far away themselves.
        if self.original.distance(hub) > self.tolerance.distance() {
            return false;
        }
        let at = |corner: DVec3| patch.origin() + corner;
        let remaining = patch.remaining_faces().iter();
        let new: Vec<Triangle> =
            remaining.map(|face| [hub, at(face.corners[1]), at(face.corners[2])]).collect();
        ties.faces.clear();
        ties.faces.extend(new.iter().copied().map(Prepared::new));
        if !self.are_near(patch, &ties.faces) {
            return false;
        }
        let mut rim: Vec<DVec3> = Vec::with_capacity(new.len() + 2);
        for &[_, from, to] in &new {
            // The faces go round clockwise: each starts where the next one ends.
            if rim.last() != Some(&to) {
                rim.push(to);
            }
            rim.push(from);
        }
        let (distance, least) = (self.tolerance.distance(), self.tolerance.least());
        let holds = edge_coverage::are_within(hub, &rim, self.original, distance, least)
            && self.covers_edges(patch, ties)
            && (!self.proofs.are_needed(hub, &rim) || are_proved(&new, self.original, distance));
        if holds {
            self.find_closest(patch, ties);
        }
        holds
    }

    /// Whether the vertices that belong to the patch are near its new faces.
    fn are_near(&self, patch: &EdgePatch<'_>, faces: &[Prepared]) -> bool {
        // Check the farthest vertex of each face before all others.
        let first = faces_of(patch).filter_map(|face| self.vertices.of_face(face).next());
        let mut others = faces_of(patch).flat_map(|face| self.vertices.of_face(face).skip(1));
        if !self.are_all_near(first, faces) || !self.are_all_near(others.by_ref().take(FEW), faces)
        {
            return false;
        }
        let others: Vec<u32> = others.collect();
        parallel::holds_in_blocks(others.len(), |range| {
            self.are_all_near(others[range].iter().copied(), faces)
        })
    }

    fn are_all_near(&self, mut vertices: impl Iterator<Item = u32>, faces: &[Prepared]) -> bool {
        let mut last = 0;
        vertices.all(|v| {
            let found = self.tolerance.find(self.vertex(v), faces, [last, 0]);
            last = found.unwrap_or(last);
            found.is_some()
        })
    }

    /// Finds the closest new face for each vertex that belongs to the patch.
    fn find_closest(&self, patch: &EdgePatch<'_>, ties: &mut Ties) {
        let Ties { faces, vertices, .. } = ties;
        let tied = faces_of(patch).flat_map(|face| self.vertices.of_face(face));
        vertices.clear();
        vertices.extend(tied.map(|v| (f64::INFINITY, v, usize::MAX)));
        parallel::update(vertices, |_, (squared, v, closest)| {
            for (face, triangle) in faces.iter().enumerate() {
                if let Some(found) = triangle.squared_distance(self.vertex(*v), *squared) {
                    (*squared, *closest) = (found, face);
                }
            }
        });
        sort_by_distance(vertices);
    }

    /// Whether the edges that belong to the patch are covered by its new faces together with the unchanged faces
    /// outside that cover parts of them.
    fn covers_edges(&self, patch: &EdgePatch<'_>, ties: &mut Ties) -> bool {
        let Ties { faces, edges, others, .. } = ties;
        let around: Vec<FaceId> = faces_of(patch).collect();
        let all = self.edges_of_faces(around.iter().copied());
        let blocks: Vec<&[u32]> = all.chunks(FEW).collect();
        let found = parallel::try_collect_each(blocks.len(), |block| {
            self.covers_some(blocks[block], patch, (faces, &around))
        });
        edges.clear();
        match found {
            Ok(found) => {
                for Covered { edges: some, others: beyond } in found {
                    edges.extend(some);
                    others.extend(beyond);
                }
                true
            }
            Err(beyond) => {
                others.extend(beyond);
                false
            }
        }
    }

    /// [`DistanceConstraint::covers_edges`] for some of the edges. If an edge is not covered, the error lists the faces
    /// outside the patch that this depends on.
    fn covers_some(
        &self,
        some: &[u32],
        patch: &EdgePatch<'_>,
        (new, around): (&[Prepared], &[FaceId]),
    ) -> Result<Covered, Vec<FaceId>> {
        let Covered { mut edges, mut others } = Covered::default();
        let (mut faces, mut last) = (new.to_vec(), [0; 2]);
        let all_hold = some.iter().all(|&edge| {
            faces.truncate(new.len());
            let first = others.len();
            others.extend(self.incidence.of_edge(edge).filter(|face| !around.contains(face)));
            let beyond = &others[first..];
            faces.extend(beyond.iter().map(|&face| Prepared::new(patch.mesh().triangle(face))));
            let before = edges.len();
            // The faces outside cover this edge already.
            self.tolerance.cover(self.segment(edge), &faces, &mut last, &mut |face| {
                if face < new.len() && !edges[before..].contains(&(edge, face)) {
                    edges.push((edge, face));
                }
            })
        });
        if all_hold { Ok(Covered { edges, others }) } else { Err(others) }
    }

    /// The edges that belong to some faces, each once.
    fn edges_of_faces(&self, faces: impl Iterator<Item = FaceId>) -> Vec<u32> {
        let mut all: Vec<u32> = faces.flat_map(|face| self.incidence.of_face(face)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

/// Sorts vertices so that the farthest is last. The lists return the last entry first.
fn sort_by_distance<F>(all: &mut [(f64, u32, F)]) {
    all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
}

/// The faces of a patch before the collapse.
fn faces_of<'p>(patch: &EdgePatch<'p>) -> impl Iterator<Item = FaceId> + 'p {
    let topology = patch.mesh().topology();
    patch.faces().iter().filter_map(|face| topology.face(face.side))
}

/// The incenter of each face with a boundary edge. No other point of the face is farther from its edges.
fn incenters_at_boundaries(topology: &Topology, original: &Surface) -> Vec<DVec3> {
    let is_open = |&face: &FaceId| {
        topology.face_half_edges(face).iter().any(|h| topology.face(h.twin()).is_none())
    };
    let incenter = |face: FaceId| {
        let [a, b, c] = topology.face_vertices(face).map(|v| original.positions()[v.index()]);
        let weights = [b.distance(c), c.distance(a), a.distance(b)];
        let [u, v, w] = weights.map(|length| length / weights.iter().sum::<f64>());
        u * a + v * b + w * c
    };
    topology.faces().filter(is_open).map(incenter).filter(|p| p.is_finite()).collect()
}

/// The closest point of a surface to a point of the original.
#[derive(Clone, Copy)]
struct Foot {
    distance: f64,
    face: FaceId,
    /// The triangle of that face.
    triangle: u32,
}

impl Foot {
    fn new(&ClosestPoint { distance, face, triangle, .. }: &ClosestPoint) -> Self {
        Self { distance, face, triangle }
    }
}

/// The number of edges of a patch that one thread checks in sequence, and of its vertices that are checked before other
/// threads help.
const FEW: usize = 512;

/// The largest number of faces of a patch that is checked. All faces around a vertex of high valence may have a large
/// part of the original, and each collapse beside the vertex changes some of them. Its edges are tried again when
/// collapses of its neighbours have reduced its valence.
const MOST_FACES: usize = 96;

/// The number of vertices in one query.
const POINTS: usize = 1 << 16;
/// The number of edges in one block.
const BLOCK: usize = 2048;
/// The number of blocks whose results are collected before they are added.
const WAVE: usize = 64;

/// Adds the faces of a surface that cover each edge of the original. `closest` holds the closest point for each vertex
/// of the original. A part beyond the distance is assigned to the closest faces. Returns whether there is no such part.
fn add_incidence(
    incidence: &mut EdgeFaceIncidence,
    surface: &Surface,
    topology: &Topology,
    original: &Surface,
    closest: &[Foot],
    tolerance: Tolerance,
) -> bool {
    let mut holds_all = true;
    let count = topology.edge_capacity();
    let blocks = count.div_ceil(BLOCK);
    for first in (0..blocks).step_by(WAVE) {
        let found = parallel::collect_each(WAVE.min(blocks - first), |block| {
            let first = (first + block) * BLOCK;
            let edges = (first..count.min(first + BLOCK)).map(EdgeId::from_index);
            let whole = |edge: EdgeId| {
                let ends = topology.edge_vertices(edge);
                Part {
                    edge: edge.get(),
                    ends: ends.map(|v| original.positions()[v.index()]),
                    closest: ends.map(|v| closest[v.index()]),
                }
            };
            let there = edges.filter(|&edge| topology.contains_edge(edge));
            find_incidence(surface, there.map(whole).collect(), tolerance)
        });
        for (pairs, holds) in found {
            pairs.into_iter().for_each(|(edge, face)| incidence.add(edge, face));
            holds_all &= holds;
        }
    }
    holds_all
}

/// A part of an edge, with the closest points of its ends.
struct Part {
    edge: u32,
    ends: Segment,
    closest: [Foot; 2],
}

/// Pairs of an edge and a face of the surface that covers a part of it, and whether every part is within the distance.
fn find_incidence(
    surface: &Surface,
    mut parts: Vec<Part>,
    tolerance: Tolerance,
) -> (Vec<(u32, FaceId)>, bool) {
    let (mut found, mut holds_all) = (Vec::with_capacity(parts.len()), true);
    while !parts.is_empty() {
        let mut open = Vec::new();
        for part in parts {
            let covers = |closest: &&Foot| {
                tolerance.covers(&surface.triangle(closest.triangle as usize), &part.ends)
            };
            let is_near = part.closest.iter().all(|end| end.distance <= tolerance.distance());
            if let Some(closest) = part.closest.iter().find(covers) {
                found.push((part.edge, closest.face));
            } else if let Some(halves) = tolerance.halves(&part.ends).filter(|_| is_near) {
                open.push((part, halves));
            } else {
                holds_all &= is_near;
                found.extend(part.closest.map(|closest| (part.edge, closest.face)));
            }
        }
        let middles: Vec<DVec3> = open.iter().map(|(_, [[_, middle], _])| *middle).collect();
        let middles = surface.closest_to_neighbours(&middles);
        let halves = |((part, halves), middle): ((Part, [Segment; 2]), ClosestPoint)| {
            let [first, second] = part.closest;
            let middle = Foot::new(&middle);
            let closest = [[first, middle], [middle, second]];
            let half = |i: usize| Part { edge: part.edge, ends: halves[i], closest: closest[i] };
            [half(0), half(1)]
        };
        parts = open.into_iter().zip(middles).flat_map(halves).collect();
    }
    found.sort_unstable();
    found.dedup();
    (found, holds_all)
}

impl Policy for DistanceConstraint<'_> {}

impl Placement for DistanceConstraint<'_> {
    /// The optimal position of the quadric.
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        cost: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        Optimal { keep_volume: true }.place(patch, quadric, cost)
    }

    fn check(
        &self,
        patch: &EdgePatch<'_>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> Result<(), Rejection> {
        if patch.faces().len() > MOST_FACES {
            return Err(Rejection::Valence);
        }
        let ties: &mut Ties = scratch.get();
        let half_edge = patch.half_edge();
        let holds = self.answer(patch, x, ties).unwrap_or_else(|| {
            let is_of_now = |last: &Asked| {
                last.half_edge.edge() == half_edge.edge() && last.collapses == self.collapses
            };
            if !ties.asked.last().is_some_and(is_of_now) {
                ties.asked.clear();
                ties.others.clear();
            }
            let holds = self.holds(patch, x, ties);
            ties.asked.push(Asked { half_edge, x, holds, collapses: self.collapses });
            holds
        });
        if holds { Ok(()) } else { Err(Rejection::Distance) }
    }

    fn is_asked_ahead(&self) -> bool {
        true
    }

    /// If the optimal position is rejected, the two ends are tried.
    fn instead(&self, refused: usize) -> Option<Place> {
        [Place::Kept, Place::Removed].get(refused).copied()
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, _: DVec3, scratch: &mut Scratch) {
        let Ties { edges, vertices, .. } = scratch.get();
        let remaining = patch.remaining_faces().iter();
        let new: Vec<FaceId> =
            remaining.filter_map(|face| patch.mesh().topology().face(face.side)).collect();
        self.collapses += 1;
        for face in faces_of(patch) {
            self.changed[face.index()] = self.collapses;
            self.vertices.clear(face);
            self.incidence.clear(face);
        }
        for &(_, vertex, face) in vertices.iter() {
            if let Some(&face) = new.get(face) {
                self.vertices.push(face, vertex);
            }
        }
        for &(edge, face) in edges.iter() {
            if let Some(&face) = new.get(face) {
                self.incidence.add(edge, face);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_shapes::Sphere;

    /// Edges of the tip of a flat fan with this many faces, collapsed to the tip.
    fn at_the_tip(sides: u32) -> Result<(), Rejection> {
        let rim = |i: u32| {
            let angle = core::f64::consts::TAU * f64::from(i) / f64::from(sides);
            [angle.cos(), angle.sin(), 0.0]
        };
        let corners: Vec<[f64; 3]> = [[0.0; 3]].into_iter().chain((0..sides).map(rim)).collect();
        let faces: Vec<[u32; 3]> = (0..sides).map(|i| [0, 1 + i, 1 + (i + 1) % sides]).collect();
        let mesh = TriMesh::from_triangles(&corners, &faces).unwrap();
        let original = Surface::new(&mesh).unwrap();
        let constraint =
            DistanceConstraint::new(&mesh, mesh.topology(), &original, 0.1, Proofs::None).unwrap();
        let (mut around, mut scratch) = (Vec::new(), Scratch::default());
        let at_tip = |e: &EdgeId| mesh.topology().edge_vertices(*e).iter().any(|v| v.index() == 0);
        let edge = mesh.topology().edges().find(at_tip).unwrap();
        let patch = EdgePatch::gather(&mesh, edge.half_edge(), &mut around);
        let tip = mesh.position(mesh.topology().vertices().next().unwrap());
        constraint.check(&patch, tip - patch.origin(), &mut scratch)
    }

    #[test]
    fn the_edges_of_a_crowded_vertex_wait() {
        assert_eq!(at_the_tip(90), Ok(()));
        assert_eq!(at_the_tip(100), Err(Rejection::Valence));
    }

    /// Edges near a collapse must be checked again; other answers stay valid.
    #[test]
    fn an_answer_holds_until_a_collapse_changes_what_it_depends_on() {
        let mesh = TriMesh::from_soup(&Sphere { radius: 1.0 }.icosphere(3).unwrap()).unwrap();
        let topology = mesh.topology();
        let original = Surface::new(&mesh).unwrap();
        let mut distance_constraint =
            DistanceConstraint::new(&mesh, topology, &original, 0.1, Proofs::None).unwrap();
        let mut asked = Vec::new();
        for edge in topology.edges() {
            let (mut faces, mut scratch) = (Vec::new(), Scratch::default());
            let patch = EdgePatch::gather(&mesh, edge.half_edge(), &mut faces);
            assert!(distance_constraint.check(&patch, DVec3::ZERO, &mut scratch).is_ok());
            assert_eq!(distance_constraint.answer(&patch, DVec3::ZERO, scratch.get()), Some(true));
            assert_eq!(distance_constraint.answer(&patch, DVec3::X, scratch.get()), None);
            assert_eq!(
                distance_constraint.answer(&patch.reversed(), DVec3::ZERO, scratch.get()),
                None
            );
            let changed: Vec<FaceId> = faces_of(&patch).collect();
            asked.push((edge, changed, scratch));
        }
        let mut faces = Vec::new();
        let (edge, changed, scratch) = &mut asked[100];
        let patch = EdgePatch::gather(&mesh, edge.half_edge(), &mut faces);
        distance_constraint.collapsing(&patch, DVec3::ZERO, scratch);
        let changed = changed.clone();
        let mut again = 0;
        for (edge, mut around, mut scratch) in asked {
            let mut faces = Vec::new();
            let patch = EdgePatch::gather(&mesh, edge.half_edge(), &mut faces);
            let ties: &mut Ties = scratch.get();
            around.extend(&ties.others);
            let is_near = around.iter().any(|face| changed.contains(face));
            again += usize::from(is_near);
            let answer = distance_constraint.answer(&patch, DVec3::ZERO, ties);
            assert_eq!(answer, Some(true).filter(|_| !is_near));
        }
        assert!((20..100).contains(&again), "{again}");
    }
}
