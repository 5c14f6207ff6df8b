//! Heights of mesh vertices over and under a patch.

use fearless_simd::f64x8;
use fearless_simd::prelude::*;
use glam::DVec3;

use crate::height_bracket::HeightBracket;
use crate::patch::Patch;
use crate::patch_region::VertexFilter;
use crate::vec3x8::{LaneBits, Vec3x8};

/// Tests whether points are within a tolerance of a patch, measured along its normal.
pub(crate) struct HeightTest<'p> {
    patch: &'p Patch,
    bracket: Option<HeightBracket>,
    tolerance: f64,
}

impl<'p> HeightTest<'p> {
    pub(crate) fn new(patch: &'p Patch, tolerance: f64) -> Self {
        Self { patch, bracket: HeightBracket::new(patch), tolerance }
    }

    /// Whether a point is over or under the footprint and out of tolerance.
    #[inline]
    pub(crate) fn is_violated_by(&self, point: DVec3) -> bool {
        let local = self.patch.to_local(point);
        if !self.patch.contains(local.x, local.y) {
            return false;
        }
        let quick = self.bracket.and_then(|bracket| bracket.is_within(local, self.tolerance));
        quick.map_or_else(|| self.is_too_high(local), |is_within| !is_within)
    }

    /// The points among eight that are over or under the footprint and out of tolerance, as bits.
    ///
    /// `offsets` are relative to the origin of the patch. Only the lanes of `asked` are tested.
    #[inline(always)]
    pub(crate) fn violated_by<S: Simd>(&self, simd: S, offsets: &Vec3x8<S>, asked: u64) -> u64 {
        if asked == 0 {
            return 0;
        }
        let [e1, e2, e3] = self.patch.frame();
        let x = Vec3x8::splat(simd, e1).dot(*offsets);
        let y = Vec3x8::splat(simd, e2).dot(*offsets);
        let z = Vec3x8::splat(simd, e3).dot(*offsets);
        let [_, beyond] = self.classify(simd, &Vec3x8 { x, y, z }, asked);
        beyond
    }

    /// The points among eight over or under the footprint: those within tolerance and those beyond, as
    /// bits.
    ///
    /// `local` is in the frame of the patch. Only the lanes of `asked` are tested.
    #[inline(always)]
    fn classify<S: Simd>(&self, simd: S, local: &Vec3x8<S>, asked: u64) -> [u64; 2] {
        let [semi_x, semi_y] = self.patch.semi_axes();
        let share_x = local.x / f64x8::splat(simd, semi_x);
        let share_y = local.y / f64x8::splat(simd, semi_y);
        let square = share_x * share_x + share_y * share_y;
        let asked = asked & square.simd_le(f64x8::splat(simd, 1.0)).to_bitmask();
        let [mut within, mut beyond] = match &self.bracket {
            Some(bracket) => bracket.are_within(simd, local, self.tolerance, asked),
            None => [0; 2],
        };
        for lane in LaneBits(asked & !(within | beyond)) {
            let bits = if self.is_too_high(local.at(lane)) { &mut beyond } else { &mut within };
            *bits |= 1 << lane;
        }
        [within, beyond]
    }

    /// Whether a point in the frame of the patch is out of tolerance, by Newton's method.
    fn is_too_high(&self, local: DVec3) -> bool {
        !height_error(self.patch, local).is_none_or(|error| error <= self.tolerance)
    }
}

/// The height difference between a point, in the frame of the patch, and the patch. `None` outside the
/// footprint.
fn height_error(patch: &Patch, local: DVec3) -> Option<f64> {
    patch.height_in_footprint(local.x, local.y).map(|z| (local.z - z).abs())
}

/// Selects the vertices within tolerance of a patch, and stops at the first one beyond.
pub(crate) struct SelectWithin<'p> {
    test: HeightTest<'p>,
    /// Whether vertices beyond are ignored.
    ends_only: bool,
    /// Number of vertices seen so far.
    visited: usize,
    /// One in [`SAMPLE_STRIDE`] of the vertices of the largest region at this point.
    sample: &'p mut Vec<DVec3>,
}

/// One in this many vertices of a region is sampled for early rejection.
const SAMPLE_STRIDE: usize = 16;

impl<'p> SelectWithin<'p> {
    pub(crate) fn new(test: HeightTest<'p>, ends_only: bool, sample: &'p mut Vec<DVec3>) -> Self {
        Self { test, ends_only, visited: 0, sample }
    }
}

impl VertexFilter for SelectWithin<'_> {
    #[inline(always)]
    fn filter<S: Simd>(
        &mut self,
        simd: S,
        vertices: &Vec3x8<S>,
        count: usize,
    ) -> (u64, Option<usize>) {
        let [within, beyond] = self.test.classify(simd, vertices, (1 << count) - 1);
        let last = if self.ends_only { None } else { LaneBits(beyond).next() };
        let count = last.map_or(count, |last| last + 1);
        // Regions at one point begin with nearly the same vertices.
        while (self.visited + count) / SAMPLE_STRIDE > self.sample.len() {
            let index = (self.sample.len() + 1) * SAMPLE_STRIDE - 1;
            self.sample.push(self.test.patch.to_world(vertices.at(index - self.visited)));
        }
        self.visited += count;
        (within, last)
    }
}

/// Measures the largest height difference between the vertices and a patch.
pub(crate) struct MaxHeight<'p> {
    patch: &'p Patch,
    pub(crate) largest: f64,
}

impl<'p> MaxHeight<'p> {
    pub(crate) fn new(patch: &'p Patch) -> Self {
        Self { patch, largest: 0.0 }
    }
}

impl VertexFilter for MaxHeight<'_> {
    #[inline(always)]
    fn filter<S: Simd>(
        &mut self,
        _: S,
        vertices: &Vec3x8<S>,
        count: usize,
    ) -> (u64, Option<usize>) {
        for lane in 0..count {
            let error = height_error(self.patch, vertices.at(lane));
            self.largest = self.largest.max(error.unwrap_or(0.0));
        }
        (0, None)
    }
}
