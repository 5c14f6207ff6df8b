//! Moves and insertion of vertices where the mesh and the original are far apart.

use glam::DVec3;
use mesh_collapse::NewIntersections;
use mesh_core::crossing::Triangle;
use mesh_core::{EdgeId, FaceId, Handle, TriMesh, VertexId};
use mesh_metric::{Surface, weights_of_closest};

use crate::face_quality::{is_sliver, keeps_side};
use crate::fit::constraints::FitConstraints;
use crate::fit::moves::{cross, try_move};
use crate::max_error::points::Peaks;

impl Peaks<'_> {
    /// Moves vertices that are farther away than `bar` to the original, at most `most` of them. Returns these vertices.
    pub(super) fn bring_back(
        &self,
        mesh: &mut TriMesh,
        original: &Surface,
        (constraints, found): (&FitConstraints, &mut Option<NewIntersections>),
        bar: f64,
        most: usize,
    ) -> Vec<VertexId> {
        let mut moved = Vec::new();
        for index in
            farthest_first(self.elements.of_vertex.iter().copied(), bar).into_iter().take(most)
        {
            let v = VertexId::from_index(index);
            let to = original.closest(mesh.position(v)).point;
            let topology = mesh.topology();
            let on_line = topology.edges_of_vertex(v).any(|e| constraints.is_feature(e));
            if constraints.is_fixed(topology, v) || on_line {
                continue;
            }
            if found.as_ref().is_some_and(|found| found.would_arise_at(mesh, v, to)) {
                continue;
            }
            if try_move(mesh, &constraints.limits, v, to) {
                moved.push(v);
                if let Some(found) = found {
                    found.update(mesh, mesh.topology().faces_of_vertex(v));
                }
            }
        }
        moved
    }

    /// Inserts vertices at the points that are farther away than `bar`, the farthest first. No two of them are at the
    /// same face or at neighbouring faces. Returns the new vertices.
    ///
    /// If the mesh itself is farthest, at the middle of an edge, such edges come first: an edge along a rim that cuts a
    /// corner of the rim, for example. No point of the original need be far there.
    pub(super) fn put_vertices(
        &self,
        mesh: &mut TriMesh,
        original: &Surface,
        (constraints, found): (&FitConstraints, &mut Option<NewIntersections>),
        bar: f64,
        most: usize,
    ) -> Vec<VertexId> {
        let mut used = vec![false; mesh.topology().face_capacity()];
        let mut placed = Vec::new();
        for (edge, face) in self.far_edges(mesh, bar) {
            if placed.len() < most && take_round(mesh, &mut used, face) {
                let [a, b] = mesh.segment(edge);
                let to = original.closest(a + 0.5 * (b - a)).point;
                placed.extend(put_vertex(mesh, (constraints, found), to, face, Some(edge)));
            }
        }
        for i in farthest_first(self.forward.iter().map(|closest| closest.distance), bar) {
            if placed.len() >= most {
                break;
            }
            let face = self.forward[i].face;
            if take_round(mesh, &mut used, face) {
                let to = self.points.point(i);
                placed.extend(put_vertex(mesh, (constraints, found), to, face, None));
            }
        }
        placed
    }

    /// The edges whose middle is farther away than `bar`, each with a face beside it, if one of them is farther than
    /// anything else.
    fn far_edges(&self, mesh: &TriMesh, bar: f64) -> Vec<(EdgeId, FaceId)> {
        let distances = || self.elements.of_edge.iter().copied();
        if distances().fold(0.0, f64::max) < self.heights.largest {
            return Vec::new();
        }
        let with_face = |index: usize| {
            let edge = EdgeId::from_index(index);
            let face = mesh.topology().edge_faces(edge).into_iter().flatten().next()?;
            Some((edge, face))
        };
        farthest_first(distances(), bar).into_iter().filter_map(with_face).collect()
    }
}

