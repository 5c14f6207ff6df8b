//! The faces under a patch: those that can be reached from its base face, look to the same side,
//! and lie over or under its footprint; and those around them that are near enough.

use core::ops::ControlFlow;
use std::sync::Arc;

use glam::{DVec2, DVec3};
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

    /// Marks a new element as met.
    #[inline]
    pub(crate) fn meet(&mut self, index: usize) {
        self.stamps[index] = self.round;
    }

    #[inline]
    pub(crate) fn is_met(&self, index: usize) -> bool {
        self.stamps[index] >= self.round
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
    /// Its faces are picked.
    face_marks: Marks,
    /// Vertices of the region; those that the visitor wants are picked.
    vertex_marks: Marks,
    /// Where the vertices of the region are in the frame of the patch.
    locals: Vec<DVec3>,
}

impl Region {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let terrain = Terrain::new(mesh);
        Self {
            faces: Vec::new(),
            face_marks: Marks::new(terrain.links.len()),
            vertex_marks: Marks::new(terrain.positions.len()),
            locals: vec![DVec3::ZERO; terrain.positions.len()],
            terrain: Arc::new(terrain),
        }
    }

    /// Where it grows.
    pub(crate) fn terrain(&self) -> &Terrain {
        &self.terrain
    }

    /// How many faces the region has that was grown last.
    pub(crate) fn len(&self) -> usize {
        self.faces.len()
    }

    /// Whether the face at a place belongs to it.
    pub(crate) fn contains(&self, face: u32) -> bool {
        self.face_marks.is_picked(face as usize)
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
    /// angle below 90° with the patch's and that have a point over or under its footprint. Shows
    /// every vertex of the region, in the frame of the patch, to `pick` when it is first met, and picks
    /// it if that says so; ends at a vertex for which that breaks, which is returned as it is in space.
    pub(crate) fn grow(
        &mut self,
        base: FaceId,
        patch: &Patch,
        mut pick: impl FnMut(DVec3) -> ControlFlow<(), bool>,
    ) -> ControlFlow<DVec3> {
        self.faces.clear();
        self.face_marks.clear();
        self.vertex_marks.clear();
        let base = self.terrain.place(base);
        for corner in self.terrain.links[base as usize].corners {
            let at = patch.to_local(self.terrain.positions[corner as usize]);
            self.meet(corner, at, &mut pick)?;
        }
        self.face_marks.pick(base as usize);
        self.faces.push(base);
        let scale = DVec2::from_array(patch.semi_axes()).recip();
        self.spread(
            patch,
            |[a, b, c]| {
                is_over_disc([a.truncate() * scale, b.truncate() * scale, c.truncate() * scale])
            },
            pick,
        )
    }

    /// Adds the faces that are reached from the region in the same way and come closer than `reach` to
    /// the origin of the patch.
    pub(crate) fn widen(&mut self, patch: &Patch, reach: f64) {
        let picks_nothing = |_| ControlFlow::Continue(false);
        let _ = self.spread(patch, |corners| is_near_origin(corners, reach), picks_nothing);
    }

    /// Adds the faces that are reached from those of the region and of which `belongs` is true for the
    /// corners, in the frame of the patch.
    fn spread(
        &mut self,
        patch: &Patch,
        belongs: impl Fn([DVec3; 3]) -> bool,
        mut pick: impl FnMut(DVec3) -> ControlFlow<(), bool>,
    ) -> ControlFlow<DVec3> {
        let mut next = 0;
        while let Some(&face) = self.faces.get(next) {
            next += 1;
            let FaceLinks { corners, beyond } = self.terrain.links[face as usize];
            let [a, b, c] = corners;
            let known = [self.locals[a as usize], self.locals[b as usize], self.locals[c as usize]];
            for (side, entry) in beyond.into_iter().enumerate() {
                let neighbour = entry / 3;
                if entry == NONE || self.face_marks.is_picked(neighbour as usize) {
                    continue;
                }
                // The corner that is not on the common side.
                let others = self.terrain.links[neighbour as usize].corners;
                let [from, to] = [side, (side + 1) % 3];
                let apex = others[0] ^ others[1] ^ others[2] ^ corners[from] ^ corners[to];
                let is_new = !self.vertex_marks.is_met(apex as usize);
                let at = if is_new {
                    patch.to_local(self.terrain.positions[apex as usize])
                } else {
                    self.locals[apex as usize]
                };
                let around = [known[to], known[from], at];
                if !(is_upward(around) && belongs(around)) {
                    continue;
                }
                self.face_marks.pick(neighbour as usize);
                self.faces.push(neighbour);
                if is_new {
                    self.meet(apex, at, &mut pick)?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Notes where a new vertex is in the frame of the patch, and shows it to `pick`.
    #[inline]
    fn meet(
        &mut self,
        vertex: u32,
        at: DVec3,
        pick: &mut impl FnMut(DVec3) -> ControlFlow<(), bool>,
    ) -> ControlFlow<DVec3> {
        let index = vertex as usize;
        self.vertex_marks.meet(index);
        self.locals[index] = at;
        match pick(at) {
            ControlFlow::Continue(true) => self.vertex_marks.pick(index),
            ControlFlow::Continue(false) => {}
            ControlFlow::Break(()) => return ControlFlow::Break(self.terrain.positions[index]),
        }
        ControlFlow::Continue(())
    }
}

/// Whether a triangle in the frame of a patch looks to the side of its normal.
#[inline]
fn is_upward([a, b, c]: [DVec3; 3]) -> bool {
    (b - a).truncate().perp_dot((c - a).truncate()) > 0.0
}

/// Whether a triangle of the plane has a point of the unit disc, or is as close to it as rounding.
#[inline]
fn is_over_disc([a, b, c]: [DVec2; 3]) -> bool {
    const SQUARE: f64 = 1.0 + 1e-9;
    if a.length_squared().min(b.length_squared()).min(c.length_squared()) <= SQUARE {
        return true;
    }
    let corners = [a.extend(0.0), b.extend(0.0), c.extend(0.0)];
    closest_point(DVec3::ZERO, corners).0.length_squared() <= SQUARE
}

/// Whether a triangle has a point within this distance of the origin.
fn is_near_origin(corners: [DVec3; 3], distance: f64) -> bool {
    let square = distance * distance;
    corners.iter().any(|corner| corner.length_squared() <= square)
        || closest_point(DVec3::ZERO, corners).0.length_squared() <= square
}
