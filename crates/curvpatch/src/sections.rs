//! The sections through one point in the planes of one normal, for discs of several radii.
//!
//! A longer section goes on where a shorter one ended, so that each face is crossed only once. The
//! arcs have the bits that they have when they are walked alone.

use glam::DVec3;
use mesh_core::TriMesh;

use crate::section::{Arc, Section, SectionPlane, SectionWalk, WalkEnd};
use crate::surface_point::SurfacePoint;

/// Sections through a point by their number; empty until they are asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sections<'a> {
    point: Option<SurfacePoint>,
    halves: Vec<Option<[HalfSection<'a>; 2]>>,
}

impl<'a> Sections<'a> {
    /// Forgets the sections of another point.
    pub(crate) fn start(&mut self, point: SurfacePoint) {
        if self.point != Some(point) {
            self.point = Some(point);
            self.halves.clear();
        }
    }

    /// The section with this number, always in the same plane, of the length `radius` to each side.
    pub(crate) fn measure(
        &mut self,
        number: usize,
        mesh: &'a TriMesh,
        plane: &SectionPlane,
        normal: DVec3,
        radius: f64,
    ) -> Section {
        let Some(face) = self.point.map(|point| point.face()) else {
            return Section::new([Arc::EMPTY; 2], plane, normal);
        };
        if self.halves.len() <= number {
            self.halves.resize_with(number + 1, || None);
        }
        let halves = self.halves[number].get_or_insert_with(|| {
            let walks = SectionWalk::both_ways(mesh, face, plane);
            walks.map_or_else(Default::default, |walks| walks.map(HalfSection::new))
        });
        Section::new(halves.each_mut().map(|half| half.arc(radius)), plane, normal)
    }
}

/// One half of a section, as far as it has been walked.
#[derive(Clone, Debug, Default)]
struct HalfSection<'a> {
    /// The walker in the last face, and where it will leave it; `None` where it cannot go on.
    walk: Option<SectionWalk<'a>>,
    steps: Vec<Step>,
    /// Where it ended and why, once it has.
    end: Option<(DVec3, f64, WalkEnd)>,
}

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
    fn new(from: DVec3, walked: f64, crossing: DVec3) -> Self {
        let ahead = crossing - from;
        Self { from, walked, ahead, length: ahead.length() }
    }

    fn end(&self) -> f64 {
        self.walked + self.length
    }
}

impl<'a> HalfSection<'a> {
    fn new(walk: SectionWalk<'a>) -> Self {
        let steps = vec![Step::new(DVec3::ZERO, 0.0, walk.crossing())];
        Self { walk: Some(walk), steps, end: None }
    }

    /// As [`SectionWalk::arc`].
    fn arc(&mut self, length: f64) -> Arc {
        while self.steps.last().is_some_and(|step| step.end() < length) && self.end.is_none() {
            self.go_on();
        }
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

    fn go_on(&mut self) {
        let (Some(walk), Some(last)) = (&mut self.walk, self.steps.last()) else { return };
        let (at, walked) = (last.from + last.ahead, last.end());
        match walk.step() {
            Ok(()) => self.steps.push(Step::new(at, walked, walk.crossing())),
            Err(cause) => self.end = Some((at, walked, cause)),
        }
    }
}
