//! Faces that lie on the original upside down, and their repair.
//!
//! Every step keeps faces from turning too far at once, but a chain of small turns can turn a face over. Such a face is
//! found by the normals of the original around it. It is turned back by the flip of one of its edges, or by a move of
//! one of its vertices: to the original, or towards the middle of the neighbours. Where no single change helps, two are
//! made: any change around the face, then one that turns it back. The changes that leave the fewest faces turned over
//! are made; among equal ones, those that stay closest to the original. No change takes a point farther from the
//! original than the farthest point near the folds was before, or up to four times as far where nothing else helps.

use glam::DVec3;
use mesh_collapse::NewIntersections;
use mesh_core::{EdgeId, FaceId, HalfEdgeId, TriMesh, VertexId, parallel};
use mesh_metric::Surface;

use crate::face_quality::keeps_height;
use crate::fit::constraints::FitConstraints;
use crate::fit::flips::flip_crosses;
use crate::fit::freedom::{Freedom, freedoms};
use crate::fit::moves::cross;

/// Options of [`unfold`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct UnfoldOptions {
    /// Whether faces must not intersect if they did not before.
    pub forbid_intersections: bool,
}

/// What [`unfold`] found and did. A face that is turned over is counted if it is beside a fold: one of its neighbours
/// has an opposite normal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct UnfoldReport {
    /// Number of faces that were turned over before, or became so between two repairs.
    pub turned_before: usize,
    /// Number of faces that are turned over after it.
    pub turned_after: usize,
}

impl UnfoldReport {
    /// Whether faces were turned back.
    #[must_use]
    pub const fn has_helped(&self) -> bool {
        self.turned_after < self.turned_before
    }

    /// The report of both runs, where the mesh was changed in between.
    #[must_use]
    pub(crate) const fn then(self, next: Self) -> Self {
        let new = next.turned_before.saturating_sub(self.turned_after);
        Self { turned_before: self.turned_before + new, turned_after: next.turned_after }
    }
}

/// The largest number of passes over the faces that are turned over.
const PASSES: usize = 4;

/// The cosine between the normals of a face and of the original below which the face is turned over.
const TURNED: f64 = -0.1;

/// Distances below this share of the diagonal of the original are rounding.
const ROUNDING: f64 = 1e-9;

/// Parts of the original lie on each other where they are closer than this share of its diagonal.
const SAME: f64 = 1e-7;

/// How far a vertex moves towards the middle of its neighbours before it moves to the closest point of the original.
const TOWARDS_MIDDLE: [f64; 3] = [0.0, 0.5, 1.0];

/// Turns back the faces that are turned over against the original, where flips and moves can do that.
pub fn unfold(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &FitConstraints,
    options: &UnfoldOptions,
) -> UnfoldReport {
    let suspects = turned_faces(mesh, original, 0.0);
    if suspects.is_empty() {
        return UnfoldReport::default();
    }
    let farthest = farthest_near(mesh, original, &suspects);
    let mut turned = turned_faces(mesh, original, farthest);
    let turned_before = turned.len();
    let found = options.forbid_intersections.then(|| NewIntersections::new(mesh));
    let freedoms = freedoms(mesh, constraints);
    let limit = farthest;
    let mut repair = Repair { mesh, original, constraints, freedoms, found, farthest, limit };
    for _ in 0..PASSES {
        let count = turned.len();
        turned.into_iter().for_each(|face| repair.turn_back(face));
        turned = turned_faces(repair.mesh, original, farthest);
        if turned.is_empty() || turned.len() >= count {
            break;
        }
    }
    UnfoldReport { turned_before, turned_after: turned.len() }
}

/// All faces that are turned over. Only faces at folds are asked in detail: other faces that are close to the other side
/// of a thin wall are no folds.
fn turned_faces(mesh: &TriMesh, original: &Surface, farthest: f64) -> Vec<FaceId> {
    let faces = faces_at_folds(mesh);
    let is_turned = parallel::collect(faces.len(), |index| {
        is_turned(original, mesh.triangle(faces[index]), farthest)
    });
    faces.into_iter().zip(is_turned).filter(|&(_, turned)| turned).map(|(face, _)| face).collect()
}

