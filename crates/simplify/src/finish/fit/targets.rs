//! Points of the original that the mesh is drawn to.

use glam::DVec3;
use mesh_metric::Surface;

use crate::finish::blocks::for_blocks_in_turn;
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
    #[inline]
    pub(crate) fn on_triangle([a, b, c]: [DVec3; 3], point: DVec3, share: f64) -> Self {
        Self { point, normal: (b - a).cross(c - a).normalize_or_zero(), share }
    }
}

/// Points of the original, neighbours close to each other.
pub(super) struct Targets<'a> {
    original: &'a Surface,
    spread: Spread<'a>,
    points: Vec<DVec3>,
    /// The place of the triangle of each.
    places: Vec<u32>,
}

/// Points that are made by one thread at a time.
const BLOCK: usize = 512;

impl<'a> Targets<'a> {
    /// About `count` points, by area.
    pub(super) fn new(original: &'a Surface, count: usize, seed: u64) -> Self {
        let corners = |t: u32| original.triangle(t as usize);
        let spread = Spread::new(original.in_space(), corners, count, seed);
        let mut points = Vec::with_capacity(spread.len());
        for_blocks_in_turn(
            spread.len(),
            BLOCK,
            |range| spread.spots(corners, range).map(|spot| spot.point).collect::<Vec<_>>(),
            |made| points.extend(made),
        );
        let places = spread.places();
        Self { original, spread, points, places }
    }

    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    pub(super) fn point(&self, index: usize) -> DVec3 {
        self.points[index]
    }

    /// A point as a target; `density` is the share of one that stands for the mean area of all.
    pub(super) fn target(&self, index: usize, density: f64) -> Target {
        let on = self
            .spread
            .spots_on(|t| self.original.triangle(t as usize), self.places[index] as usize);
        Target::on_triangle(on.corners, self.points[index], density * on.share)
    }
}
