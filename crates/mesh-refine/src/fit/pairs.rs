//! Points of the original and the faces of the mesh that they attract.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh, as_u32};
use mesh_metric::{Surface, closest_on_triangle};

use crate::block_loop::for_blocks_in_turn;
use crate::face_lists::FaceLists;
use crate::fit::targets::{FitTarget, Ground, Targets};
use crate::fit::walk::{End, walk_to};
use crate::norm::Power;

/// Points listed by the face closest to them: the targets, and some additional points.
pub(super) struct Pairs<'a> {
    targets: Targets<'a>,
    /// Additional points.
    more: Vec<FitTarget>,
    lists: FaceLists,
    /// The squared distance of each point from its face.
    squares: Vec<f64>,
}

/// The faces that targets were near to earlier.
#[derive(Clone, Copy)]
enum Near<'f> {
    Nothing,
    /// A face for each target.
    Targets(&'f [FaceId]),
    /// A face for each place in the order of the triangles of the original.
    Places(&'f [Option<FaceId>]),
}

/// The number of points in a block for one thread.
const BLOCK: usize = 1024;

impl<'a> Pairs<'a> {
    /// Pairs the targets with the closest faces.
    pub(super) fn new(mesh: &TriMesh, surface: &Surface, targets: Targets<'a>) -> Self {
        let mut new = Self::unpaired(mesh, targets);
        new.pair(mesh, surface, Near::Nothing);
        new
    }

    /// Pairs other targets of the same original after the vertices have moved. `faces` are the earlier faces of its
    /// triangles, see [`Pairs::faces_by_place`].
    pub(super) fn following(
        mesh: &TriMesh,
        surface: &Surface,
        targets: Targets<'a>,
        faces: &[Option<FaceId>],
    ) -> Self {
        let mut new = Self::unpaired(mesh, targets);
        new.pair(mesh, surface, Near::Places(faces));
        new
    }

    /// For each place in the order of the triangles of the original, the face of one of its targets. A triangle without
    /// targets gets the face of the last triangle before it that has one, which is usually a neighbour.
    pub(super) fn faces_by_place(&self, mesh: &TriMesh, triangles: usize) -> Vec<Option<FaceId>> {
        let mut faces = vec![None; triangles];
        for face in mesh.topology().faces() {
            let targets = self.lists.of_face(face).map(|index| index as usize);
            for index in targets.filter(|&index| index < self.targets.len()) {
                faces[self.targets.place(index)] = Some(face);
            }
        }
        let mut last = None;
        for face in &mut faces {
            last = face.or(last);
            *face = last;
        }
        faces
    }

    fn unpaired(mesh: &TriMesh, targets: Targets<'a>) -> Self {
        Self {
            lists: FaceLists::new(mesh.topology().face_capacity(), targets.len()),
            squares: Vec::with_capacity(targets.len()),
            targets,
            more: Vec::new(),
        }
    }

    /// Drops all distances, which become invalid when the vertices move, to free memory for the solution of the
    /// equations.
    pub(super) fn forget_distances(&mut self) {
        self.squares = Vec::new();
    }

    /// Pairs the targets again, after the vertices have moved.
    pub(super) fn follow(&mut self, mesh: &TriMesh, surface: &Surface) {
        let mut before = vec![FaceId::new(0); self.targets.len()];
        for face in mesh.topology().faces() {
            for index in self.lists.of_face(face) {
                if let Some(slot) = before.get_mut(index as usize) {
                    *slot = face;
                }
            }
        }
        self.more.clear();
        self.lists.clear_all();
        self.squares = Vec::with_capacity(self.targets.len());
        self.pair(mesh, surface, Near::Targets(&before));
    }

    /// Pairs all targets, block by block. A walk starts at the earlier face of the target, or at the face of the target
    /// before it. It ends at a face on which the foot of the target lies inside. This is usually the closest face; at a
    /// concave edge, the face beyond may be slightly closer. If the walk fails, the closest face is searched.
    fn pair(&mut self, mesh: &TriMesh, surface: &Surface, near: Near<'_>) {
        let Self { targets, lists, squares, .. } = self;
        for_blocks_in_turn(
            targets.len(),
            BLOCK,
            |indices| {
                let points = targets.points(indices.clone());
                let mut last = None;
                let (mut found, mut lost) = (Vec::with_capacity(points.len()), Vec::new());
                for (index, &point) in indices.zip(&*points) {
                    let before = match near {
                        Near::Nothing => None,
                        Near::Targets(faces) => Some(faces[index]),
                        Near::Places(faces) => faces[targets.place(index)],
                    };
                    let start = before.or(last).unwrap_or_else(|| surface.closest(point).face);
                    let foot;
                    (foot, last) = match walk_to(mesh, start, point, targets.normal(index)) {
                        End::Foot(face, squared) => (Some((face, squared)), Some(face)),
                        End::Face(face) => (None, Some(face)),
                        End::Elsewhere if before.is_some() => (None, None),
                        End::Elsewhere => {
                            // The next walk needs this result as its start.
                            let closest = surface.closest(point);
                            let squared = closest.offset.length_squared();
                            (Some((closest.face, squared)), Some(closest.face))
                        }
                    };
                    if foot.is_none() {
                        lost.push(point);
                    }
                    found.push(foot);
                }
                let closest = surface.closest_to_neighbours(&lost).into_iter();
                let mut closest = closest.map(|c| (c.face, c.offset.length_squared()));
                let found = found.into_iter().filter_map(|found| found.or_else(|| closest.next()));
                found.collect::<Vec<_>>()
            },
            |found| {
                for (face, squared) in found {
                    lists.push(face, as_u32(squares.len()));
                    squares.push(squared);
                }
            },
        );
    }

    /// The number of targets.
    pub(super) fn target_count(&self) -> usize {
        self.targets.len()
    }

    /// The largest squared distance.
    pub(super) fn largest(&self) -> f64 {
        self.squares.iter().copied().fold(0.0, f64::max)
    }

    /// The squared mean of this order of the distances.
    pub(super) fn mean(&self, power: Power) -> f64 {
        power.mean(&self.squares)
    }

    fn point(&self, index: usize) -> DVec3 {
        match index.checked_sub(self.targets.len()) {
            None => self.targets.point(index),
            Some(beyond) => self.more[beyond].point,
        }
    }

    /// The points that are closest to a face, each with its squared distance and the factor on it.
    pub(super) fn of_face(&self, face: FaceId) -> impl Iterator<Item = (DVec3, f64, f64)> + '_ {
        let indices = self.lists.of_face(face).map(|index| index as usize);
        indices.map(|index| (self.point(index), self.squares[index], self.importance(index)))
    }

    /// The factor on the squared distance of a point.
    #[inline]
    fn importance(&self, index: usize) -> f64 {
        if index < self.targets.len() { self.targets.importance_of(index) } else { 1.0 }
    }

    /// The sum of the distances of the points closest to a face, each raised to the power.
    pub(super) fn sum_of(&self, face: FaceId, power: Power) -> f64 {
        let indices = self.lists.of_face(face);
        let indices = indices.map(|index| index as usize);
        indices.map(|index| self.importance(index) * power.of(self.squares[index])).sum()
    }

    /// Calls `act` with the targets closest to a face. `density` is the share of a target that represents the mean area
    /// of all.
    pub(super) fn for_each_of(&self, face: FaceId, density: f64, mut act: impl FnMut(&FitTarget)) {
        let mut ground: Option<Ground> = None;
        for index in self.lists.of_face(face).map(|index| index as usize) {
            if let Some(beyond) = index.checked_sub(self.targets.len()) {
                act(&self.more[beyond]);
                continue;
            }
            // Consecutive targets are mostly on the same triangle.
            let place = self.targets.place(index);
            let same = ground.take().filter(|ground| ground.place == place);
            let on = same.unwrap_or_else(|| self.targets.on(place, density));
            act(&on.target(self.targets.point(index)));
            ground = Some(on);
        }
    }

    /// Adds the vertices of the original that are more than half as far as the farthest target. Their normals point
    /// along the direction from the mesh to the vertex.
    pub(super) fn push_far(&mut self, surface: &Surface, original: &Surface) {
        let vertices = original.used_vertices();
        let at = |i: usize| original.positions()[vertices[i] as usize];
        let bar = 0.5 * self.largest().sqrt();
        for_blocks_in_turn(
            vertices.len(),
            BLOCK,
            |indices| {
                let points: Vec<DVec3> = indices.map(at).collect();
                let closest = surface.closest_points(&points);
                let pairs = points.into_iter().zip(closest);
                pairs.filter(|(_, closest)| closest.distance > bar).collect::<Vec<_>>()
            },
            |far| {
                for (point, closest) in far {
                    self.lists.push(closest.face, as_u32(self.squares.len()));
                    self.squares.push(closest.offset.length_squared());
                    let normal = closest.offset.normalize_or_zero();
                    self.more.push(FitTarget { point, normal, share: 1.0, triangle: None });
                }
            },
        );
    }

    /// Assigns the points of two faces to the closer of the two, for the current positions of the faces.
    pub(super) fn redistribute(
        &mut self,
        mesh: &TriMesh,
        faces: [FaceId; 2],
        scratch: &mut Vec<u32>,
    ) {
        scratch.clear();
        for face in faces {
            scratch.extend(self.lists.of_face(face));
            self.lists.clear(face);
        }
        let triangles = faces.map(|face| mesh.triangle(face));
        for &index in scratch.iter() {
            let point = self.point(index as usize);
            let [d0, d1] = [&triangles[0], &triangles[1]]
                .map(|triangle| closest_on_triangle(point, triangle).length_squared());
            self.lists.push(faces[usize::from(d1 < d0)], index);
            self.squares[index as usize] = d0.min(d1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::targets::Count;
    use mesh_shapes::Sphere;

    /// Pairs that stay with their face, and pairs that are searched again, are as close as closest points.
    #[test]
    fn pairs_follow_a_mesh_whose_vertices_move() {
        let sphere = |cuts| {
            let soup = Sphere { radius: 1.0 }.icosphere(cuts).unwrap();
            TriMesh::from_soup(&soup).unwrap()
        };
        let (fine, mut mesh) = (sphere(3), sphere(1));
        let (original, mut surface) = (Surface::new(&fine).unwrap(), Surface::new(&mesh).unwrap());
        let targets = || Targets::new(&original, Count::OnEach(3), 1);
        let mut pairs = Pairs::new(&mesh, &surface, targets());
        pairs.push_far(&surface, &original);
        for (i, p) in mesh.positions_mut().iter_mut().enumerate() {
            let [x, y, z] = [1.0, 2.0, 3.0].map(|k| 0.02 * (k * i as f64).sin());
            *p = 1.01 * *p + DVec3::new(x, y, z);
        }
        surface.follow(&mesh).unwrap();
        let before = pairs.squares.len();
        pairs.follow(&mesh, &surface);
        let anew = Pairs::new(&mesh, &surface, targets());
        assert!(pairs.squares.len() == anew.squares.len() && before > pairs.squares.len());
        assert_eq!(pairs.target_count(), anew.target_count());
        // Other targets start from the faces of the earlier ones.
        let near = pairs.faces_by_place(&mesh, original.triangle_count());
        let targets = Targets::new(&original, Count::OnEach(2), 1);
        let following = Pairs::following(&mesh, &surface, targets, &near);
        assert_eq!(2 * anew.target_count(), 3 * following.target_count());
        for (pairs, most, few) in [(&pairs, 1e-3, 500), (&anew, 2e-3, 500), (&following, 2e-3, 200)]
        {
            let more: Vec<f64> = (0..pairs.squares.len())
                .map(|i| pairs.squares[i].sqrt() - surface.distance(pairs.point(i)))
                .collect();
            // A few targets are paired with one of two faces that are about equally far away.
            assert!(more.iter().all(|&more| more > -1e-12 && more < most));
            assert!(more.iter().filter(|&&more| more > 1e-12).count() < more.len() / few);
        }
        let listed: usize = mesh.topology().faces().map(|f| pairs.of_face(f).count()).sum();
        assert_eq!(listed, anew.squares.len());
        for face in mesh.topology().faces() {
            for (point, squared, _) in pairs.of_face(face) {
                let offset = closest_on_triangle(point, &mesh.triangle(face));
                assert!((offset.length_squared() - squared).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn vertices_more_than_half_as_far_as_the_farthest_point_are_added() {
        let sphere = |cuts| {
            let soup = Sphere { radius: 1.0 }.icosphere(cuts).unwrap();
            TriMesh::from_soup(&soup).unwrap()
        };
        let (fine, mesh) = (sphere(3), sphere(1));
        let [original, surface] = [&fine, &mesh].map(|mesh| Surface::new(mesh).unwrap());
        let targets = Targets::new(&original, Count::About(500), 1);
        let mut pairs = Pairs::new(&mesh, &surface, targets);
        let (count, bar) = (pairs.squares.len(), 0.5 * pairs.largest().sqrt());
        pairs.push_far(&surface, &original);
        let distance = |p: DVec3| {
            let faces = mesh.topology().faces();
            let all = faces.map(|f| closest_on_triangle(p, &mesh.triangle(f)).length());
            all.fold(f64::INFINITY, f64::min)
        };
        let far: Vec<DVec3> =
            fine.positions().iter().copied().filter(|&p| distance(p) > bar).collect();
        assert!(far.len() > 100 && far.len() < fine.positions().len());
        let added: Vec<DVec3> = pairs.more.iter().map(|target| target.point).collect();
        assert_eq!(added, far);
        let of_faces = mesh.topology().faces().flat_map(|face| pairs.of_face(face));
        let at_vertices = of_faces.filter(|(point, ..)| far.contains(point));
        let squares: Vec<[f64; 2]> =
            at_vertices.map(|(point, squared, _)| [squared.sqrt(), distance(point)]).collect();
        assert!(squares.len() == far.len() && pairs.squares.len() == count + far.len());
        assert!(squares.iter().all(|[found, expected]| (found - expected).abs() < 1e-12));
    }
}