/// Marks a face and the faces around it, unless the face is marked.
fn take_round(mesh: &TriMesh, used: &mut [bool], face: FaceId) -> bool {
    if used[face.index()] {
        return false;
    }
    for v in mesh.topology().face_vertices(face) {
        for f in mesh.topology().faces_of_vertex(v) {
            // Faces made since are beyond the end of the list.
            if let Some(used) = used.get_mut(f.index()) {
                *used = true;
            }
        }
    }
    true
}

/// The indices of the distances above `bar`, the farthest first.
fn farthest_first(distances: impl Iterator<Item = f64>, bar: f64) -> Vec<usize> {
    let mut far: Vec<(usize, f64)> = distances.enumerate().filter(|&(_, d)| d > bar).collect();
    far.sort_by(|(i, d), (j, e)| e.total_cmp(d).then(i.cmp(j)));
    far.into_iter().map(|(i, _)| i).collect()
}

/// Below this weight of a corner, the closest point counts as lying on the opposite side.
const ON_SIDE: f64 = 0.1;

/// Splits an edge of a face, or else the face or its edge closest to `point`, and puts the new vertex at this point.
/// Does nothing if the edge or face must stay as it is, if a sliver would arise, if a limit would be exceeded, if a
/// face beside a given edge would turn too far, or if `found` is given and faces would intersect.
fn put_vertex(
    mesh: &mut TriMesh,
    (constraints, found): (&FitConstraints, &mut Option<NewIntersections>),
    point: DVec3,
    face: FaceId,
    given: Option<EdgeId>,
) -> Option<VertexId> {
    let topology = mesh.topology();
    let weights = weights_of_closest(point, &mesh.triangle(face)).to_array();
    let least = (0..3).min_by(|&i, &j| weights[i].total_cmp(&weights[j]))?;
    let edge = topology.face_half_edges(face)[(least + 1) % 3].edge();
    let split_edge = given.or((weights[least] <= ON_SIDE).then_some(edge));
    if split_edge.is_some_and(|e| constraints.is_held(e) || is_locked(mesh, constraints, e)) {
        return None;
    }
    let limits = &constraints.limits;
    let is_allowed = match split_edge {
        Some(edge) => limits.allow_edge_split(mesh, edge, point),
        None => {
            let is_kept = topology.face_edges(face).iter().all(|&e| constraints.is_held(e));
            !is_kept && limits.allow_face_split(mesh, topology.face_vertices(face), point)
        }
    };
    if !is_allowed {
        return None;
    }
    let gone = match split_edge {
        Some(edge) => topology.edge_faces(edge),
        None => [Some(face), None],
    };
    let gone: Vec<FaceId> = gone.into_iter().flatten().collect();
    let new = fan(mesh, &gone, split_edge, point);
    if new.iter().any(|&(_, corners)| is_sliver(corners)) {
        return None;
    }
    // The point may be beside the edge.
    let side = gone.iter().map(|&face| mesh.face_cross(face)).sum();
    if given.is_some() && !new.iter().all(|&(_, corners)| keeps_side(cross(corners), side)) {
        return None;
    }
    if let Some(found) = found
        && found.would_arise_instead(mesh, &gone, &new)
    {
        return None;
    }
    let vertex = match split_edge {
        Some(edge) => {
            let split = topology.check_split_edge(edge).ok()?;
            mesh.split_edge(split, point).vertex
        }
        None => {
            let split = topology.check_split_face(face).ok()?;
            mesh.split_face(split, point).vertex
        }
    };
    if let Some(found) = found {
        found.update(mesh, mesh.topology().faces_of_vertex(vertex));
    }
    Some(vertex)
}

/// Whether a boundary edge must stay as it is: the boundary does not move, or both ends are fixed.
fn is_locked(mesh: &TriMesh, constraints: &FitConstraints, edge: EdgeId) -> bool {
    let topology = mesh.topology();
    let ends = topology.edge_vertices(edge);
    topology.is_boundary_edge(edge) && ends.iter().all(|&v| constraints.is_fixed(topology, v))
}

