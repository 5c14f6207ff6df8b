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

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use mesh_core::{EdgeMap, Topology, TriMesh, VertexId};
    use mesh_metric::{ClosestPoint, Surface};

    use super::{FitConstraints, farthest_first, put_vertex};

    const CORNERS: [DVec3; 3] = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 4.0, 0.0)];

    fn triangle() -> TriMesh {
        TriMesh::from_triangles(&CORNERS, &[[0, 1, 2]]).expect("a triangle")
    }

    /// Puts a vertex above the point of a triangle with these weights.
    fn put(weights: [f64; 3], constraints: &FitConstraints) -> (TriMesh, Option<VertexId>) {
        let mut mesh = triangle();
        let below: DVec3 =
            weights.iter().zip(CORNERS).map(|(weight, corner)| *weight * corner).sum();
        let point = below + DVec3::Z;
        let surface = Surface::new(&mesh).expect("a face");
        let closest = surface.closest_points(&[point])[0];
        let vertex = put_vertex(&mut mesh, constraints, point, &closest);
        mesh.topology().validate().expect("a split keeps the invariants");
        if let Some(vertex) = vertex {
            assert_eq!(mesh.position(vertex), point);
        }
        (mesh, vertex)
    }

    fn neighbours(topology: &Topology, vertex: VertexId) -> Vec<u32> {
        let mut found: Vec<u32> = topology.one_ring(vertex).map(VertexId::get).collect();
        found.sort_unstable();
        found
    }

    #[test]
    fn faces_are_split_inside_and_edges_next_to_them() {
        let free = FitConstraints::default();
        for least in 0..3 {
            let with = |weight: f64| {
                let mut weights = [0.5 * (1.0 - weight); 3];
                weights[least] = weight;
                weights
            };
            for inside in [0.11, 0.3] {
                let (mesh, vertex) = put(with(inside), &free);
                let vertex = vertex.expect("a face can be split");
                assert_eq!(mesh.topology().face_count(), 3);
                assert_eq!(neighbours(mesh.topology(), vertex), [0, 1, 2]);
            }
            for beside in [0.09, 0.01, 0.0] {
                let (mesh, vertex) = put(with(beside), &free);
                let vertex = vertex.expect("an edge can be split");
                let topology = mesh.topology();
                assert_eq!(topology.face_count(), 2);
                assert_eq!(neighbours(topology, vertex), [0, 1, 2]);
                // The side opposite to the corner of least weight is in two parts now.
                let [a, b] = [1, 2].map(|next| VertexId::new(((least + next) % 3) as u32));
                assert_eq!(topology.find_half_edge(a, b), None);
                assert_eq!(topology.find_half_edge(b, a), None);
            }
        }
    }

    #[test]
    fn feature_edges_are_not_split() {
        let features = Some(EdgeMap::from_vec(vec![true; 3]));
        let kept = FitConstraints { features, ..FitConstraints::default() };
        assert_eq!(put([0.05, 0.5, 0.45], &kept).1, None);
        assert!(put([0.2, 0.4, 0.4], &kept).1.is_some());
    }

    #[test]
    fn the_farthest_come_first_and_the_bar_is_left_out() {
        let at = |distance| ClosestPoint { distance, ..closest() };
        let all = [1.0, 3.0, 2.0, 3.0, 0.5].map(at);
        assert_eq!(farthest_first(&all, 1.0), [1, 3, 2]);
        assert_eq!(farthest_first(&all, 3.0), [0_usize; 0]);
    }

    fn closest() -> ClosestPoint {
        Surface::new(&triangle()).expect("a face").closest_points(&[DVec3::ZERO])[0]
    }
}
