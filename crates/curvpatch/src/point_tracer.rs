//! Sections from the centre of a patch to the faces straight under its test points.

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f64x8};
use glam::DVec3;

use crate::closest::closest_point;
use crate::height_test::HeightTest;
use crate::patch::Patch;
use crate::patch_fit::PatchFit;
use crate::patch_region::PatchRegion;
use crate::section_arc::WalkEnd;
use crate::section_plane::SectionPlane;
use crate::section_walk::{SectionWalk, WalkStep, WalkVisitor, walk_all};
use crate::soa_mesh::SoaMesh;
use crate::test_points::TestPoint;
use crate::vec3x8::{LANES, LaneBits, Vec3Lanes, Vec3x8, put};

/// The face straight under a point of a patch, if known.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Under {
    /// The face with this `SoaMesh` index.
    Face(u32),
    /// Nothing: the section reaches the boundary of the mesh before, in this face.
    Beyond(u32),
    /// Unknown: the section turns back or closes, or the walk was stopped.
    Unknown,
}

/// Which vertices along the sections are tested against the tolerance of the patch.
#[derive(Clone, Copy)]
pub(crate) enum VertexCheck<'h> {
    /// None.
    Nothing,
    /// All. Every walk stops at the first violating vertex of any section.
    Any(&'h HeightTest<'h>),
    /// All. The violating vertex of the section with the smallest index is reported.
    First(&'h HeightTest<'h>),
}

/// Walks sections to the faces under points of a patch.
pub(crate) struct PointTracer<'p> {
    soa: &'p SoaMesh,
    patch: &'p Patch,
    start: u32,
    points: core::iter::Enumerate<core::slice::Iter<'p, DVec3>>,
    check: VertexCheck<'p>,
    /// The face straight under each point.
    pub(crate) under: Vec<Under>,
    /// The index of a section, and its vertex that is out of tolerance, relative to the origin.
    pub(crate) violation: Option<(usize, DVec3)>,
    section_of_lane: [usize; LANES],
    tangents: Vec3Lanes,
    /// Distances of the points from the centre in the tangent plane.
    distances: [f64; LANES],
    /// Current and largest distance of each section from the centre, along its tangent.
    ahead: [f64; LANES],
    farthest: [f64; LANES],
    faces: [u32; LANES],
    /// The lanes whose sections only ran forward so far, as bits. All their faces after the first one
    /// look to the side of the normal of the patch.
    is_forward: u64,
}

/// How far a section may run backward in a fold, as a share of the distance of its point.
const DEEPEST_FOLD: f64 = 0.1;

impl PointTracer<'_> {
    fn record(&mut self, section: usize, under: Under) {
        if let Some(slot) = self.under.get_mut(section) {
            *slot = under;
        }
    }

    /// Whether a section cannot change the reported violation.
    fn is_idle(&self, section: usize) -> bool {
        matches!(self.check, VertexCheck::First(_))
            && self.violation.is_some_and(|(first, _)| first < section)
    }

    /// Tests the new vertices of a step. Returns the lanes whose walks stop.
    #[inline(always)]
    fn check_vertices<S: Simd>(&mut self, simd: S, step: &WalkStep<S>) -> u64 {
        let asked = self.is_forward & step.lanes;
        match self.check {
            VertexCheck::Nothing => 0,
            VertexCheck::Any(test) => {
                let violated = test.violated_by(simd, &step.apexes, asked);
                if let Some(lane) = LaneBits(violated).next() {
                    self.violation = Some((self.section_of_lane[lane], step.apexes.at(lane)));
                }
                0
            }
            VertexCheck::First(test) => {
                let violated = test.violated_by(simd, &step.apexes, asked);
                for lane in LaneBits(violated) {
                    let section = self.section_of_lane[lane];
                    if self.violation.is_none_or(|(first, _)| section < first) {
                        self.violation = Some((section, step.apexes.at(lane)));
                    }
                }
                let mut stopped = !asked | violated;
                if self.violation.is_some() {
                    for lane in LaneBits(step.lanes) {
                        stopped |= u64::from(self.is_idle(self.section_of_lane[lane])) << lane;
                    }
                }
                stopped
            }
        }
    }
}

