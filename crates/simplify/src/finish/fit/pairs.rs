//! Points of the original and the faces of the mesh that they draw.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_metric::{Surface, closest_on_triangle};

use crate::finish::blocks::for_blocks_in_turn;
use crate::finish::face_lists::FaceLists;
use crate::finish::fit::targets::{Target, Targets};
use crate::finish::norm::Power;

/// Points by the face that is closest to them: every so many-th of the targets, and some more.
pub(super) struct Pairs<'a> {
    targets: &'a Targets<'a>,
    every: usize,
    /// Points beyond the targets.
    more: Vec<Target>,
    lists: FaceLists,
    /// The squared distance of each point from its face.
    squares: Vec<f64>,
}

/// Points whose closest ones are looked for by one thread at a time.
const BLOCK: usize = 1024;

impl<'a> Pairs<'a> {
    /// Pairs every so many-th of the targets with the closest face.
    pub(super) fn new(
        mesh: &TriMesh,
        surface: &Surface,
        targets: &'a Targets<'a>,
        every: usize,
    ) -> Self {
        let count = targets.len().div_ceil(every);
        let mut lists = FaceLists::new(mesh.topology().face_capacity());
        let mut squares = Vec::with_capacity(count);
        for_blocks_in_turn(
            count,
            BLOCK,
            |indices| {
                let points: Vec<DVec3> = indices.map(|i| targets.point(every * i)).collect();
                let closest = surface.closest_to_neighbours(&points).into_iter();
                closest.map(|c| (c.face, c.offset.length_squared())).collect::<Vec<_>>()
            },
            |closest| {
                for (face, squared) in closest {
                    lists.push(face, squares.len() as u32);
                    squares.push(squared);
                }
            },
        );
        Self { targets, every, more: Vec::new(), lists, squares }
    }

    /// The largest squared distance.
    pub(super) fn largest(&self) -> f64 {
        self.squares.iter().copied().fold(0.0, f64::max)
    }

    /// The squared mean of some order of the distances.
    pub(super) fn mean(&self, power: Power) -> f64 {
        power.mean(&self.squares)
    }

    fn point(&self, index: usize) -> DVec3 {
        let own = self.squares.len() - self.more.len();
        match index.checked_sub(own) {
            None => self.targets.point(self.every * index),
            Some(beyond) => self.more[beyond].point,
        }
    }

    /// The points that are closest to a face, each with its squared distance.
    pub(super) fn of_face(&self, face: FaceId) -> impl Iterator<Item = (DVec3, f64)> + '_ {
        let indices = self.lists.of_face(face).map(|index| index as usize);
        indices.map(|index| (self.point(index), self.squares[index]))
    }

    /// The targets that are closest to a face; `density` is the share of one that stands for the mean
    /// area of all.
    pub(super) fn for_each_of(&self, face: FaceId, density: f64, mut act: impl FnMut(&Target)) {
        let own = self.squares.len() - self.more.len();
        let density = density * self.every as f64;
        for index in self.lists.of_face(face).map(|index| index as usize) {
            match index.checked_sub(own) {
                None => act(&self.targets.target(self.every * index, density)),
                Some(beyond) => act(&self.more[beyond]),
            }
        }
    }

    /// Adds the vertices of the original that are more than half as far as the farthest target.
    /// The normals there are the directions in which they are.
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
                    self.lists.push(closest.face, self.squares.len() as u32);
                    self.squares.push(closest.offset.length_squared());
                    let normal = closest.offset.normalize_or_zero();
                    self.more.push(Target { point, normal, share: 1.0 });
                }
            },
        );
    }

    /// Gives the points of two faces to the one that is closer, the faces being as they are now.
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
    use mesh_core::shapes::Sphere;

    #[test]
    fn vertices_more_than_half_as_far_as_the_farthest_point_are_added() {
        let sphere = |cuts| {
            let soup = Sphere { radius: 1.0 }.icosphere(cuts).unwrap();
            TriMesh::from_soup(&soup).unwrap()
        };
        let (fine, mesh) = (sphere(3), sphere(1));
        let [original, surface] = [&fine, &mesh].map(|mesh| Surface::new(mesh).unwrap());
        let targets = Targets::new(&original, 500, 1);
        let mut pairs = Pairs::new(&mesh, &surface, &targets, 1);
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
        let at_vertices = of_faces.filter(|(point, _)| far.contains(point));
        let squares: Vec<[f64; 2]> =
            at_vertices.map(|(point, squared)| [squared.sqrt(), distance(point)]).collect();
        assert!(squares.len() == far.len() && pairs.squares.len() == count + far.len());
        assert!(squares.iter().all(|[found, expected]| (found - expected).abs() < 1e-12));
    }
}
