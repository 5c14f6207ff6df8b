//! The faces under a patch: those that can be reached from its base face, look to the same side,
//! and lie over or under its footprint; and those around them that are near enough.

use core::ops::ControlFlow;
use std::sync::Arc;

use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use glam::{DVec2, DVec3};
use mesh_core::{FaceId, TriMesh};

use crate::closest::closest_point;
use crate::patch::Patch;
use crate::terrain::{FaceLinks, NONE, Terrain};
use crate::wide::{LANES, LanesOf, Wide};

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

    /// Marks a new element as met, or does nothing, without a branch.
    #[inline]
    fn meet_if(&mut self, index: usize, is_so: bool) {
        let stamp = &mut self.stamps[index];
        *stamp = if is_so { self.round } else { *stamp };
    }

    #[inline]
    pub(crate) fn is_picked(&self, index: usize) -> bool {
        self.stamps[index] == self.round + 1
    }
}

/// A vertex in the frame of a patch.
#[derive(Clone, Copy, Debug, Default)]
struct Local {
    at: DVec3,
    /// The square of how far out it is, as a share of the footprint.
    square: f64,
}

/// Looks at the vertices of a region.
pub(crate) trait Picker {
    /// Shows the next vertices of a region, up to eight, in the frame of the patch: which of them are
    /// picked, by bits, and which is the first that the region is not grown beyond.
    fn look<S: Simd>(&mut self, simd: S, met: &Wide<S>, count: usize) -> (u64, Option<usize>);
}

/// Picks nothing.
struct PicksNothing;

impl Picker for PicksNothing {
    #[inline(always)]
    fn look<S: Simd>(&mut self, _: S, _: &Wide<S>, _: usize) -> (u64, Option<usize>) {
        (0, None)
    }
}

/// Vertices that have been met and not been shown yet, with how many faces the region had then.
#[derive(Clone, Copy, Debug, Default)]
struct Fresh {
    met: [(u32, u32); 2 * LANES],
    count: usize,
}

/// Grows regions; holds the memory for it, so that many regions cost nothing but their faces. Copies
/// share what they know of the mesh.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    terrain: Arc<Terrain>,
    /// Three times the place of a face in the terrain, and the side that it was reached through.
    faces: Vec<u32>,
    /// How many of them belong to the region.
    count: usize,
    /// Its faces are picked.
    face_marks: Marks,
    /// Vertices of the region; those that the visitor wants are picked.
    vertex_marks: Marks,
    /// Where the vertices of the region are in the frame of the patch.
    locals: Vec<Local>,
}

