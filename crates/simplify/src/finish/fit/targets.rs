//! Points of the original that the mesh is drawn to.

use glam::DVec3;
use mesh_core::parallel;
use mesh_metric::Surface;

use crate::finish::fit::spread::Spread;

/// A point of the original that the mesh is drawn to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
    /// How much of the area it stands for, relative to that of a pair at the usual density.
    pub(crate) share: f64,
}

impl Target {
    /// A point of a triangle of the original.
    pub(crate) fn on_triangle(original: &Surface, triangle: u32, point: DVec3, share: f64) -> Self {
        let [a, b, c] = original.triangle(triangle as usize);
        Self { point, normal: (b - a).cross(c - a).normalize_or_zero(), share }
    }
}

/// Points of the original, neighbours close to each other.
pub(super) struct Targets {
    pub(super) points: Vec<DVec3>,
    /// The triangle of each.
    triangles: Vec<u32>,
    /// The area that each stands for, relative to the mean.
    shares: Vec<f32>,
}

/// Points that are made by one thread at a time.
const BLOCK: usize = 4096;

impl Targets {
    /// About `count` points, uniform by area.
    pub(super) fn new(original: &Surface, count: usize, seed: u64) -> Self {
        let corners = |t: u32| original.triangle(t as usize);
        let spread = Spread::new(original.in_space(), corners, count, seed);
        let count = spread.len();
        let mut all = Self {
            points: Vec::with_capacity(count),
            triangles: Vec::with_capacity(count),
            shares: Vec::with_capacity(count),
        };
        // A few blocks at a time, so that nothing is there twice.
        for batch in (0..count).step_by(64 * BLOCK) {
            let end = count.min(batch + 64 * BLOCK);
            let blocks = (end - batch).div_ceil(BLOCK);
            let made = parallel::collect_with(
                blocks,
                || (),
                |(), block| {
                    let start = batch + block * BLOCK;
                    spread.spots(start..end.min(start + BLOCK)).collect::<Vec<_>>()
                },
            );
            for spot in made.iter().flatten() {
                all.points.push(spot.point);
                all.triangles.push(spot.triangle);
                all.shares.push(spot.share as f32);
            }
        }
        all
    }

    pub(super) fn target(&self, original: &Surface, index: usize, density: f64) -> Target {
        let share = density * f64::from(self.shares[index]);
        Target::on_triangle(original, self.triangles[index], self.points[index], share)
    }
}
