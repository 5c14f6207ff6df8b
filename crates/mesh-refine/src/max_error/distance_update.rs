//! Update of the distances after a change of the mesh.
//!
//! After a change of a few faces, only the points that were closest to them are measured again. Other points can only
//! have come closer to a face that has changed. Most changes are no improvement, and the first few distances show that.

use glam::DVec3;
use mesh_core::{FaceId, Remap, RemapOf, TriMesh, VertexId, as_u32};
use mesh_metric::{Surface, SurfaceError};

use crate::block_loop::{for_blocks_in_turn, values_in_turn};
use crate::max_error::elements::{Elements, is_unknown};
use crate::max_error::points::{BLOCK, Closest, Heights, Peaks};

/// The relation between the elements before and after a change.
#[derive(Clone, Copy)]
pub(super) enum Became<'r> {
    /// The handles are the same; positions may have changed.
    Same,
    /// The elements were renumbered.
    Other(&'r Remap),
}

impl Became<'_> {
    fn new_handle<H>(self, old: H) -> Option<H>
    where
        Remap: RemapOf<H>,
    {
        match self {
            Self::Same => Some(old),
            Self::Other(remap) => remap.new_handle(old),
        }
    }
}

/// The distances after a change of the mesh.
pub(super) struct Change {
    /// The new handle of each old face that has not moved.
    new_faces: Vec<Option<FaceId>>,
    /// The points that were measured again, in order, with their new faces.
    asked: Vec<(u32, Closest)>,
    elements: Elements,
    sums: [f64; 2],
    pub(super) heights: Heights,
}