impl<S: Simd> WalkVisitor<S> for PointTracer<'_> {
    #[inline(always)]
    fn next_walk(&mut self, lane: usize) -> Option<SectionWalk> {
        let [e1, e2, e3] = self.patch.frame();
        while let Some((section, local)) = self.points.next() {
            if self.is_idle(section) {
                return None;
            }
            let distance = local.truncate().length();
            let tangent = (local.x * e1 + local.y * e2) / distance;
            let plane = SectionPlane::new(self.patch.origin(), e3, tangent);
            let walks = SectionWalk::both_ways(self.soa, self.start, &plane);
            let Some([walk, _]) = walks else { continue };
            let ahead = walk.crossing().dot(tangent);
            if ahead < distance {
                self.section_of_lane[lane] = section;
                put(&mut self.tangents, lane, tangent);
                self.distances[lane] = distance;
                self.ahead[lane] = ahead;
                self.farthest[lane] = ahead;
                self.faces[lane] = self.start;
                self.is_forward |= 1 << lane;
                return Some(walk);
            }
            self.record(section, Under::Face(self.start));
        }
        None
    }

    #[inline(always)]
    fn visit(&mut self, simd: S, step: &WalkStep<S>) -> u64 {
        self.faces = step.faces;
        let entered: f64x8<S> = self.ahead.simd_into(simd);
        let distances: f64x8<S> = self.distances.simd_into(simd);
        let farthest: f64x8<S> = self.farthest.simd_into(simd);
        let ahead = step.crossings.dot(Vec3x8::load(simd, &self.tangents));
        let farthest = ahead.simd_gt(farthest).select(ahead, farthest);
        ahead.store_slice(&mut self.ahead);
        farthest.store_slice(&mut self.farthest);
        // A section runs forward through faces that look to the side of the normal. If it runs backward
        // for more than a small fold, there may be no face straight under the point.
        self.is_forward &= ahead.simd_ge(entered).to_bitmask();
        let folds = f64x8::splat(simd, DEEPEST_FOLD) * distances;
        let turned_back = ahead.simd_lt(farthest - folds).to_bitmask();
        let stopped = turned_back | self.check_vertices(simd, step);
        let arrived = !ahead.simd_lt(distances).to_bitmask();
        for lane in LaneBits(arrived & !stopped & step.lanes) {
            self.record(self.section_of_lane[lane], Under::Face(step.faces[lane]));
        }
        arrived | stopped
    }

    #[inline(always)]
    fn finish(&mut self, lane: usize, cause: WalkEnd) {
        if cause == WalkEnd::Boundary {
            self.record(self.section_of_lane[lane], Under::Beyond(self.faces[lane]));
        }
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        matches!(self.check, VertexCheck::Any(_)) && self.violation.is_some()
    }
}

/// Walks the sections to the faces under points, given in the frame of the patch.
pub(crate) fn trace_points<'p>(
    soa: &'p SoaMesh,
    fit: &'p PatchFit,
    points: &'p [DVec3],
    check: VertexCheck<'p>,
) -> PointTracer<'p> {
    let (patch, start) = (&fit.patch, soa.index_of(fit.point.face()));
    let mut tracer = PointTracer {
        soa,
        patch,
        start,
        points: points.iter().enumerate(),
        check,
        under: vec![Under::Unknown; points.len()],
        violation: None,
        section_of_lane: [0; LANES],
        tangents: [[0.0; LANES]; 3],
        distances: [0.0; LANES],
        ahead: [0.0; LANES],
        farthest: [0.0; LANES],
        faces: [start; LANES],
        is_forward: 0,
    };
    dispatch!(soa.simd, simd => walk_all(simd, soa, patch.origin(), start, &mut tracer));
    tracer
}

/// Distance of a point from the face with this `SoaMesh` index.
pub(crate) fn distance_to_face(at: DVec3, soa: &SoaMesh, face: u32) -> f64 {
    closest_point(at, soa.triangle(soa.faces[face as usize].corners)).0.distance(at)
}

/// Test points with upper bounds of their distances.
///
/// `points` are in the frame of the patch. The bound is the distance from the face straight under the
/// point, or from the face where the section reaches the boundary, if it belongs to the region.
pub(crate) fn bounded_test_points<'p>(
    region: &'p PatchRegion,
    fit: &'p PatchFit,
    points: &'p [DVec3],
) -> impl Iterator<Item = TestPoint> + 'p {
    let soa = region.soa();
    let under = trace_points(soa, fit, points, VertexCheck::Nothing).under;
    points.iter().zip(under).map(|(&local, under)| {
        let mut point = TestPoint::new(fit.patch.to_world(local));
        if let Under::Face(face) | Under::Beyond(face) = under
            && region.contains(face)
        {
            // Slightly enlarged, so that this face itself is measured later.
            point.distance = 1.000_001 * distance_to_face(point.at, soa, face);
        }
        point
    })
}