/// The triangles that replace faces when a vertex at `point` is joined to all their sides except the split edge.
fn fan(
    mesh: &TriMesh,
    faces: &[FaceId],
    split_edge: Option<EdgeId>,
    point: DVec3,
) -> Vec<Triangle> {
    let topology = mesh.topology();
    let new = VertexId::from_index(topology.vertex_capacity());
    let sides = faces.iter().flat_map(|&f| topology.face_half_edges(f));
    let kept = sides.filter(|side| Some(side.edge()) != split_edge);
    let triangle = |side| {
        let [a, b] = [topology.origin(side), topology.target(side)];
        ([a, b, new], [mesh.position(a), mesh.position(b), point])
    };
    kept.map(triangle).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::curve::Curve;
    use crate::max_error::points::Points;

    /// A square of two triangles; the diagonal goes from the first to the third vertex.
    fn square() -> TriMesh {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        TriMesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap()
    }

    #[test]
    fn points_close_to_a_side_split_the_side() {
        // The distance from the diagonal, along x, is the weight of the corner opposite to it.
        let edges_after = |weight: f64| {
            let mut mesh = square();
            let point = DVec3::new(0.5 + weight, 0.5, 0.25);
            let face = Surface::new(&mesh).unwrap().closest(point).face;
            let free = FitConstraints::default();
            let vertex = put_vertex(&mut mesh, (&free, &mut None), point, face, None).unwrap();
            assert_eq!((mesh.position(vertex), mesh.topology().face_count()), (point, 4));
            mesh.topology().valence(vertex)
        };
        assert_eq!(edges_after(0.101), 3);
        assert_eq!(edges_after(0.099), 4);
    }

    #[test]
    fn the_farthest_come_first_and_what_is_at_the_bar_stays() {
        let distances = [0.5, 0.7, 0.9, 0.70001, 0.9];
        assert_eq!(farthest_first(distances.into_iter(), 0.7), [2, 4, 3]);
    }

    /// A sheet with a notch, and a coarse mesh whose rim goes straight across it: the middle of that edge is far from
    /// the sheet, and no point of the sheet is far from the mesh.
    #[test]
    fn an_edge_across_a_notch_of_the_rim_is_split_there() {
        let sheet = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.9, 1.0], [0.0, 2.0]];
        let sheet = sheet.map(|[x, y]| [x, y, 0.0]);
        let triangles = [[0, 1, 3], [1, 2, 3], [0, 3, 4]];
        let whole = TriMesh::from_triangles(&sheet, &triangles).unwrap();
        let original = Surface::new(&whole).unwrap();
        let corners = [sheet[0], sheet[1], sheet[2], sheet[4]];
        let mut mesh = TriMesh::from_triangles(&corners, &[[0, 1, 3], [1, 2, 3]]).unwrap();
        let points = Points::new(&original, 3.0, 2);
        let peaks = Peaks::new(&mesh, &original, &points).unwrap();
        let middle = 2.21_f64.sqrt().recip();
        assert!((peaks.heights.largest - middle).abs() < 1e-12);
        assert!(peaks.forward.iter().all(|closest| closest.distance < 1e-12));
        let boundary_curve = Curve::boundary(&whole).map(Arc::new);
        let free = FitConstraints { boundary_curve, ..FitConstraints::default() };
        let bar = 0.9 * middle;
        let placed = peaks.put_vertices(&mut mesh, &original, (&free, &mut None), bar, 5);
        assert_eq!(placed.len(), 1);
        let v = placed[0];
        assert!(mesh.topology().is_boundary_vertex(v));
        assert!(original.distance(mesh.position(v)) < 1e-12);
        assert!(Peaks::new(&mesh, &original, &points).unwrap().heights.largest < 0.8 * middle);
    }
}
