//! The sections through one point in the planes of one normal.
//!
//! For discs of several radii a longer section goes on where a shorter one ended, so that each face is
//! crossed only once. The arcs have the bits that they have when they are walked alone.

use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use glam::DVec3;

use crate::march::{Party, Strides, Walker, arcs, march};
use crate::section::{Arc, Section, SectionPlane, WalkEnd};
use crate::surface_point::SurfacePoint;
use crate::terrain::Terrain;
use crate::wide::{LANES, LanesOf};

/// The sections of a face in planes through one point, of the length `radius` to each side; as
/// [`Section::measure`].
pub(crate) fn measure(
    terrain: &Terrain,
    start: u32,
    planes: &[SectionPlane],
    normal: DVec3,
    radius: f64,
) -> Vec<Section> {
    let origin = planes.first().map_or(DVec3::ZERO, |plane| plane.origin);
    let walkers: Vec<Option<[Walker; 2]>> =
        planes.iter().map(|plane| Walker::both_ways(terrain, start, plane)).collect();
    let going: Vec<[Walker; 2]> = walkers.iter().copied().flatten().collect();
    let mut walked = arcs(terrain, origin, start, &going, radius).into_iter();
    let section = |(plane, walkers): (&SectionPlane, &Option<[Walker; 2]>)| {
        let arcs = walkers.and_then(|_| walked.next()).unwrap_or([Arc::EMPTY; 2]);
        Section::new(arcs, plane, normal)
    };
    planes.iter().zip(&walkers).map(section).collect()
}

/// Sections through a point that go on from one radius to the next; none until they are asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sections {
    point: Option<SurfacePoint>,
    halves: Vec<[HalfSection; 2]>,
    /// Those that have not come to their end, with the section and the half that they walk.
    walkers: Vec<(Walker, [usize; 2])>,
}

impl Sections {
    /// Forgets the sections of another point.
    pub(crate) fn start(&mut self, point: SurfacePoint) {
        if self.point != Some(point) {
            self.point = Some(point);
            self.halves.clear();
            self.walkers.clear();
        }
    }

    /// The sections, always in the same planes through the point, of the length `radius` to each side.
    pub(crate) fn measure(
        &mut self,
        terrain: &Terrain,
        start: u32,
        planes: &[SectionPlane],
        normal: DVec3,
        radius: f64,
    ) -> Vec<Section> {
        if self.halves.is_empty() {
            for (number, plane) in planes.iter().enumerate() {
                let walkers = Walker::both_ways(terrain, start, plane);
                self.halves.push(walkers.map_or_else(Default::default, |walkers| {
                    walkers.map(|walker| HalfSection::new(walker.crossing()))
                }));
                let numbered = walkers.into_iter().flatten().zip(0..);
                self.walkers.extend(numbered.map(|(walker, half)| (walker, [number, half])));
            }
        }
        self.walk(terrain, start, planes, radius);
        let section = |(plane, halves): (&SectionPlane, &[HalfSection; 2])| {
            Section::new(halves.each_ref().map(|half| half.arc(radius)), plane, normal)
        };
        planes.iter().zip(&self.halves).map(section).collect()
    }

    /// Lets all halves go on that are shorter than `length` and can.
    fn walk(&mut self, terrain: &Terrain, start: u32, planes: &[SectionPlane], length: f64) {
        let origin = planes.first().map_or(DVec3::ZERO, |plane| plane.origin);
        let rested = Vec::with_capacity(self.walkers.len());
        let mut party = Prolonging {
            halves: &mut self.halves,
            walkers: core::mem::replace(&mut self.walkers, rested).into_iter(),
            rested: &mut self.walkers,
            which: [[0; 2]; LANES],
            length,
        };
        dispatch!(terrain.simd, simd => march(simd, terrain, origin, start, &mut party));
    }
}

/// Those that make halves of sections longer.
struct Prolonging<'s> {
    halves: &'s mut [[HalfSection; 2]],
    walkers: std::vec::IntoIter<(Walker, [usize; 2])>,
    rested: &'s mut Vec<(Walker, [usize; 2])>,
    /// What each lane walks.
    which: [[usize; 2]; LANES],
    length: f64,
}

impl Prolonging<'_> {
    fn half(&mut self, lane: usize) -> Option<&mut HalfSection> {
        let [number, half] = self.which[lane];
        self.halves.get_mut(number).map(|halves| &mut halves[half])
    }
}

impl<S: Simd> Party<S> for Prolonging<'_> {
    #[inline(always)]
    fn set_out(&mut self, lane: usize) -> Option<Walker> {
        while let Some((walker, which)) = self.walkers.next() {
            self.which[lane] = which;
            let length = self.length;
            if self.half(lane).is_some_and(|half| half.is_shorter_than(length)) {
                return Some(walker);
            }
            self.rested.push((walker, which));
        }
        None
    }

    #[inline(always)]
    fn stride(&mut self, _: S, strides: &Strides<S>) -> u64 {
        let (mut resting, length) = (0, self.length);
        for lane in LanesOf(strides.lanes) {
            if let Some(half) = self.half(lane) {
                half.go_on(strides.crossings.at(lane));
                resting |= u64::from(!half.is_shorter_than(length)) << lane;
            }
        }
        resting
    }

    #[inline(always)]
    fn rest(&mut self, lane: usize, walker: Walker) {
        self.rested.push((walker, self.which[lane]));
    }

    #[inline(always)]
    fn end(&mut self, lane: usize, cause: WalkEnd) {
        if let Some(half) = self.half(lane) {
            half.finish(cause);
        }
    }
}

/// One half of a section, as far as it has been walked.
#[derive(Clone, Debug, Default)]
struct HalfSection {
    steps: Vec<Step>,
    /// Where it ended and why, once it has.
    end: Option<(DVec3, f64, WalkEnd)>,
}

/// Room for so many steps is made at the outset.
const FEW_STEPS: usize = 32;

/// The part of a section in one face.
#[derive(Clone, Copy, Debug)]
struct Step {
    /// Where it enters the face, relative to the origin of the section.
    from: DVec3,
    /// The length up to there.
    walked: f64,
    ahead: DVec3,
    length: f64,
}

impl Step {
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
        let mut steps = Vec::with_capacity(FEW_STEPS);
        steps.push(Step::new(DVec3::ZERO, 0.0, crossing));
        Self { steps, end: None }
    }

    /// As [`SectionWalk::arc`](crate::section::SectionWalk::arc), of what has been walked.
    fn arc(&self, length: f64) -> Arc {
        let place = self.steps.partition_point(|step| step.end() < length);
        if let Some(step) = self.steps.get(place) {
            let end = step.from + (length - step.walked) / step.length * step.ahead;
            return Arc { end, length, cut_short: None };
        }
        match self.end {
            Some((end, length, cause)) => Arc { end, length, cut_short: Some(cause) },
            None => Arc::EMPTY,
        }
    }

    /// Whether it is shorter than this and can go on.
    #[inline]
    fn is_shorter_than(&self, length: f64) -> bool {
        self.end.is_none() && self.steps.last().is_some_and(|step| step.end() < length)
    }

    /// Goes on to where it leaves the next face.
    #[inline]
    fn go_on(&mut self, crossing: DVec3) {
        if let Some(last) = self.steps.last() {
            let step = Step::new(last.from + last.ahead, last.end(), crossing);
            self.steps.push(step);
        }
    }

    fn finish(&mut self, cause: WalkEnd) {
        self.end = self.steps.last().map(|last| (last.from + last.ahead, last.end(), cause));
    }
}