impl Peaks<'_> {
    /// The distances of the mesh `mesh`, which was made from `before` and has no gaps; `None` if any distance reaches
    /// `bar`.
    pub(super) fn after(
        &self,
        before: &TriMesh,
        mesh: &TriMesh,
        original: &Surface,
        vertex_map: Became<'_>,
        bar: f64,
    ) -> Result<Option<Change>, SurfaceError> {
        let topology = mesh.topology();
        let (new_faces, mut elements) = self.kept(before, mesh, vertex_map);
        let is_far = |distance: f64| distance >= bar;
        if elements.distances().any(is_far) {
            return Ok(None);
        }
        let is_changed = |face: &FaceId| is_unknown(elements.of_face[face.index()]);
        let changed: Vec<FaceId> = topology.faces().filter(is_changed).collect();
        let triangles: Vec<[u32; 3]> =
            changed.iter().map(|&face| topology.face_vertices(face).map(VertexId::get)).collect();
        // If no face has changed, no point can have come closer.
        let nearby = Surface::from_triangles(mesh.positions(), &triangles).ok();
        if !self.far_points_come_closer(&new_faces, nearby.as_ref(), bar) {
            return Ok(None);
        }
        let faces: Vec<FaceId> = topology.faces().collect();
        elements.ask(mesh, original, &faces);
        if elements.distances().any(is_far) {
            return Ok(None);
        }
        let surface = Surface::new(mesh)?;
        let is_near = nearby.as_ref().map(|nearby| self.faces_near(before, nearby));
        let mut asked = Vec::new();
        for_blocks_in_turn(
            self.forward.len(),
            BLOCK,
            |range| {
                let old = &self.forward[range.clone()];
                let all = || range.clone().zip(old);
                let point = |number: usize| self.points.point(number);
                let is_near =
                    |face: FaceId| is_near.as_ref().is_some_and(|is_near| is_near[face.index()]);
                let has_gone = |old: &Closest| new_faces[old.face.index()].is_none();
                let gone = all().filter(|(_, old)| has_gone(old));
                let (gone, points_of_gone): (Vec<usize>, Vec<DVec3>) =
                    gone.map(|(index, _)| (index, point(index))).unzip();
                let anew = surface.closest_to_neighbours(&points_of_gone).into_iter();
                let anew = anew.map(|c| Closest { distance: c.distance, face: c.face });
                let near = all().filter(|(_, old)| !has_gone(old) && is_near(old.face));
                let near: Vec<(usize, f64)> =
                    near.map(|(index, old)| (index, old.distance)).collect();
                let points: Vec<DVec3> = near.iter().map(|&(index, _)| point(index)).collect();
                let bounds: Vec<f64> = near.iter().map(|&(_, bound)| bound).collect();
                let closer = nearby.as_ref().map(|nearby| nearby.closer_points(&points, &bounds));
                let closer = near.iter().zip(closer.into_iter().flatten());
                let closer = closer.filter_map(|(&(index, ..), found)| {
                    let found = found?;
                    let face = changed[found.triangle as usize];
                    Some((index, Closest { distance: found.distance, face }))
                });
                gone.into_iter().zip(anew).chain(closer).collect::<Vec<_>>()
            },
            |block| asked.extend(block.into_iter().map(|(index, new)| (as_u32(index), new))),
        );
        if asked.iter().any(|(_, new)| is_far(new.distance)) {
            return Ok(None);
        }
        asked.sort_unstable_by_key(|&(index, _)| index);
        let mut largest = elements.distances().fold(0.0, f64::max);
        let mut sums = self.sums;
        let mut next = asked.iter().copied().peekable();
        for (index, old) in self.forward.iter().enumerate() {
            let distance = match next.next_if(|&(asked, _)| asked as usize == index) {
                Some((_, new)) => {
                    if index >= self.points.samples {
                        sums[0] += new.distance - old.distance;
                        sums[1] += new.distance * new.distance - old.distance * old.distance;
                    }
                    new.distance
                }
                None => old.distance,
            };
            largest = largest.max(distance);
        }
        let heights = self.points.heights(largest, sums);
        Ok(Some(Change { new_faces, asked, elements, sums, heights }))
    }

    /// Replaces the distances by the distances after a change.
    pub(super) fn take_up(&mut self, change: Change) {
        for closest in &mut self.forward {
            if let Some(new) = change.new_faces[closest.face.index()] {
                closest.face = new;
            }
        }
        for (index, new) in change.asked {
            self.forward[index as usize] = new;
        }
        (self.elements, self.sums, self.heights) = (change.elements, change.sums, change.heights);
    }

    /// The new handle of each face that has not moved, and the distances of all elements that have not moved.
    fn kept(
        &self,
        before: &TriMesh,
        mesh: &TriMesh,
        vertex_map: Became<'_>,
    ) -> (Vec<Option<FaceId>>, Elements) {
        let (old_topology, topology) = (before.topology(), mesh.topology());
        let stays = |old: VertexId, new: VertexId| before.position(old) == mesh.position(new);
        let mut new_faces = vec![None; old_topology.face_capacity()];
        let mut elements = Elements::unknown(topology);
        for old in old_topology.faces() {
            let Some(new) = vertex_map.new_handle(old) else { continue };
            if before.triangle(old) == mesh.triangle(new) {
                new_faces[old.index()] = Some(new);
                elements.of_face[new.index()] = self.elements.of_face[old.index()];
            }
        }
        for old in old_topology.vertices() {
            if let Some(new) = vertex_map.new_handle(old).filter(|&new| stays(old, new)) {
                elements.of_vertex[new.index()] = self.elements.of_vertex[old.index()];
            }
        }
        for old in old_topology.edges() {
            let Some(new) = vertex_map.new_handle(old) else { continue };
            let [a, b] = old_topology.edge_vertices(old);
            let [p, q] = topology.edge_vertices(new);
            if stays(a, p) && stays(b, q) {
                elements.of_edge[new.index()] = self.elements.of_edge[old.index()];
            }
        }
        (new_faces, elements)
    }

    /// Whether all points at or above the bar, whose face has stayed, have fallen below it.
    fn far_points_come_closer(
        &self,
        new_faces: &[Option<FaceId>],
        nearby: Option<&Surface>,
        bar: f64,
    ) -> bool {
        let far = self.forward.iter().enumerate().filter(|(_, closest)| closest.distance >= bar);
        let stayed = far.filter(|(_, closest)| new_faces[closest.face.index()].is_some());
        let points: Vec<DVec3> = stayed.map(|(number, _)| self.points.point(number)).collect();
        let bounds = vec![bar; points.len()];
        points.is_empty()
            || nearby.is_some_and(|nearby| {
                nearby.closer_points(&points, &bounds).iter().all(Option::is_some)
            })
    }

    /// Whether each face has points that may be closer to another surface. A point at the distance d from its face is
    /// at most r + d from the centroid of the face, where r is the distance of the farthest corner. So any surface
    /// closer to the point than d is within r + 2 d of the centroid.
    fn faces_near(&self, mesh: &TriMesh, other: &Surface) -> Vec<bool> {
        let topology = mesh.topology();
        let mut farthest = vec![0.0_f64; topology.face_capacity()];
        for closest in &self.forward {
            let farthest = &mut farthest[closest.face.index()];
            *farthest = farthest.max(closest.distance);
        }
        let faces: Vec<FaceId> = topology.faces().collect();
        let are_near = values_in_turn(faces.len(), BLOCK, |range| {
            let balls = faces[range].iter().map(|&face| {
                let triangle = mesh.triangle(face);
                let centroid = triangle.iter().sum::<DVec3>() / 3.0;
                let corners = triangle.iter().map(|corner| corner.distance_squared(centroid));
                let radius = corners.fold(0.0, f64::max).sqrt() + 2.0 * farthest[face.index()];
                (centroid, (1.0 + ROUNDING) * radius)
            });
            let (centroids, radii): (Vec<DVec3>, Vec<f64>) = balls.unzip();
            let found = other.closer_points(&centroids, &radii);
            found.iter().map(Option::is_some).collect()
        });
        let mut is_near = vec![false; topology.face_capacity()];
        for (face, near) in faces.iter().zip(are_near) {
            is_near[face.index()] = near;
        }
        is_near
    }
}

