//! Stratified samples of a surface, uniform by area.

use core::ops::{AddAssign, Range};

use glam::DVec3;
use mesh_core::parallel;
use mesh_core::{SplitMix64, as_u32};

use crate::surface::Surface;

/// A point of a surface; made by [`sample_surface`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfaceSample {
    /// The point.
    pub position: DVec3,
    /// The triangle that it lies on.
    pub triangle: u32,
    /// The weights of the triangle's corners; they add up to one.
    pub weights: [f64; 3],
}

/// `count` points, uniformly distributed by area and determined by the seed.
///
/// Stratification: the faces lie one after another on a line, each as long as its area. The line is cut into
/// `count` equal intervals, and each interval gets one sample. So every face, and every group of consecutive
/// faces, gets its share of the samples, rounded up or down. A surface without area has no samples.
#[must_use]
pub fn sample_surface(surface: &Surface, count: usize, seed: u64) -> Vec<SurfaceSample> {
    let sampler = AreaSampler::new(surface, count, seed);
    parallel::concat_blocks(sampler.count(), |indices| sampler.samples(indices).collect())
}

/// The fractional part of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Makes any range of the samples of [`sample_surface`].
pub(crate) struct AreaSampler<'a> {
    surface: &'a Surface,
    /// The area up to and including each triangle.
    cumulative: Vec<f64>,
    rule: Rule,
}

impl<'a> AreaSampler<'a> {
    pub(crate) fn new(surface: &'a Surface, count: usize, seed: u64) -> Self {
        let areas = parallel::collect(surface.triangle_count(), |t| area_of(surface.triangle(t)));
        let cumulative = running_totals(areas);
        let total = cumulative.last().copied().unwrap_or(0.0);
        Self { surface, cumulative, rule: Rule::new(total, count, seed) }
    }

    pub(crate) fn count(&self) -> usize {
        self.rule.count
    }

    pub(crate) fn area(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    pub(crate) fn samples(&self, indices: Range<usize>) -> impl Iterator<Item = SurfaceSample> {
        let (last, mut next) = (self.cumulative.len().saturating_sub(1), 0);
        indices.map(move |index| {
            let at = self.rule.place(index);
            next = first_beyond(&self.cumulative, at, next);
            let triangle = next.min(last);
            let start = if triangle == 0 { 0.0 } else { self.cumulative[triangle - 1] };
            let corners = self.surface.triangle(triangle);
            let (position, weights) =
                self.rule.point(index, at, [start, self.cumulative[triangle]], corners);
            SurfaceSample { position, triangle: as_u32(triangle), weights }
        })
    }
}

/// Running totals.
pub(crate) fn running_totals<T: Default + Copy + AddAssign>(mut numbers: Vec<T>) -> Vec<T> {
    let mut total = T::default();
    for number in &mut numbers {
        total += *number;
        *number = total;
    }
    numbers
}

/// The number of ascending numbers that are at most `at`, given that the first `known` are. Fast if the result
/// is near `known`.
pub(crate) fn first_beyond<T: PartialOrd + Copy>(numbers: &[T], at: T, known: usize) -> usize {
    let (mut known, mut step) = (known, 1);
    while numbers.get(known + step - 1).is_some_and(|&number| number <= at) {
        known += step;
        step *= 2;
    }
    let few = &numbers[known..numbers.len().min(known + step)];
    known + few.partition_point(|&number| number <= at)
}

/// The samples of [`sample_surface`], for a stream of triangles.
pub struct SampleStream {
    rule: Rule,
    /// The area of all triangles so far.
    covered: f64,
    /// The index of the next sample and its position on the line.
    next: usize,
    at: f64,
}

impl SampleStream {
    /// `count` samples of a surface of a given area, which is the sum of [`area_of`] over its triangles in
    /// order.
    #[must_use]
    pub fn new(area: f64, count: usize, seed: u64) -> Self {
        let rule = Rule::new(area, count, seed);
        Self { at: rule.place(0), rule, covered: 0.0, next: 0 }
    }

