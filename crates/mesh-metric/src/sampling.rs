//! Points spread evenly over a surface.

use glam::DVec3;
use mesh_core::parallel;
use mesh_core::shapes::SplitMix64;

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

/// `count` points, uniformly distributed by area, the same for the same seed.
///
/// The samples are stratified: the faces are laid out one after another along a line, each as long
/// as its area, the line is cut into `count` equal pieces, and each piece receives one sample. So
/// every face, and every group of consecutive faces, receives its share of the samples rounded up
/// or down. A surface without area has no samples.
#[must_use]
pub fn sample_surface(surface: &Surface, count: usize, seed: u64) -> Vec<SurfaceSample> {
    let sampler = AreaSampler::new(surface, count, seed);
    parallel::collect(sampler.count(), |i| sampler.sample(i))
}

/// The fractional part of the golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Makes the samples of [`sample_surface`] one at a time, in any order.
pub(crate) struct AreaSampler<'a> {
    surface: &'a Surface,
    /// The area up to and including each triangle.
    cumulative: Vec<f64>,
    count: usize,
    seed: u64,
    /// Where the sequence across the faces starts, in [0, 1).
    shift: f64,
}

impl<'a> AreaSampler<'a> {
    pub(crate) fn new(surface: &'a Surface, count: usize, seed: u64) -> Self {
        let mut cumulative = parallel::collect(surface.triangle_count(), |t| {
            let [a, b, c] = surface.triangle(t);
            0.5 * (b - a).cross(c - a).length()
        });
        let mut total = 0.0;
        for area in &mut cumulative {
            total += *area;
            *area = total;
        }
        let count = if total > 0.0 { count } else { 0 };
        let shift = SplitMix64::new(!seed).uniform();
        Self { surface, cumulative, count, seed, shift }
    }

    pub(crate) fn count(&self) -> usize {
        self.count
    }

    pub(crate) fn area(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    pub(crate) fn sample(&self, index: usize) -> SurfaceSample {
        let mut random =
            SplitMix64::new(self.seed ^ (index as u64).wrapping_mul(0xD605_1C7B_B5E2_37A5));
        let at = (index as f64 + random.uniform()) / self.count as f64 * self.area();
        let last = self.cumulative.len() - 1;
        let triangle = self.cumulative.partition_point(|&end| end <= at).min(last);
        let start = if triangle == 0 { 0.0 } else { self.cumulative[triangle - 1] };
        let area = self.cumulative[triangle] - start;
        // Where the line crosses the face is itself uniform, and stratified within large faces.
        let along = if area > 0.0 { ((at - start) / area).clamp(0.0, 1.0) } else { 0.5 };
        let root = along.sqrt();
        // Steps of the golden section spread consecutive samples evenly in the other direction.
        let across = (self.shift + index as f64 * GOLDEN).fract();
        let weights = [1.0 - root, root * (1.0 - across), root * across];
        let [a, b, c] = self.surface.triangle(triangle);
        let position = a + (b - a) * weights[1] + (c - a) * weights[2];
        SurfaceSample { position, triangle: triangle as u32, weights }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::TriMesh;

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
        for s in samples {
            assert!((s.weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert!(s.weights.iter().all(|&w| (0.0..=1.0).contains(&w)));
        }
    }
}
