//! The sections through one point, extended from one radius to the next.
//!
//! A longer section continues where the shorter one ended, so that each face is crossed only once. The
//! arcs have the bits of sections that are walked from their start.

use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use glam::DVec3;

use crate::section::Section;
use crate::section_arc::{SectionArc, WalkEnd};
use crate::section_arcs::measure_arcs;
use crate::section_plane::SectionPlane;
use crate::section_walk::{SectionWalk, WalkStep, WalkVisitor, walk_all};
use crate::soa_mesh::SoaMesh;
use crate::surface_point::SurfacePoint;
use crate::vec3x8::{LANES, LaneBits};

/// The sections of a face in planes through one point, of the length `radius` to each side; as
/// [`Section::measure`].
pub(crate) fn measure(
    soa: &SoaMesh,
    start: u32,
    planes: &[SectionPlane],
    normal: DVec3,
    radius: f64,
) -> Vec<Section> {
    let origin = planes.first().map_or(DVec3::ZERO, |plane| plane.origin);
    let walks: Vec<Option<[SectionWalk; 2]>> =
        planes.iter().map(|plane| SectionWalk::both_ways(soa, start, plane)).collect();
    let existing: Vec<[SectionWalk; 2]> = walks.iter().copied().flatten().collect();
    let mut arcs = measure_arcs(soa, origin, start, &existing, radius).into_iter();
    let section = |(plane, walks): (&SectionPlane, &Option<[SectionWalk; 2]>)| {
        let arcs = walks.and_then(|_| arcs.next()).unwrap_or([SectionArc::EMPTY; 2]);
        Section::new(arcs, plane, normal)
    };
    planes.iter().zip(&walks).map(section).collect()
}

/// The sections through a point in the planes of one normal, up to the length walked so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct ReusableSections {
    point: Option<SurfacePoint>,
    halves: Vec<[HalfSection; 2]>,
    /// The walks that can continue, with the index of the section and of its half.
    walks: Vec<(SectionWalk, [usize; 2])>,
}

impl ReusableSections {
    /// Forgets the sections of another point.
    pub(crate) fn start(&mut self, point: SurfacePoint) {
        if self.point != Some(point) {
            self.point = Some(point);
            self.halves.clear();
            self.walks.clear();
        }
    }

    /// The sections of the length `radius` to each side. The planes must be the same in each call for a
    /// point.
    pub(crate) fn measure(
        &mut self,
        soa: &SoaMesh,
        start: u32,
        planes: &[SectionPlane],
        normal: DVec3,
        radius: f64,
    ) -> Vec<Section> {
        if self.halves.is_empty() {
            for (index, plane) in planes.iter().enumerate() {
                let walks = SectionWalk::both_ways(soa, start, plane);
                self.halves.push(walks.map_or_else(Default::default, |walks| {
                    walks.map(|walk| HalfSection::new(walk.crossing()))
                }));
                let numbered = walks.into_iter().flatten().zip(0..);
                self.walks.extend(numbered.map(|(walk, half)| (walk, [index, half])));
            }
        }
        self.extend(soa, start, planes, radius);
        let section = |(plane, halves): (&SectionPlane, &[HalfSection; 2])| {
            Section::new(halves.each_ref().map(|half| half.arc(radius)), plane, normal)
        };
        planes.iter().zip(&self.halves).map(section).collect()
    }

    /// Continues all halves that are shorter than `length` and have not ended.
    fn extend(&mut self, soa: &SoaMesh, start: u32, planes: &[SectionPlane], length: f64) {
        let origin = planes.first().map_or(DVec3::ZERO, |plane| plane.origin);
        let paused = Vec::with_capacity(self.walks.len());
        let mut extension = Extension {
            halves: &mut self.halves,
            walks: core::mem::replace(&mut self.walks, paused).into_iter(),
            paused: &mut self.walks,
            half_of_lane: [[0; 2]; LANES],
            length,
        };
        dispatch!(soa.simd, simd => walk_all(simd, soa, origin, start, &mut extension));
    }
}