    /// Calls `take` with the samples on the next triangle; on the last triangle with all remaining samples.
    pub fn pass(&mut self, corners: [DVec3; 3], is_last: bool, take: &mut dyn FnMut(DVec3)) {
        let start = self.covered;
        self.covered += area_of(corners);
        while self.next < self.rule.count && (self.at < self.covered || is_last) {
            take(self.rule.point(self.next, self.at, [start, self.covered], corners).0);
            self.next += 1;
            self.at = self.rule.place(self.next);
        }
    }
}

/// The area of a triangle.
#[must_use]
pub fn area_of([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// The positions of samples on the line of faces and within their faces.
struct Rule {
    area: f64,
    count: usize,
    seed: u64,
    /// Start of the sequence across the faces, in [0, 1).
    shift: f64,
}

impl Rule {
    fn new(area: f64, count: usize, seed: u64) -> Self {
        let count = if area > 0.0 { count } else { 0 };
        Self { area, count, seed, shift: SplitMix64::new(!seed).uniform() }
    }

    /// The position of a sample on the line.
    fn place(&self, index: usize) -> f64 {
        let mut random =
            SplitMix64::new(self.seed ^ (index as u64).wrapping_mul(0xD605_1C7B_B5E2_37A5));
        (index as f64 + random.uniform()) / self.count as f64 * self.area
    }

    /// A sample on the face that covers an interval of the line, and the weights of its corners.
    fn point(
        &self,
        index: usize,
        at: f64,
        [start, end]: [f64; 2],
        [a, b, c]: [DVec3; 3],
    ) -> (DVec3, [f64; 3]) {
        let area = end - start;
        // The relative position in the face's interval is uniform, and stratified within large faces.
        let along = if area > 0.0 { ((at - start) / area).clamp(0.0, 1.0) } else { 0.5 };
        let root = along.sqrt();
        // Steps of the golden ratio distribute consecutive samples evenly in the other direction.
        let across = (self.shift + index as f64 * GOLDEN).fract();
        let weights = [1.0 - root, root * (1.0 - across), root * across];
        (a + (b - a) * weights[1] + (c - a) * weights[2], weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::TriMesh;

    #[test]
    fn numbers_are_counted_from_where_it_is_known() {
        let numbers = [1, 1, 2, 4, 4, 4, 7, 9, 9, 12];
        for at in 0..14 {
            let count = numbers.iter().filter(|&&number| number <= at).count();
            for known in 0..=count {
                assert_eq!(first_beyond(&numbers, at, known), count, "{at} {known}");
            }
        }
        assert_eq!(first_beyond(&[], 1, 0), 0);
    }

    #[test]
    fn samples_are_shared_out_by_area() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 3.0, 0.0]];
        let mesh = TriMesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap();
        let surface = Surface::new(&mesh).unwrap();
        let samples = sample_surface(&surface, 4000, 7);
        let small = samples.iter().filter(|s| s.triangle == 0).count();
        assert!(small.abs_diff(1000) <= 1, "{small}");
        let center = samples.iter().map(|s| s.position).sum::<DVec3>() / 4000.0;
        // The centre of mass: a quarter of (2/3, 1/3, 0) and three quarters of (1/3, 4/3, 0).
        assert!(center.distance(DVec3::new(5.0 / 12.0, 13.0 / 12.0, 0.0)) < 0.02, "{center}");
        let mut stream = SampleStream::new(2.0, 4000, 7);
        let mut passed = Vec::new();
        for t in 0..2 {
            stream.pass(surface.triangle(t), t == 1, &mut |position| passed.push(position));
        }
        assert!(samples.iter().map(|s| s.position).eq(passed));
        // From anywhere on.
        let sampler = AreaSampler::new(&surface, 4000, 7);
        assert!(sampler.samples(990..1010).eq(samples[990..1010].iter().copied()));
        for s in samples {
            assert!((s.weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert!(s.weights.iter().all(|&w| (0.0..=1.0).contains(&w)));
        }
    }
}