/// The faces with a normal opposite to the normal of a neighbour.
#[must_use]
pub fn faces_at_folds(mesh: &TriMesh) -> Vec<FaceId> {
    let mut crosses = mesh.topology().face_map(DVec3::ZERO);
    mesh.topology().faces().for_each(|face| crosses[face] = mesh.face_cross(face));
    let is_at_fold = |&face: &FaceId| {
        let topology = mesh.topology();
        let neighbours = topology.face_half_edges(face).map(|h| topology.face(h.twin()));
        neighbours.into_iter().flatten().any(|other| crosses[other].dot(crosses[face]) < 0.0)
    };
    mesh.topology().faces().filter(is_at_fold).collect()
}

/// Whether the normal of the original is opposite at points all over the triangle, and agrees nowhere twice `farthest`
/// above and below them: otherwise the triangle may stand for the other side of a thin wall. Where parts of the original
/// lie on each other, none of them agrees.
fn is_turned(original: &Surface, triangle: [DVec3; 3], farthest: f64) -> bool {
    let normal = cross(triangle).normalize_or_zero();
    let agreement_with =
        |triangle: usize| cross(original.triangle(triangle)).normalize_or_zero().dot(normal);
    let agreement = |point: DVec3| agreement_with(original.closest(point).triangle as usize);
    let same = SAME * original.bounding_box().diagonal();
    let has_agreeing = |point: DVec3| {
        let reach = original.distance(point) + same;
        original.has_within(point, reach, |triangle| agreement_with(triangle) > -TURNED)
    };
    let reach = 2.0 * farthest * normal;
    let agrees = |point: DVec3| farthest > 0.0 && agreement(point) > -TURNED;
    let mut points = points(triangle).into_iter();
    points.all(|p| {
        agreement(p) < TURNED && !agrees(p + reach) && !agrees(p - reach) && !has_agreeing(p)
    })
}

/// The centroid, and points between it and the corners.
fn points([a, b, c]: [DVec3; 3]) -> [DVec3; 4] {
    let near = |p: DVec3, q: DVec3, r: DVec3| p + 0.2 * ((q - p) + (r - p));
    [a + ((b - a) + (c - a)) / 3.0, near(a, b, c), near(b, c, a), near(c, a, b)]
}

/// The largest distance of points of the faces in the two-rings of some faces from the original, if it is more than
/// rounding.
fn farthest_near(mesh: &TriMesh, original: &Surface, faces: &[FaceId]) -> f64 {
    let topology = mesh.topology();
    let mut near: Vec<FaceId> = faces.to_vec();
    for _ in 0..2 {
        let vertices = near.iter().flat_map(|&face| topology.face_vertices(face));
        near = vertices.flat_map(|v| topology.faces_of_vertex(v)).collect();
        near.sort_unstable();
        near.dedup();
    }
    let triangles: Vec<[DVec3; 3]> = near.iter().map(|&face| mesh.triangle(face)).collect();
    farthest_of(original, &triangles).max(ROUNDING * original.bounding_box().diagonal())
}

/// The largest distance of points of some faces from the original.
fn farthest_of(original: &Surface, faces: &[[DVec3; 3]]) -> f64 {
    let points = faces.iter().flat_map(|&face| points(face));
    points.map(|point| original.distance(point)).fold(0.0, f64::max)
}

/// A change of some faces.
#[derive(Clone, Copy)]
enum Change {
    Flip(EdgeId),
    Move(VertexId, DVec3),
}

/// The number of faces that a change turns over, negative if it turns faces back, and the largest distance of the
/// changed faces from the original after it.
type Effect = (isize, f64);

