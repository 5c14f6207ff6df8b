//! The region of a patch: connected faces under its footprint, and faces near them.

use core::ops::ControlFlow;
use std::sync::Arc;

use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use glam::{DVec2, DVec3};
use mesh_core::{FaceId, TriMesh, as_u32};

use crate::closest::closest_point;
use crate::patch::Patch;
use crate::soa_mesh::{NONE, SoaFace, SoaMesh};
use crate::vec3x8::{LANES, LaneBits, Vec3x8};
use crate::visit_marks::VisitMarks;

/// A vertex in the frame of a patch.
#[derive(Clone, Copy, Debug, Default)]
struct LocalVertex {
    at: DVec3,
    /// (x / A₁)² + (y / A₂)²: at most 1 in the footprint.
    square: f64,
}

/// Selects vertices of a region while it grows.
pub(crate) trait VertexFilter {
    /// Filters the next `count` vertices, up to eight, in the frame of the patch. Returns the selected
    /// lanes as bits, and the lane of the vertex at which growing stops, if any.
    fn filter<S: Simd>(
        &mut self,
        simd: S,
        vertices: &Vec3x8<S>,
        count: usize,
    ) -> (u64, Option<usize>);
}

/// Selects no vertex.
struct SelectNothing;

impl VertexFilter for SelectNothing {
    #[inline(always)]
    fn filter<S: Simd>(&mut self, _: S, _: &Vec3x8<S>, _: usize) -> (u64, Option<usize>) {
        (0, None)
    }
}

/// New vertices of a region that have not been filtered yet, each with the number of faces at its visit.
#[derive(Clone, Copy, Debug, Default)]
struct Unfiltered {
    vertices: [(u32, u32); 2 * LANES],
    count: usize,
}

/// Grows regions. It owns scratch memory, so that a region costs time in proportion to its faces. Clones
/// share the mesh.
#[derive(Clone, Debug)]
pub(crate) struct PatchRegion {
    soa: Arc<SoaMesh>,
    /// 3 × (`SoaMesh` index of a face) + (the side through which it was reached).
    faces: Vec<u32>,
    /// Number of faces in the region.
    count: usize,
    /// Faces of the region are selected.
    face_marks: VisitMarks,
    /// Vertices of the region are visited; those that the filter chooses are selected.
    vertex_marks: VisitMarks,
    /// The vertices of the region in the frame of the patch.
    locals: Vec<LocalVertex>,
}

