//! Faces that lie on the original upside down, and their repair.
//!
//! Every step keeps faces from turning too far at once, but a chain of small turns can turn a face over. Such a face is
//! found by the normals of the original around it. It is turned back by the flip of one of its edges, or by a move of
//! one of its vertices to the middle of the neighbours, whichever leaves the fewest such faces.

use glam::DVec3;
use mesh_collapse::NewIntersections;
use mesh_core::edit::LegalFlip;
use mesh_core::{EdgeId, FaceId, HalfEdgeId, TriMesh, VertexId};
use mesh_metric::Surface;

use crate::block_loop::values_in_turn;
use crate::face_quality::keeps_height;
use crate::fit::constraints::FitConstraints;
use crate::fit::flips::flip_crosses;
use crate::fit::moves::cross;

/// The largest number of passes over the faces that are turned over.
const PASSES: usize = 4;

/// The cosine between the normals of a face and of the original below which the face is turned over.
const TURNED: f64 = -0.1;

/// The number of faces in a block for one thread.
const BLOCK: usize = 1024;

/// A repair may take a point at most so many times as far from the original as the farthest point was before.
const FARTHER: f64 = 2.0;

/// Turns back the faces that are turned over against the original, where a flip or a move can do that. Returns the
/// numbers of these faces before and after.
pub fn unfold(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &FitConstraints,
    forbid_intersections: bool,
) -> [usize; 2] {
    let mut turned = turned_faces(mesh, original);
    let before = turned.len();
    if before == 0 {
        return [0; 2];
    }
    let mut found = forbid_intersections.then(|| NewIntersections::new(mesh));
    for _ in 0..PASSES {
        let count = turned.len();
        for face in turned {
            if is_turned(original, mesh.triangle(face)) {
                let mut repair = Repair { mesh, original, constraints, found: &mut found };
                repair.turn_back(face);
            }
        }
        turned = turned_faces(mesh, original);
        if turned.is_empty() || turned.len() >= count {
            break;
        }
    }
    [before, turned.len()]
}

/// All faces that are turned over. Only faces at a sharp edge are asked in detail: a face close to the other side of a
/// thin wall is no fold.
fn turned_faces(mesh: &TriMesh, original: &Surface) -> Vec<FaceId> {
    let faces: Vec<FaceId> = mesh.topology().faces().collect();
    let is_turned = values_in_turn(faces.len(), BLOCK, |range| {
        let faces = &faces[range];
        let centres: Vec<DVec3> = faces.iter().map(|&face| mesh.face_centroid(face)).collect();
        let closest = original.closest_to_neighbours(&centres).into_iter();
        let is_turned = |(&face, triangle): (&FaceId, u32)| {
            is_opposite(original, triangle, mesh.face_cross(face))
                && is_at_fold(mesh, face)
                && is_turned(original, mesh.triangle(face))
        };
        faces.iter().zip(closest.map(|closest| closest.triangle)).map(is_turned).collect()
    });
    faces.into_iter().zip(is_turned).filter(|&(_, turned)| turned).map(|(face, _)| face).collect()
}

/// Whether a neighbour of the face has an opposite normal.
fn is_at_fold(mesh: &TriMesh, face: FaceId) -> bool {
    let (topology, normal) = (mesh.topology(), mesh.face_cross(face));
    let neighbours = topology.face_half_edges(face).map(|h| topology.face(h.twin()));
    neighbours.into_iter().flatten().any(|other| mesh.face_cross(other).dot(normal) < 0.0)
}

fn is_opposite(original: &Surface, triangle: u32, normal: DVec3) -> bool {
    let surface = cross(original.triangle(triangle as usize));
    surface.dot(normal) < TURNED * surface.length() * normal.length()
}

/// Whether the normal of the original is opposite at points all over the triangle.
fn is_turned(original: &Surface, triangle: [DVec3; 3]) -> bool {
    let normal = cross(triangle);
    points(triangle)
        .into_iter()
        .all(|point| is_opposite(original, original.closest(point).triangle, normal))
}

/// The centroid, and points between it and the corners.
fn points([a, b, c]: [DVec3; 3]) -> [DVec3; 4] {
    let near = |p: DVec3, q: DVec3, r: DVec3| p + 0.2 * ((q - p) + (r - p));
    [a + ((b - a) + (c - a)) / 3.0, near(a, b, c), near(b, c, a), near(c, a, b)]
}

/// The number of faces that are turned over, and the largest distance of their points from the original.
fn state(original: &Surface, faces: &[[DVec3; 3]]) -> (usize, f64) {
    let turned = faces.iter().filter(|&&face| is_turned(original, face)).count();
    let points = faces.iter().flat_map(|&face| points(face));
    (turned, points.map(|point| original.distance(point)).fold(0.0, f64::max))
}

/// A change of some faces.
enum Change {
    Flip(LegalFlip),
    Move(VertexId, DVec3),
}

struct Repair<'a> {
    mesh: &'a mut TriMesh,
    original: &'a Surface,
    constraints: &'a FitConstraints,
    found: &'a mut Option<NewIntersections>,
}

