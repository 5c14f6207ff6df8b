//! Vertices where the original is far from the mesh, or the mesh from the original.

use glam::DVec3;
use mesh_core::{Handle, TriMesh, VertexId};
use mesh_metric::{ClosestPoint, weights_of_closest};

use crate::finish::fit::constraints::FitConstraints;
use crate::finish::fit::moves::try_move;
use crate::finish::peaks::points::Peaks;

impl Peaks<'_> {
    /// Moves vertices that are farther away than `bar` to the original. Returns them.
    pub(super) fn bring_back(
        &self,
        mesh: &mut TriMesh,
        constraints: &FitConstraints,
        bar: f64,
        most: usize,
    ) -> Vec<VertexId> {
        let is_fixed = |v| constraints.fixed.as_ref().and_then(|map| map.get(v)) == Some(&true);
        let mut moved = Vec::new();
        let mut before = Vec::new();
        for index in farthest_first(&self.backward, bar).into_iter().take(most) {
            let (v, closest) = (VertexId::from_index(index), &self.backward[index]);
            let on_line = mesh.topology().edges_of_vertex(v).any(|e| constraints.is_feature(e));
            before.clear();
            before.extend(mesh.topology().faces_of_vertex(v).map(|f| mesh.face_cross(f)));
            if !is_fixed(v) && !on_line && try_move(mesh, v, closest.point, &before) {
                moved.push(v);
            }
        }
        moved
    }

    /// Puts vertices at the points that are farther away than `bar`, the farthest first, no two of
    /// them at the same or at neighbouring faces. Returns them.
    pub(super) fn put_vertices(
        &self,
        mesh: &mut TriMesh,
        constraints: &FitConstraints,
        bar: f64,
        most: usize,
    ) -> Vec<VertexId> {
        let mut used = vec![false; mesh.topology().face_capacity()];
        let mut placed = Vec::new();
        for i in farthest_first(&self.forward, bar) {
            let face = self.forward[i].face;
            if used[face.index()] {
                continue;
            }
            for v in mesh.topology().face_vertices(face) {
                // Faces that were made here are beyond the end.
                let round = mesh.topology().faces_of_vertex(v);
                for f in round {
                    if let Some(used) = used.get_mut(f.index()) {
                        *used = true;
                    }
                }
            }
            placed.extend(put_vertex(mesh, constraints, self.points.all[i], &self.forward[i]));
            if placed.len() >= most {
                break;
            }
        }
        placed
    }
}

/// The indices of those that are farther away than `bar`, the farthest first.
fn farthest_first(closest: &[ClosestPoint], bar: f64) -> Vec<usize> {
    let distance = |i: usize| closest[i].distance;
    let mut far: Vec<usize> = (0..closest.len()).filter(|&i| distance(i) > bar).collect();
    far.sort_by(|&i, &j| distance(j).total_cmp(&distance(i)).then(i.cmp(&j)));
    far
}

/// Below this weight of a corner the closest point counts as on the side opposite to it.
const ON_SIDE: f64 = 0.1;

/// Splits the face or the edge that is closest to `point` there.
fn put_vertex(
    mesh: &mut TriMesh,
    constraints: &FitConstraints,
    point: DVec3,
    closest: &ClosestPoint,
) -> Option<VertexId> {
    let topology = mesh.topology();
    let weights = weights_of_closest(point, &mesh.triangle(closest.face)).to_array();
    let least = (0..3).min_by(|&i, &j| weights[i].total_cmp(&weights[j]))?;
    if weights[least] > ON_SIDE {
        let split = topology.check_split_face(closest.face).ok()?;
        return Some(mesh.split_face(split, point).vertex);
    }
    let edge = topology.face_half_edges(closest.face)[(least + 1) % 3].edge();
    if constraints.is_feature(edge) {
        return None;
    }
    let split = topology.check_split_edge(edge).ok()?;
    Some(mesh.split_edge(split, point).vertex)
}