struct Repair<'a> {
    mesh: &'a mut TriMesh,
    original: &'a Surface,
    constraints: &'a FitConstraints,
    /// The freedom of each vertex, by index.
    freedoms: Vec<Freedom>,
    found: Option<NewIntersections>,
    /// The largest distance of a point near the folds from the original.
    farthest: f64,
    /// The largest distance at which a changed face may be.
    limit: f64,
}

/// The factors on the largest distance near the folds that are allowed, one after another.
const FARTHER: [f64; 3] = [1.0, 2.0, 4.0];

/// The number of faces that the first of two changes may turn over, before the second one turns faces back.
const MORE_BETWEEN: isize = 1;

/// The smallest of several changes by effect.
fn best<C>(changes: impl Iterator<Item = (Effect, C)>) -> Option<(Effect, C)> {
    changes.min_by(|((a, far_a), _), ((b, far_b), _)| a.cmp(b).then(far_a.total_cmp(far_b)))
}

impl Repair<'_> {
    /// If a face is turned over, makes the changes that turn the most faces back, if there are any.
    fn turn_back(&mut self, face: FaceId) {
        if !is_turned(self.original, self.mesh.triangle(face), self.farthest) {
            return;
        }
        for factor in FARTHER {
            self.limit = factor * self.farthest;
            if let Some((_, change)) = self.change_of(face, -1) {
                self.make(change);
                return;
            }
            if let Some((_, changes)) = self.two_changes(face) {
                for change in changes {
                    self.make(change);
                }
                return;
            }
        }
    }

    /// The best change of a face among those that turn over at most `most` faces.
    fn change_of(&self, face: FaceId, most: isize) -> Option<(Effect, Change)> {
        let topology = self.mesh.topology();
        let edges = topology.face_half_edges(face).map(HalfEdgeId::edge);
        let flips = edges.into_iter().filter_map(|edge| self.flip(edge, most));
        let moves = topology.face_vertices(face).into_iter().flat_map(|v| self.moves(v, most));
        best(flips.chain(moves))
    }

    /// The best two changes around a face of which the second one turns faces back.
    fn two_changes(&mut self, face: FaceId) -> Option<(Effect, [Change; 2])> {
        let topology = self.mesh.topology();
        let corners = topology.face_vertices(face);
        let mut edges: Vec<EdgeId> =
            corners.into_iter().flat_map(|v| topology.edges_of_vertex(v)).collect();
        edges.sort_unstable();
        edges.dedup();
        let mut vertices: Vec<VertexId> =
            corners.into_iter().flat_map(|v| topology.one_ring(v)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let flips = edges.into_iter().filter_map(|edge| self.flip(edge, MORE_BETWEEN));
        let moves = vertices.into_iter().flat_map(|v| self.moves(v, MORE_BETWEEN));
        let firsts: Vec<(Effect, Change)> = flips.chain(moves).collect();
        let pairs = firsts.into_iter().filter_map(|((turned, far), first)| {
            let undo = self.undo_of(first);
            let changed = self.make(first);
            let faces = changed.into_iter().chain([face]);
            let second = best(faces.filter_map(|face| self.change_of(face, -1 - turned)));
            for change in undo {
                self.make(change);
            }
            let ((more, farther), second) = second?;
            Some(((turned + more, far.max(farther)), [first, second]))
        });
        best(pairs.collect::<Vec<_>>().into_iter())
    }

    /// The changes that undo a change which has not been made yet. A flip turns an edge by a quarter, so that three more
    /// restore its direction as well.
    fn undo_of(&self, change: Change) -> Vec<Change> {
        match change {
            Change::Flip(_) => vec![change; 3],
            Change::Move(v, _) => vec![Change::Move(v, self.mesh.position(v))],
        }
    }

    /// Makes a change, and returns the changed faces.
    fn make(&mut self, change: Change) -> Vec<FaceId> {
        let changed: Vec<FaceId> = match change {
            Change::Flip(edge) => {
                let Ok(flip) = self.mesh.topology().check_flip(edge) else { return Vec::new() };
                self.mesh.flip(flip);
                self.mesh.topology().edge_faces(edge).into_iter().flatten().collect()
            }
            Change::Move(v, to) => {
                self.mesh.positions_mut()[v.index()] = to;
                self.mesh.topology().faces_of_vertex(v).collect()
            }
        };
        if let Some(found) = &mut self.found {
            found.update(self.mesh, changed.iter().copied());
        }
        changed
    }

    /// The flip of an edge, if it is allowed and turns over at most `most` faces.
    fn flip(&self, edge: EdgeId, most: isize) -> Option<(Effect, Change)> {
        let topology = self.mesh.topology();
        if self.constraints.is_held(edge) || !self.constraints.limits.allow_flip(self.mesh, edge) {
            return None;
        }
        let flip = topology.check_flip(edge).ok()?;
        let [a, b, c, d] = flip.quad().map(|v| self.mesh.position(v));
        let (old, new) = ([[a, b, c], [b, a, d]], [[c, a, d], [d, b, c]]);
        if !keeps_height(new, old) {
            return None;
        }
        let effect = self.effect(&old, &new, most)?;
        if self.found.as_ref().is_some_and(|found| flip_crosses(self.mesh, found, &flip)) {
            return None;
        }
        Some((effect, Change::Flip(edge)))
    }

    /// The moves of a vertex that are allowed and turn over at most `most` faces.
    fn moves(&self, v: VertexId, most: isize) -> Vec<(Effect, Change)> {
        let topology = self.mesh.topology();
        let freedom = self.freedoms[v.index()];
        let curve = freedom.curve(self.constraints);
        let is_beside = |e: EdgeId| match freedom {
            Freedom::Free => true,
            Freedom::AlongBoundary => topology.is_boundary_edge(e),
            Freedom::AlongFeature => self.constraints.is_feature(e),
            Freedom::Fixed => false,
        };
        let from = self.mesh.position(v);
        let beside = topology.edges_of_vertex(v).filter(|&e| is_beside(e));
        let ends = beside.map(|e| topology.edge_vertices(e).map(|w| self.mesh.position(w)));
        let (sum, count) = ends.fold((DVec3::ZERO, 0.0), |(sum, count), [a, b]| {
            (sum + (a - from) + (b - from), count + 1.0)
        });
        if count == 0.0 {
            return Vec::new();
        }
        let to_middle = sum / count;
        let faces: Vec<FaceId> = topology.faces_of_vertex(v).collect();
        let old: Vec<[DVec3; 3]> = faces.iter().map(|&face| self.mesh.triangle(face)).collect();
        let moved = |part: f64| {
            let point = from + part * to_middle;
            let to = curve.map_or_else(|| self.original.closest(point).point, |c| c.closest(point));
            let at = |w: VertexId| if w == v { to } else { self.mesh.position(w) };
            let new: Vec<[DVec3; 3]> =
                faces.iter().map(|&face| topology.face_vertices(face).map(at)).collect();
            let crosses =
                || self.found.as_ref().is_some_and(|found| found.would_arise_at(self.mesh, v, to));
            let is_allowed = self.constraints.limits.allow_move(self.mesh, v, to)
                && old.iter().zip(&new).all(|(&old, &new)| keeps_height([new], [old]));
            let effect = if is_allowed { self.effect(&old, &new, most) } else { None }?;
            (!crosses()).then_some((effect, Change::Move(v, to)))
        };
        TOWARDS_MIDDLE.into_iter().filter_map(moved).collect()
    }

    /// The effect of a change of faces, if it turns over at most `most` faces and takes none too far from the original.
    fn effect(&self, old: &[[DVec3; 3]], new: &[[DVec3; 3]], most: isize) -> Option<Effect> {
        let turned = |faces: &[[DVec3; 3]]| {
            let is_turned = |&&face: &&[DVec3; 3]| is_turned(self.original, face, self.farthest);
            faces.iter().filter(is_turned).count()
        };
        let turned = turned(new) as isize - turned(old) as isize;
        if turned > most {
            return None;
        }
        let far = farthest_of(self.original, new);
        (far <= self.limit).then_some((turned, far))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Prisms side by side: every inner wall lies on a wall of the next one, which faces the other way.
    #[test]
    fn walls_on_each_other_are_no_folds() {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for prism in 0..6 {
            let corners = [0, prism + 1, prism + 2].map(|corner| {
                let (y, x) = (f64::from(corner) * core::f64::consts::FRAC_PI_3).sin_cos();
                if corner == 0 { DVec3::ZERO } else { DVec3::new(x, y, 0.0) }
            });
            let first = 6 * prism as u32;
            positions.extend(corners.into_iter().flat_map(|p| [p, p + DVec3::Z]));
            let sides =
                [[0, 2, 3, 1], [2, 4, 5, 3], [4, 0, 1, 5]].map(|side| side.map(|v| v + first));
            triangles.extend([[first, first + 4, first + 2], [first + 1, first + 3, first + 5]]);
            triangles.extend(sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]));
        }
        let mesh = TriMesh::from_triangles(&positions, &triangles).unwrap();
        assert!(mesh.volume() > 2.5 && !faces_at_folds(&mesh).is_empty());
        assert!(turned_faces(&mesh, &Surface::new(&mesh).unwrap(), 0.0).is_empty());
    }

    #[test]
    fn a_fold_in_a_sheet_is_turned_back_and_a_thin_wall_is_no_fold() {
        let soup = mesh_shapes::Plane { half_width: 1.0 }
            .irregular_mesh(8, mesh_shapes::Irregular { jitter: 0.2, seed: 3 })
            .unwrap();
        let flat = TriMesh::from_soup(&soup).unwrap();
        let original = Surface::new(&flat).unwrap();
        let topology = flat.topology();
        let inner: Vec<VertexId> =
            topology.vertices().filter(|&v| !topology.is_boundary_vertex(v)).collect();
        // Beyond one of the neighbours, alone or together with that neighbour.
        for (&v, is_pair) in inner.iter().flat_map(|v| [(v, false), (v, true)]) {
            let mut mesh = flat.clone();
            let next = mesh.topology().one_ring(v).find(|w| inner.contains(w)).unwrap();
            let (from, to) = (mesh.position(v), mesh.position(next));
            mesh.positions_mut()[v.index()] = from + 1.3 * (to - from);
            if is_pair {
                mesh.positions_mut()[next.index()] = to - 0.3 * (to - from);
            }
            let z = |face: FaceId| mesh.face_cross(face).z;
            let is_at_fold = |&face: &FaceId| {
                let half_edges = mesh.topology().face_half_edges(face);
                let neighbours = half_edges.map(|h| mesh.topology().face(h.twin()));
                neighbours.into_iter().flatten().any(|other| z(other) > 0.0)
            };
            let downwards = mesh.topology().faces().filter(|&face| z(face) < 0.0);
            let turned_before = downwards.filter(is_at_fold).count();
            let report =
                unfold(&mut mesh, &original, &FitConstraints::default(), &UnfoldOptions::default());
            assert!(turned_before > 0, "{v:?}");
            assert_eq!(report, UnfoldReport { turned_before, turned_after: 0 }, "{v:?}");
            assert!(mesh.topology().faces().all(|face| mesh.face_cross(face).z > 0.0));
        }
        let soup = mesh_shapes::polyhedra::cube();
        let mut slab = TriMesh::from_soup(&soup).unwrap();
        slab.positions_mut().iter_mut().for_each(|p| p.z *= 1e-4);
        let (surface, before) = (Surface::new(&slab).unwrap(), slab.clone());
        // One side further out, so that it is closest to the other one.
        slab.positions_mut().iter_mut().for_each(|p| p.z += 2e-3);
        let moved = slab.clone();
        unfold(&mut slab, &surface, &FitConstraints::default(), &UnfoldOptions::default());
        assert_eq!(slab.positions(), moved.positions());
        assert_eq!(slab.topology().face_count(), before.topology().face_count());
    }
}
