//! The faces under a patch: those that can be reached from its base face, look to the same side,
//! and are near enough.

use core::ops::ControlFlow;
use std::sync::Arc;

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};

use crate::closest::closest_point;
use crate::patch::Patch;
use crate::terrain::{FaceLinks, NONE, Terrain};

/// Which elements were met since the last [`Marks::clear`], and which of them were picked, without
/// clearing any array.
#[derive(Clone, Debug)]
pub(crate) struct Marks {
    /// The stamp of what was met; the next number is that of what was picked.
    round: u32,
    stamps: Vec<u32>,
}

impl Marks {
    pub(crate) fn new(count: usize) -> Self {
        Self { round: 2, stamps: vec![0; count] }
    }

    pub(crate) fn clear(&mut self) {
        self.round = self.round.wrapping_add(2);
        if self.round == 0 {
            self.stamps.fill(0);
            self.round = 2;
        }
    }

    /// Marks an element as met and says whether it was new.
    #[inline]
    pub(crate) fn insert(&mut self, index: usize) -> bool {
        let stamp = &mut self.stamps[index];
        let new = *stamp < self.round;
        if new {
            *stamp = self.round;
        }
        new
    }

    /// Marks an element as picked.
    #[inline]
    pub(crate) fn pick(&mut self, index: usize) {
        self.stamps[index] = self.round + 1;
    }

    #[inline]
    pub(crate) fn is_picked(&self, index: usize) -> bool {
        self.stamps[index] == self.round + 1
    }
}

/// Grows regions; holds the memory for it, so that many regions cost nothing but their faces. Copies
/// share what they know of the mesh.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    terrain: Arc<Terrain>,
    /// Places in the terrain.
    faces: Vec<u32>,
    /// Faces that were looked at; those of the region are picked.
    face_marks: Marks,
    /// Vertices of the region; those that the visitor wants are picked.
    vertex_marks: Marks,
}

impl Region {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let terrain = Terrain::new(mesh);
        Self {
            faces: Vec::new(),
            face_marks: Marks::new(terrain.links.len()),
            vertex_marks: Marks::new(terrain.positions.len()),
            terrain: Arc::new(terrain),
        }
    }

    /// How many faces the region has that was grown last.
    pub(crate) fn len(&self) -> usize {
        self.faces.len()
    }

    /// Whether a face belongs to it.
    pub(crate) fn contains(&self, face: FaceId) -> bool {
        self.face_marks.is_picked(self.terrain.place_of_face[face.index()] as usize)
    }

    /// Its faces with their corners, the last one that was reached first.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = (FaceId, [DVec3; 3])> + '_ {
        let terrain = &*self.terrain;
        self.faces.iter().rev().map(|&place| {
            (
                terrain.face_at[place as usize],
                terrain.triangle(terrain.links[place as usize].corners),
            )
        })
    }

    /// The faces of it whose vertices were all picked.
    pub(crate) fn picked_faces(&self) -> impl Iterator<Item = FaceId> + '_ {
        let terrain = &*self.terrain;
        let is_picked = |&&place: &&u32| {
            let corners = terrain.links[place as usize].corners;
            corners.iter().all(|&v| self.vertex_marks.is_picked(v as usize))
        };
        self.faces.iter().filter(is_picked).map(|&place| terrain.face_at[place as usize])
    }

    /// Collects the faces that are reached from `base` over edges and faces whose normals make an
    /// angle below 90° with the patch's and that come closer than `reach` to its origin. Shows
    /// every vertex of the region to `pick` when it is first met, picks it if that says so, and stops
    /// when that breaks.
    pub(crate) fn grow(
        &mut self,
        base: FaceId,
        patch: &Patch,
        reach: f64,
        mut pick: impl FnMut(DVec3) -> ControlFlow<DVec3, bool>,
    ) -> ControlFlow<DVec3> {
        let Self { terrain, faces, face_marks, vertex_marks } = self;
        let Terrain { links, positions, place_of_face, .. } = &**terrain;
        faces.clear();
        face_marks.clear();
        vertex_marks.clear();
        let mut visit = |vertex: u32| {
            let index = vertex as usize;
            if vertex_marks.insert(index) && pick(positions[index])? {
                vertex_marks.pick(index);
            }
            ControlFlow::Continue(())
        };
        let normal = patch.frame()[2];
        let belongs = |corners: [u32; 3]| {
            let corners = corners.map(|corner| positions[corner as usize]);
            let [a, b, c] = corners;
            (b - a).cross(c - a).dot(normal) > 0.0 && is_within(patch.origin(), corners, reach)
        };
        let base = place_of_face[base.index()];
        face_marks.pick(base as usize);
        faces.push(base);
        for corner in links[base as usize].corners {
            visit(corner)?;
        }
        let mut next = 0;
        while let Some(&face) = faces.get(next) {
            next += 1;
            let FaceLinks { corners, beyond } = links[face as usize];
            for (side, neighbour) in beyond.into_iter().enumerate() {
                if neighbour == NONE || !face_marks.insert(neighbour as usize) {
                    continue;
                }
                let others = links[neighbour as usize].corners;
                if !belongs(others) {
                    continue;
                }
                face_marks.pick(neighbour as usize);
                faces.push(neighbour);
                // The corner that is not on the common side.
                let [p, q] = [corners[side], corners[(side + 1) % 3]];
                visit(others.into_iter().fold(p ^ q, |rest, corner| rest ^ corner))?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// Whether a triangle has a point within this distance.
fn is_within(point: DVec3, corners: [DVec3; 3], distance: f64) -> bool {
    let square = distance * distance;
    corners.iter().any(|corner| corner.distance_squared(point) <= square)
        || closest_point(point, corners).0.distance_squared(point) <= square
}