impl Region {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let terrain = Terrain::new(mesh);
        Self {
            faces: Vec::new(),
            count: 0,
            face_marks: Marks::new(terrain.links.len()),
            vertex_marks: Marks::new(terrain.positions.len()),
            locals: vec![Local::default(); terrain.positions.len()],
            terrain: Arc::new(terrain),
        }
    }

    /// Where it grows.
    pub(crate) fn terrain(&self) -> &Terrain {
        &self.terrain
    }

    /// How many faces the region has that was grown last.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Whether the face at a place belongs to it.
    pub(crate) fn contains(&self, face: u32) -> bool {
        self.face_marks.is_picked(face as usize)
    }

    /// The places of its faces, in the order in which they were reached.
    fn places(&self) -> impl DoubleEndedIterator<Item = usize> + '_ {
        self.faces.iter().take(self.count).map(|&entry| (entry / 3) as usize)
    }

    /// Its faces with their corners, the last one that was reached first.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = (FaceId, [DVec3; 3])> + '_ {
        let terrain = &*self.terrain;
        self.places()
            .rev()
            .map(|place| (terrain.face_at[place], terrain.triangle(terrain.links[place].corners)))
    }

    /// The faces of it whose vertices were all picked, with their areas.
    pub(crate) fn picked_faces(&self) -> impl Iterator<Item = (FaceId, f64)> + '_ {
        let terrain = &*self.terrain;
        let is_picked = |&place: &usize| {
            let [a, b, c] = terrain.links[place].corners;
            let is_picked = |v: u32| self.vertex_marks.is_picked(v as usize);
            is_picked(a) & is_picked(b) & is_picked(c)
        };
        self.places().filter(is_picked).map(|place| (terrain.face_at[place], terrain.areas[place]))
    }

    /// Collects the faces that are reached from `base` over edges and faces whose normals make an
    /// angle below 90° with the patch's and that have a point over or under its footprint. Shows
    /// every vertex of the region, in the order in which they are met, to `picker`, and picks those that
    /// it says; ends at a vertex where it says so, which is returned as it is in space.
    pub(crate) fn grow(
        &mut self,
        base: FaceId,
        patch: &Patch,
        picker: &mut impl Picker,
    ) -> ControlFlow<DVec3> {
        let scale = DVec2::from_array(patch.semi_axes()).recip();
        let over = |corners: [Local; 3]| is_over_disc(corners, scale);
        dispatch!(self.terrain.simd, simd => self.grow_with(simd, base, (patch, scale), over, picker))
    }

    #[inline(always)]
    fn grow_with<S: Simd>(
        &mut self,
        simd: S,
        base: FaceId,
        (patch, scale): (&Patch, DVec2),
        belongs: impl Fn([Local; 3]) -> bool,
        picker: &mut impl Picker,
    ) -> ControlFlow<DVec3> {
        self.count = 0;
        self.face_marks.clear();
        self.vertex_marks.clear();
        let base = self.terrain.place(base);
        let mut fresh = Fresh::default();
        for corner in self.terrain.links[base as usize].corners {
            let index = corner as usize;
            self.locals[index] = localized(patch, scale, self.terrain.positions[index]);
            self.vertex_marks.meet(index);
            fresh.met[fresh.count] = (corner, 0);
            fresh.count += 1;
        }
        self.face_marks.pick(base as usize);
        self.make_room();
        self.faces[0] = 3 * base;
        self.count = 1;
        // It was reached through no side.
        self.cross(0, 0, patch, scale, &belongs, &mut fresh);
        self.spread(simd, (patch, scale), belongs, picker, fresh)
    }

    /// Adds the faces that are reached from the region in the same way and come closer than `reach` to
    /// the origin of the patch.
    pub(crate) fn widen(&mut self, patch: &Patch, reach: f64) {
        let scale = DVec2::from_array(patch.semi_axes()).recip();
        let near = |corners: [Local; 3]| is_near_origin(corners.map(|corner| corner.at), reach);
        let (fresh, mut picker) = (Fresh::default(), PicksNothing);
        let _: ControlFlow<DVec3> = dispatch!(self.terrain.simd, simd => {
            let mut fresh = fresh;
            if self.count > 0 {
                self.make_room();
                self.cross(0, 0, patch, scale, &near, &mut fresh);
            }
            self.spread(simd, (patch, scale), near, &mut picker, fresh)
        });
    }

    /// Makes room for the faces that are reached from one.
    #[inline(always)]
    fn make_room(&mut self) {
        if self.faces.len() < self.count + 4 {
            self.faces.resize(2 * self.count + 64, 0);
        }
    }

    /// Adds the faces that are reached from those of the region and of which `belongs` is true for the
    /// corners, in the frame of the patch.
    #[inline(always)]
    fn spread<S: Simd>(
        &mut self,
        simd: S,
        (patch, scale): (&Patch, DVec2),
        belongs: impl Fn([Local; 3]) -> bool,
        picker: &mut impl Picker,
        mut fresh: Fresh,
    ) -> ControlFlow<DVec3> {
        let mut next = 0;
        while next < self.count {
            self.make_room();
            // The face beyond the side that this one was reached through is of the region.
            let [one, other] = OTHERS[(self.faces[next] % 3) as usize];
            self.cross(next, one, patch, scale, &belongs, &mut fresh);
            self.cross(next, other, patch, scale, &belongs, &mut fresh);
            next += 1;
            if fresh.count >= LANES {
                self.show(simd, picker, &mut fresh)?;
            }
        }
        while fresh.count > 0 {
            self.show(simd, picker, &mut fresh)?;
        }
        ControlFlow::Continue(())
    }

    /// Looks over a side of a face of the region, and adds the face beyond if it belongs to it too.
    ///
    /// Whether its vertex has been met before is as good as the toss of a coin, so nothing branches on that.
    /// Where the face is of the region already, to branch is quicker than to do all this for nothing.
    #[inline(always)]
    fn cross(
        &mut self,
        face: usize,
        side: usize,
        patch: &Patch,
        scale: DVec2,
        belongs: &impl Fn([Local; 3]) -> bool,
        fresh: &mut Fresh,
    ) {
        let terrain = &*self.terrain;
        let FaceLinks { corners, beyond } = terrain.links[(self.faces[face] / 3) as usize];
        let entry = beyond[side];
        if entry == NONE {
            return;
        }
        let neighbour = (entry / 3) as usize;
        if self.face_marks.is_picked(neighbour) {
            return;
        }
        // The corner that is not on the common side.
        let apex = terrain.links[neighbour].corners[OPPOSITE[(entry % 3) as usize]];
        let index = apex as usize;
        let local = localized(patch, scale, terrain.positions[index]);
        let (from, to) = (corners[side], corners[NEXT[side]]);
        let around = [self.locals[to as usize], self.locals[from as usize], local];
        if !(is_upward([around[0].at, around[1].at, around[2].at]) && belongs(around)) {
            return;
        }
        let is_met = !self.vertex_marks.is_met(index);
        self.faces[self.count] = entry;
        self.count += 1;
        self.face_marks.pick(neighbour);
        // The same again where it has been met before.
        self.locals[index] = local;
        self.vertex_marks.meet_if(index, is_met);
        fresh.met[fresh.count] = (apex, self.count as u32);
        fresh.count += usize::from(is_met);
    }

    /// Shows up to eight vertices to the picker.
    #[inline(always)]
    fn show<S: Simd>(
        &mut self,
        simd: S,
        picker: &mut impl Picker,
        fresh: &mut Fresh,
    ) -> ControlFlow<DVec3> {
        let count = fresh.count.min(LANES);
        let mut offsets = [DVec3::ZERO; LANES];
        for (offset, (vertex, _)) in offsets.iter_mut().zip(fresh.met) {
            *offset = self.locals[vertex as usize].at;
        }
        let (picked, last) = picker.look(simd, &Wide::gather(simd, offsets), count);
        for lane in LanesOf(picked) {
            self.vertex_marks.pick(fresh.met[lane].0 as usize);
        }
        if let Some(last) = last {
            let (vertex, count) = fresh.met[last];
            self.count = count as usize;
            return ControlFlow::Break(self.terrain.positions[vertex as usize]);
        }
        fresh.met.copy_within(LANES.., 0);
        fresh.count -= count;
        ControlFlow::Continue(())
    }
}