impl Repair<'_> {
    /// Makes the change that leaves the fewest faces turned over around a face, if it is fewer than now.
    fn turn_back(&mut self, face: FaceId) {
        let topology = self.mesh.topology();
        let edges = topology.face_half_edges(face).map(HalfEdgeId::edge);
        let flips = edges.into_iter().filter_map(|edge| self.flip(edge));
        let moves = topology.face_vertices(face).into_iter().filter_map(|v| self.moved(v));
        let best = flips.chain(moves).min_by_key(|&(left, _)| left);
        match best {
            Some((_, Change::Flip(flip))) => {
                let edge = flip.edge();
                self.mesh.flip(flip);
                let faces = self.mesh.topology().edge_faces(edge).into_iter().flatten();
                if let Some(found) = &mut self.found {
                    found.update(self.mesh, faces);
                }
            }
            Some((_, Change::Move(v, to))) => {
                self.mesh.positions_mut()[v.index()] = to;
                let faces = self.mesh.topology().faces_of_vertex(v);
                if let Some(found) = &mut self.found {
                    found.update(self.mesh, faces);
                }
            }
            None => {}
        }
    }

    /// The flip of an edge, if it is allowed, and how many more faces it turns over: always fewer than none.
    fn flip(&self, edge: EdgeId) -> Option<(isize, Change)> {
        let topology = self.mesh.topology();
        if self.constraints.is_held(edge) || !self.constraints.limits.allow_flip(self.mesh, edge) {
            return None;
        }
        let flip = topology.check_flip(edge).ok()?;
        let [a, b, c, d] = flip.quad().map(|v| self.mesh.position(v));
        let (old, new) = ([[a, b, c], [b, a, d]], [[c, a, d], [d, b, c]]);
        let gain = self.gain(&old, &new)?;
        if !keeps_height(new, old) {
            return None;
        }
        if self.found.as_ref().is_some_and(|found| flip_crosses(self.mesh, found, &flip)) {
            return None;
        }
        Some((gain, Change::Flip(flip)))
    }

    /// The move of a vertex to the middle of its neighbours on the original, if it is allowed; else as [`Self::flip`].
    fn moved(&self, v: VertexId) -> Option<(isize, Change)> {
        let topology = self.mesh.topology();
        let is_on_line = topology.edges_of_vertex(v).any(|e| self.constraints.is_held(e));
        if topology.is_boundary_vertex(v) || is_on_line || self.constraints.is_fixed(topology, v) {
            return None;
        }
        let ring: Vec<DVec3> = topology.one_ring(v).map(|w| self.mesh.position(w)).collect();
        let from = self.mesh.position(v);
        let mean = from + ring.iter().map(|&p| p - from).sum::<DVec3>() / ring.len() as f64;
        let to = self.original.closest(mean).point;
        if !self.constraints.limits.allow_move(self.mesh, v, to) {
            return None;
        }
        let faces: Vec<FaceId> = topology.faces_of_vertex(v).collect();
        let old: Vec<[DVec3; 3]> = faces.iter().map(|&face| self.mesh.triangle(face)).collect();
        let at = |w: VertexId| if w == v { to } else { self.mesh.position(w) };
        let new: Vec<[DVec3; 3]> =
            faces.iter().map(|&face| topology.face_vertices(face).map(at)).collect();
        let gain = self.gain(&old, &new)?;
        let keeps_heights = || old.iter().zip(&new).all(|(&old, &new)| keeps_height([new], [old]));
        let crosses =
            || self.found.as_ref().is_some_and(|found| found.would_arise_at(self.mesh, v, to));
        (keeps_heights() && !crosses()).then_some((gain, Change::Move(v, to)))
    }

    /// How many more faces are turned over after a change, if it is fewer than none and the faces stay close to the
    /// original.
    fn gain(&self, old: &[[DVec3; 3]], new: &[[DVec3; 3]]) -> Option<isize> {
        let ((before, near), (after, far)) = (state(self.original, old), state(self.original, new));
        let gain = after as isize - before as isize;
        (gain < 0 && far <= FARTHER * near).then_some(gain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        for &v in &inner {
            let mut mesh = flat.clone();
            // Beyond one of the neighbours.
            let to = mesh.topology().one_ring(v).next().map(|w| mesh.position(w)).unwrap();
            let from = mesh.position(v);
            mesh.positions_mut()[v.index()] = from + 1.3 * (to - from);
            let [before, after] = unfold(&mut mesh, &original, &FitConstraints::default(), false);
            assert!(before > 0 && after == 0, "{v:?}: {before} {after}");
            assert!(mesh.topology().faces().all(|face| mesh.face_cross(face).z > 0.0));
        }
        let soup = mesh_shapes::polyhedra::cube();
        let mut slab = TriMesh::from_soup(&soup).unwrap();
        slab.positions_mut().iter_mut().for_each(|p| p.z *= 1e-4);
        let (surface, before) = (Surface::new(&slab).unwrap(), slab.clone());
        // One side further out, so that it is closest to the other one.
        slab.positions_mut().iter_mut().for_each(|p| p.z += 2e-3);
        let moved = slab.clone();
        unfold(&mut slab, &surface, &FitConstraints::default(), false);
        assert_eq!(slab.positions(), moved.positions());
        assert_eq!(slab.topology().face_count(), before.topology().face_count());
    }
}
