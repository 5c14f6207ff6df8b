//! Samples of the original and the faces of the mesh that they draw.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_metric::{ClosestPoint, Surface, SurfaceSample, closest_on_triangle};

use crate::finish::face_lists::FaceLists;

/// A point of the original that the mesh is drawn to.
#[derive(Clone, Copy)]
pub(super) struct Target {
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
}

impl Target {
    /// A sample of the original.
    pub(super) fn of_sample(original: &Surface, sample: &SurfaceSample) -> Self {
        Self::on_triangle(original, sample.triangle, sample.position)
    }

    /// A point of a triangle of the original.
    pub(super) fn on_triangle(original: &Surface, triangle: u32, point: DVec3) -> Self {
        let [a, b, c] = original.triangle(triangle as usize);
        Self { point, normal: (b - a).cross(c - a).normalize_or_zero() }
    }
}

/// Targets by the face that is closest to them.
pub(super) struct Pairs {
    lists: FaceLists,
    targets: Vec<Target>,
    /// The squared distance of each target from its face.
    squares: Vec<f64>,
}

impl Pairs {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let lists = FaceLists::new(mesh.topology().face_capacity());
        Self { lists, targets: Vec::new(), squares: Vec::new() }
    }

    pub(super) fn push(&mut self, closest: &ClosestPoint, target: Target) {
        self.lists.push(closest.face, self.targets.len() as u32);
        self.squares.push(closest.offset.length_squared());
        self.targets.push(target);
    }

    /// The largest squared distance.
    pub(super) fn largest(&self) -> f64 {
        self.squares.iter().copied().fold(0.0, f64::max)
    }

    /// The points that are closest to a face, each with its squared distance.
    pub(super) fn of_face(&self, face: FaceId) -> impl Iterator<Item = (DVec3, f64)> + '_ {
        let indices = self.lists.of_face(face).map(|index| index as usize);
        indices.map(|index| (self.targets[index].point, self.squares[index]))
    }

    /// Adds the vertices of the original that are more than half as far as the farthest target.
    /// The normals there are the directions in which they are.
    pub(super) fn push_far(&mut self, surface: &Surface, original: &Surface) {
        let at = |v: u32| original.positions()[v as usize];
        let points: Vec<DVec3> = original.used_vertices().into_iter().map(at).collect();
        let bar = 0.5 * self.largest().sqrt();
        for (&point, closest) in points.iter().zip(surface.closest_points(&points)) {
            if closest.distance > bar {
                self.push(&closest, Target { point, normal: closest.offset.normalize_or_zero() });
            }
        }
    }

    pub(super) fn for_each(&self, mesh: &TriMesh, mut act: impl FnMut(FaceId, Target)) {
        for face in mesh.topology().faces() {
            for index in self.lists.of_face(face) {
                act(face, self.targets[index as usize]);
            }
        }
    }

    /// Gives the targets of two faces to the one that is closer, the faces being as they are now.
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
            let point = self.targets[index as usize].point;
            let [d0, d1] = [&triangles[0], &triangles[1]]
                .map(|triangle| closest_on_triangle(point, triangle).length_squared());
            self.lists.push(faces[usize::from(d1 < d0)], index);
            self.squares[index as usize] = d0.min(d1);
        }
    }
}