/// The sides of a face but one, in their order.
const OTHERS: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];

/// The corner that a side does not have.
const OPPOSITE: [usize; 3] = [2, 0, 1];

/// The corner that a side leads to.
const NEXT: [usize; 3] = [1, 2, 0];

/// A vertex in the frame of a patch whose footprint has been scaled to the unit disc.
#[inline(always)]
fn localized(patch: &Patch, scale: DVec2, position: DVec3) -> Local {
    let at = patch.turn_to_local(position - patch.origin());
    Local { at, square: (at.truncate() * scale).length_squared() }
}

/// Whether a triangle in the frame of a patch looks to the side of its normal.
#[inline]
fn is_upward([a, b, c]: [DVec3; 3]) -> bool {
    (b - a).truncate().perp_dot((c - a).truncate()) > 0.0
}

/// Whether a triangle has a point over or under the unit disc, or is as close to it as rounding, once its
/// plane has been scaled.
#[inline(always)]
fn is_over_disc([a, b, c]: [Local; 3], scale: DVec2) -> bool {
    const SQUARE: f64 = 1.0 + 1e-9;
    a.square.min(b.square).min(c.square) <= SQUARE || {
        let [a, b, c] = [a.at.truncate() * scale, b.at.truncate() * scale, c.at.truncate() * scale];
        let corners = [a.extend(0.0), b.extend(0.0), c.extend(0.0)];
        closest_point(DVec3::ZERO, corners).0.length_squared() <= SQUARE
    }
}

/// Whether a triangle has a point within this distance of the origin.
fn is_near_origin(corners: [DVec3; 3], distance: f64) -> bool {
    let square = distance * distance;
    corners.iter().any(|corner| corner.length_squared() <= square)
        || closest_point(DVec3::ZERO, corners).0.length_squared() <= square
}