impl PatchRegion {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let soa = SoaMesh::new(mesh);
        Self {
            faces: Vec::new(),
            count: 0,
            face_marks: VisitMarks::new(soa.faces.len()),
            vertex_marks: VisitMarks::new(soa.positions.len()),
            locals: vec![LocalVertex::default(); soa.positions.len()],
            soa: Arc::new(soa),
        }
    }

    /// The mesh.
    pub(crate) fn soa(&self) -> &SoaMesh {
        &self.soa
    }

    /// Number of faces in the latest region.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Whether the face with this `SoaMesh` index belongs to the region.
    pub(crate) fn contains(&self, face: u32) -> bool {
        self.face_marks.is_selected(face as usize)
    }

    /// The `SoaMesh` indices of its faces, in the order in which they were reached.
    fn soa_faces(&self) -> impl DoubleEndedIterator<Item = usize> + '_ {
        self.faces.iter().take(self.count).map(|&entry| (entry / 3) as usize)
    }

    /// Its faces with their corners, the face reached last first.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = (FaceId, [DVec3; 3])> + '_ {
        let soa = &*self.soa;
        self.soa_faces()
            .rev()
            .map(|face| (soa.face_ids[face], soa.triangle(soa.faces[face].corners)))
    }

    /// The faces whose vertices are all selected, with their areas.
    pub(crate) fn selected_faces(&self) -> impl Iterator<Item = (FaceId, f64)> + '_ {
        let soa = &*self.soa;
        let is_selected = |&face: &usize| {
            let [a, b, c] = soa.faces[face].corners;
            let is_selected = |v: u32| self.vertex_marks.is_selected(v as usize);
            is_selected(a) & is_selected(b) & is_selected(c)
        };
        self.soa_faces().filter(is_selected).map(|face| (soa.face_ids[face], soa.areas[face]))
    }

    /// Collects the faces that are connected to `base` through faces whose normals make an angle below 90°
    /// with the normal of the patch and that have a point over or under its footprint.
    ///
    /// All vertices of the region pass through `filter` in the order in which they are reached. Breaks
    /// with the position of the vertex at which the filter stops.
    pub(crate) fn grow(
        &mut self,
        base: FaceId,
        patch: &Patch,
        filter: &mut impl VertexFilter,
    ) -> ControlFlow<DVec3> {
        let scale = DVec2::from_array(patch.semi_axes()).recip();
        let over = |corners: [LocalVertex; 3]| is_over_disc(corners, scale);
        dispatch!(self.soa.simd, simd => self.grow_with(simd, base, (patch, scale), over, filter))
    }

    #[inline(always)]
    fn grow_with<S: Simd>(
        &mut self,
        simd: S,
        base: FaceId,
        (patch, scale): (&Patch, DVec2),
        belongs: impl Fn([LocalVertex; 3]) -> bool,
        filter: &mut impl VertexFilter,
    ) -> ControlFlow<DVec3> {
        self.count = 0;
        self.face_marks.clear();
        self.vertex_marks.clear();
        let base = self.soa.index_of(base);
        let mut unfiltered = Unfiltered::default();
        for corner in self.soa.faces[base as usize].corners {
            let index = corner as usize;
            self.locals[index] = localized(patch, scale, self.soa.positions[index]);
            self.vertex_marks.visit(index);
            unfiltered.vertices[unfiltered.count] = (corner, 0);
            unfiltered.count += 1;
        }
        self.face_marks.select(base as usize);
        self.make_room();
        self.faces[0] = 3 * base;
        self.count = 1;
        // The base face was reached through no side, so side 0 is open, too.
        self.add_across(0, 0, patch, scale, &belongs, &mut unfiltered);
        self.spread(simd, (patch, scale), belongs, filter, unfiltered)
    }

    /// Adds the faces that are connected to the region in the same way and have a point nearer than
    /// `reach` to the origin of the patch.
    pub(crate) fn widen(&mut self, patch: &Patch, reach: f64) {
        let scale = DVec2::from_array(patch.semi_axes()).recip();
        let near =
            |corners: [LocalVertex; 3]| is_near_origin(corners.map(|corner| corner.at), reach);
        let (unfiltered, mut filter) = (Unfiltered::default(), SelectNothing);
        let _: ControlFlow<DVec3> = dispatch!(self.soa.simd, simd => {
            let mut unfiltered = unfiltered;
            if self.count > 0 {
                self.make_room();
                self.add_across(0, 0, patch, scale, &near, &mut unfiltered);
            }
            self.spread(simd, (patch, scale), near, &mut filter, unfiltered)
        });
    }

    /// Reserves memory for the faces that one face can add.
    #[inline(always)]
    fn make_room(&mut self) {
        if self.faces.len() < self.count + 4 {
            self.faces.resize(2 * self.count + 64, 0);
        }
    }

    /// Adds all faces connected to the region whose corners, in the frame of the patch, satisfy `belongs`.
    #[inline(always)]
    fn spread<S: Simd>(
        &mut self,
        simd: S,
        (patch, scale): (&Patch, DVec2),
        belongs: impl Fn([LocalVertex; 3]) -> bool,
        filter: &mut impl VertexFilter,
        mut unfiltered: Unfiltered,
    ) -> ControlFlow<DVec3> {
        let mut next = 0;
        while next < self.count {
            self.make_room();
            // The face across the third side is already in the region.
            let [one, other] = OTHER_SIDES[(self.faces[next] % 3) as usize];
            self.add_across(next, one, patch, scale, &belongs, &mut unfiltered);
            self.add_across(next, other, patch, scale, &belongs, &mut unfiltered);
            next += 1;
            if unfiltered.count >= LANES {
                self.filter_vertices(simd, filter, &mut unfiltered)?;
            }
        }
        while unfiltered.count > 0 {
            self.filter_vertices(simd, filter, &mut unfiltered)?;
        }
        ControlFlow::Continue(())
    }

    /// Adds the face across a side of a face of the region, if it belongs to the region.
    ///
    /// It is unpredictable whether the opposite vertex was visited before, so the code does not branch on
    /// that. It does branch if the face is already in the region, which saves more.
    #[inline(always)]
    fn add_across(
        &mut self,
        face: usize,
        side: usize,
        patch: &Patch,
        scale: DVec2,
        belongs: &impl Fn([LocalVertex; 3]) -> bool,
        unfiltered: &mut Unfiltered,
    ) {
        let soa = &*self.soa;
        let SoaFace { corners, opposite } = soa.faces[(self.faces[face] / 3) as usize];
        let entry = opposite[side];
        if entry == NONE {
            return;
        }
        let neighbour = (entry / 3) as usize;
        if self.face_marks.is_selected(neighbour) {
            return;
        }
        // The corner that is not on the common side.
        let apex = soa.faces[neighbour].corners[OPPOSITE[(entry % 3) as usize]];
        let index = apex as usize;
        let local = localized(patch, scale, soa.positions[index]);
        let (from, to) = (corners[side], corners[NEXT[side]]);
        let around = [self.locals[to as usize], self.locals[from as usize], local];
        if !(is_upward([around[0].at, around[1].at, around[2].at]) && belongs(around)) {
            return;
        }
        let is_new = !self.vertex_marks.is_visited(index);
        self.faces[self.count] = entry;
        self.count += 1;
        self.face_marks.select(neighbour);
        // Writes the same value again if the vertex was visited before.
        self.locals[index] = local;
        self.vertex_marks.visit_if(index, is_new);
        unfiltered.vertices[unfiltered.count] = (apex, as_u32(self.count));
        unfiltered.count += usize::from(is_new);
    }

    /// Filters up to eight vertices.
    #[inline(always)]
    fn filter_vertices<S: Simd>(
        &mut self,
        simd: S,
        filter: &mut impl VertexFilter,
        unfiltered: &mut Unfiltered,
    ) -> ControlFlow<DVec3> {
        let count = unfiltered.count.min(LANES);
        let mut offsets = [DVec3::ZERO; LANES];
        for (offset, (vertex, _)) in offsets.iter_mut().zip(unfiltered.vertices) {
            *offset = self.locals[vertex as usize].at;
        }
        let (selected, last) = filter.filter(simd, &Vec3x8::gather(simd, offsets), count);
        for lane in LaneBits(selected) {
            self.vertex_marks.select(unfiltered.vertices[lane].0 as usize);
        }
        if let Some(last) = last {
            let (vertex, count) = unfiltered.vertices[last];
            self.count = count as usize;
            return ControlFlow::Break(self.soa.positions[vertex as usize]);
        }
        unfiltered.vertices.copy_within(LANES.., 0);
        unfiltered.count -= count;
        ControlFlow::Continue(())
    }
}

/// The two other sides of a face, in ascending order.
const OTHER_SIDES: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];

/// The corner opposite a side.
const OPPOSITE: [usize; 3] = [2, 0, 1];

/// The corner at the end of a side.
const NEXT: [usize; 3] = [1, 2, 0];

/// A vertex in the frame of a patch. `scale` maps the footprint to the unit disc.
#[inline(always)]
fn localized(patch: &Patch, scale: DVec2, position: DVec3) -> LocalVertex {
    let at = patch.turn_to_local(position - patch.origin());
    LocalVertex { at, square: (at.truncate() * scale).length_squared() }
}

/// Whether a triangle in the frame of a patch is counter-clockwise seen from above.
#[inline]
fn is_upward([a, b, c]: [DVec3; 3]) -> bool {
    (b - a).truncate().perp_dot((c - a).truncate()) > 0.0
}

/// Whether a triangle has a point over or under the footprint, up to rounding. `scale` maps the footprint
/// to the unit disc.
#[inline(always)]
fn is_over_disc([a, b, c]: [LocalVertex; 3], scale: DVec2) -> bool {
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