/// Extends halves of sections.
struct Extension<'s> {
    halves: &'s mut [[HalfSection; 2]],
    walks: std::vec::IntoIter<(SectionWalk, [usize; 2])>,
    paused: &'s mut Vec<(SectionWalk, [usize; 2])>,
    /// The section and the half of each lane.
    half_of_lane: [[usize; 2]; LANES],
    length: f64,
}

impl Extension<'_> {
    fn half(&mut self, lane: usize) -> Option<&mut HalfSection> {
        let [index, half] = self.half_of_lane[lane];
        self.halves.get_mut(index).map(|halves| &mut halves[half])
    }
}

impl<S: Simd> WalkVisitor<S> for Extension<'_> {
    #[inline(always)]
    fn next_walk(&mut self, lane: usize) -> Option<SectionWalk> {
        while let Some((walk, half_of_lane)) = self.walks.next() {
            self.half_of_lane[lane] = half_of_lane;
            let length = self.length;
            if self.half(lane).is_some_and(|half| half.can_extend_to(length)) {
                return Some(walk);
            }
            self.paused.push((walk, half_of_lane));
        }
        None
    }

    #[inline(always)]
    fn visit(&mut self, _: S, step: &WalkStep<S>) -> u64 {
        let (mut paused, length) = (0, self.length);
        for lane in LaneBits(step.lanes) {
            if let Some(half) = self.half(lane) {
                half.push(step.crossings.at(lane));
                paused |= u64::from(!half.can_extend_to(length)) << lane;
            }
        }
        paused
    }

    #[inline(always)]
    fn pause(&mut self, lane: usize, walk: SectionWalk) {
        self.paused.push((walk, self.half_of_lane[lane]));
    }

    #[inline(always)]
    fn finish(&mut self, lane: usize, cause: WalkEnd) {
        if let Some(half) = self.half(lane) {
            half.finish(cause);
        }
    }
}

/// One half of a section, up to the length walked so far.
#[derive(Clone, Debug, Default)]
struct HalfSection {
    segments: Vec<Segment>,
    /// The end point, the length and the reason for the end, once the half has ended.
    end: Option<(DVec3, f64, WalkEnd)>,
}

/// Initial capacity for segments.
const SEGMENT_CAPACITY: usize = 32;

/// The segment of a section in one face.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// The point where it enters the face, relative to the origin of the section.
    from: DVec3,
    /// The length of the section up to there.
    walked: f64,
    ahead: DVec3,
    length: f64,
}

impl Segment {
    #[inline]
    fn new(from: DVec3, walked: f64, crossing: DVec3) -> Self {
        let ahead = crossing - from;
        Self { from, walked, ahead, length: ahead.length() }
    }

    #[inline]
    fn end(&self) -> f64 {
        self.walked + self.length
    }
}

impl HalfSection {
    /// A half in its first face, which it leaves at `crossing`.
    fn new(crossing: DVec3) -> Self {
        let mut segments = Vec::with_capacity(SEGMENT_CAPACITY);
        segments.push(Segment::new(DVec3::ZERO, 0.0, crossing));
        Self { segments, end: None }
    }

    /// The arc of this length along the walked part; as [`ScalarWalk::arc`](crate::scalar_walk::ScalarWalk::arc).
    fn arc(&self, length: f64) -> SectionArc {
        let index = self.segments.partition_point(|segment| segment.end() < length);
        if let Some(last) = self.segments.get(index) {
            return SectionArc::full(length, last.walked, last.from, last.ahead, last.length);
        }
        match self.end {
            Some((end, length, cause)) => SectionArc { end, length, cut_short: Some(cause) },
            None => SectionArc::EMPTY,
        }
    }

    /// Whether the half is shorter than `length` and has not ended.
    #[inline]
    fn can_extend_to(&self, length: f64) -> bool {
        self.end.is_none() && self.segments.last().is_some_and(|segment| segment.end() < length)
    }

    /// Adds the segment of the next face, which the section leaves at `crossing`.
    #[inline]
    fn push(&mut self, crossing: DVec3) {
        if let Some(last) = self.segments.last() {
            let segment = Segment::new(last.from + last.ahead, last.end(), crossing);
            self.segments.push(segment);
        }
    }

    fn finish(&mut self, cause: WalkEnd) {
        self.end = self.segments.last().map(|last| (last.from + last.ahead, last.end(), cause));
    }
}
