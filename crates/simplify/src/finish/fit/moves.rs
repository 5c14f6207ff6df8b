//! Moving vertices as far as their faces allow.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh, VertexId, parallel};

use crate::collapse::intersection::Intersections;
use crate::finish::fit::constraints::FitConstraints;
use crate::finish::fit::freedom::Freedom;

/// The smallest cosine between the normals of faces before and after a flip or a move.
const MIN_COSINE: f64 = 0.5;

/// Whether a face with the vector area `new` is turned by less than sixty degrees from `old`.
pub(super) fn keeps_side(new: DVec3, old: DVec3) -> bool {
    new.dot(old) > MIN_COSINE * new.length() * old.length()
}

/// Displacements of vertices, and what they may do.
pub(super) struct Moves<'a> {
    pub(super) displacements: &'a [(VertexId, DVec3)],
    pub(super) freedoms: &'a [Freedom],
    pub(super) constraints: &'a FitConstraints,
}

impl Moves<'_> {
    /// Moves each vertex by its displacement, or by half or a quarter of it, or not at all, so that no
    /// face turns too far.
    pub(super) fn carry_out(&self, mesh: &mut TriMesh, mut found: Option<&mut Intersections>) {
        let others = match found {
            None => self.move_together(mesh),
            Some(_) => (0..self.displacements.len()).collect(),
        };
        let mut before: Vec<DVec3> = Vec::new();
        for i in others {
            let (v, displacement) = self.displacements[i];
            if displacement == DVec3::ZERO || !displacement.is_finite() {
                continue;
            }
            before.clear();
            before.extend(mesh.topology().faces_of_vertex(v).map(|f| mesh.face_cross(f)));
            for part in [1.0, 0.5, 0.25] {
                let to = self.place(mesh, i, part);
                let crosses = found.as_ref().is_some_and(|found| found.would_arise_at(mesh, v, to));
                if !crosses && try_move(mesh, v, to, &before) {
                    if let Some(found) = &mut found {
                        found.update(mesh, mesh.topology().faces_of_vertex(v));
                    }
                    break;
                }
            }
        }
    }

    /// Moves all vertices at the same time, but for those of faces that would turn too far, which are left where they
    /// are. These are the numbers of their displacements.
    fn move_together(&self, mesh: &mut TriMesh) -> Vec<usize> {
        let places = parallel::collect(self.displacements.len(), |i| self.place(mesh, i, 1.0));
        let before = mesh.positions().to_vec();
        for (&(v, _), place) in self.displacements.iter().zip(places) {
            if place.is_finite() {
                mesh.positions_mut()[v.index()] = place;
            }
        }
        let mut faces: Vec<FaceId> = mesh.topology().faces().collect();
        while !faces.is_empty() {
            let turns: Vec<bool> = parallel::collect(faces.len(), |i| {
                let corners = mesh.topology().face_vertices(faces[i]);
                let [a, b, c] = corners.map(|v| before[v.index()]);
                !keeps_side(mesh.face_cross(faces[i]), (b - a).cross(c - a))
            });
            // With their vertices back, those next to them are other faces.
            let mut changed = Vec::new();
            for (&face, _) in faces.iter().zip(turns).filter(|&(_, turns)| turns) {
                for v in mesh.topology().face_vertices(face) {
                    if mesh.position(v) != before[v.index()] {
                        mesh.positions_mut()[v.index()] = before[v.index()];
                        changed.extend(mesh.topology().faces_of_vertex(v));
                    }
                }
            }
            faces = changed;
        }
        let is_left = |&i: &usize| {
            let (v, displacement) = self.displacements[i];
            displacement != DVec3::ZERO && mesh.position(v) == before[v.index()]
        };
        (0..self.displacements.len()).filter(is_left).collect()
    }

    /// Where a part of its displacement brings a vertex.
    fn place(&self, mesh: &TriMesh, i: usize, part: f64) -> DVec3 {
        let (v, displacement) = self.displacements[i];
        let from = mesh.position(v);
        let Some(curve) = self.freedoms[v.index()].curve(self.constraints) else {
            return from + part * displacement;
        };
        let most = 0.5 * shortest_edge(mesh, v);
        let free = from + part * displacement.clamp_length_max(most);
        // As far from the curve as it was.
        from + (curve.closest(free) - curve.closest(from))
    }
}

fn shortest_edge(mesh: &TriMesh, v: VertexId) -> f64 {
    let lengths = mesh.topology().one_ring(v).map(|w| mesh.position(w).distance(mesh.position(v)));
    lengths.fold(f64::INFINITY, f64::min)
}

/// Moves a vertex unless that turns a face too far from its normal before.
pub(crate) fn try_move(mesh: &mut TriMesh, v: VertexId, to: DVec3, before: &[DVec3]) -> bool {
    let from = mesh.position(v);
    mesh.positions_mut()[v.index()] = to;
    let faces = mesh.topology().faces_of_vertex(v);
    let fits = faces.zip(before).all(|(f, old)| keeps_side(mesh.face_cross(f), *old));
    if !fits {
        mesh.positions_mut()[v.index()] = from;
    }
    fits
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::shapes::Plane;

    /// All go the whole way but one, which would turn faces over.
    #[test]
    fn a_vertex_goes_as_far_as_its_faces_allow() {
        let soup = Plane { half_width: 1.0 }.mesh(6, Default::default()).unwrap();
        let mut mesh = TriMesh::from_soup(&soup).unwrap();
        let before = mesh.clone();
        let topology = before.topology();
        let far = |v: VertexId| before.position(v).length() < 0.1;
        let displacements: Vec<(VertexId, DVec3)> = topology
            .vertices()
            .filter(|&v| !topology.is_boundary_vertex(v))
            .map(|v| (v, if far(v) { 0.5 * DVec3::X } else { 0.01 * DVec3::Z }))
            .collect();
        let freedoms = vec![Freedom::Free; topology.vertex_capacity()];
        let constraints = FitConstraints::default();
        let (displacements, freedoms, constraints) = (&*displacements, &*freedoms, &constraints);
        Moves { displacements, freedoms, constraints }.carry_out(&mut mesh, None);
        assert_eq!(displacements.iter().filter(|&&(v, _)| far(v)).count(), 1);
        for &(v, displacement) in displacements {
            // The next vertex is a third away.
            let part = if far(v) { 0.5 } else { 1.0 };
            assert_eq!(mesh.position(v), before.position(v) + part * displacement);
        }
    }
}