/// A bound on the relative rounding error of distances between points of a mesh.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::max_error::points::Points;
    use crate::max_error::points::tests::plane;
    use mesh_core::EdgeId;

    /// The updated distances equal the distances computed again from the start.
    fn check_after(before: &TriMesh, after: &TriMesh, original: &Surface, vertex_map: Became<'_>) {
        let points = Points::new(original, 0.5, 400);
        let old = Peaks::new(before, original, &points).unwrap();
        let anew = Peaks::new(after, original, &points).unwrap();
        let under = |bar: f64| old.after(before, after, original, vertex_map, bar).unwrap();
        let mut found = old.clone();
        found.take_up(under(f64::INFINITY).unwrap());
        assert_eq!(found.elements, anew.elements);
        let distances = |p: &Peaks<'_>| p.forward.iter().map(|c| c.distance).collect::<Vec<_>>();
        assert_eq!(distances(&found), distances(&anew));
        assert_ne!(distances(&found), distances(&old));
        for (point, closest) in points.points(0..points.len()).into_iter().zip(&found.forward) {
            let triangle = after.triangle(closest.face);
            let distance = mesh_metric::closest_on_triangle(point, &triangle).length();
            assert!((distance - closest.distance).abs() < 1e-12);
        }
        let (ours, theirs) = (found.heights, anew.heights);
        assert_eq!(ours.largest, theirs.largest);
        assert!((ours.mean / theirs.mean - 1.0).abs() < 1e-13);
        assert!((ours.rms / theirs.rms - 1.0).abs() < 1e-13);
        // With a bar, the result tells whether the largest distance is below it.
        assert!(under(theirs.largest).is_none() && under(0.5 * theirs.largest).is_none());
        assert!(under(1.000_001 * theirs.largest).is_some());
    }

    #[test]
    fn after_a_change_only_the_rest_is_kept() {
        let wave = |p: DVec3| p.with_z(0.2 * (4.0 * p.x).sin() * (3.0 * p.y).cos());
        let original = Surface::new(&plane(1.0, 30, wave)).unwrap();
        let before = plane(1.0, 9, |p| wave(p) + 0.01 * DVec3::Z);
        let mut moved = before.clone();
        moved.positions_mut()[45].z += 0.3;
        moved.positions_mut()[12].z -= 0.2;
        check_after(&before, &moved, &original, Became::Same);
        // After a split, a collapse and renumbering.
        let mut other = before.clone();
        let face = other.topology().faces().nth(77).unwrap();
        let at = other.triangle(face).iter().sum::<DVec3>() / 3.0 + 0.4 * DVec3::Z;
        let split = other.topology().check_split_face(face).unwrap();
        other.split_face(split, at);
        let edges: Vec<EdgeId> = other.topology().edges().collect();
        let legal =
            edges.into_iter().find_map(|e| other.topology().check_collapse(e.half_edges()[0]).ok());
        other.collapse(legal.unwrap(), DVec3::new(0.1, 0.2, 0.3));
        let remap = other.compact();
        check_after(&before, &other, &original, Became::Other(&remap));
    }
}
