//! Points of the original that attract the mesh.

use core::ops::Range;
use std::borrow::Cow;

use glam::DVec3;
use mesh_metric::Surface;

use crate::block_loop::for_blocks_in_turn;
use crate::fit::spread::Spread;

/// A point of the original that attracts the mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FitTarget {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
    /// The area that it represents, relative to a pair at the usual density.
    pub(crate) share: f64,
    /// The triangle that contains it, if known.
    pub(crate) triangle: Option<u32>,
}

impl FitTarget {
    /// A point of a triangle of the original.
    #[inline]
    pub(crate) fn on_triangle(
        triangle: u32,
        corners: [DVec3; 3],
        point: DVec3,
        share: f64,
    ) -> Self {
        Self { point, normal: normal_and_area(corners).0, share, triangle: Some(triangle) }
    }
}

/// The unit normal of a triangle, zero where it has none, and its area.
#[inline]
pub(super) fn normal_and_area([a, b, c]: [DVec3; 3]) -> (DVec3, f64) {
    let cross = (b - a).cross(c - a);
    let length = cross.length();
    let normal = cross / length;
    (if normal.is_finite() { normal } else { DVec3::ZERO }, 0.5 * length)
}

/// Points of the original, ordered so that consecutive points are close in space.
pub(super) struct Targets<'a> {
    original: &'a Surface,
    spread: Spread<'a>,
    /// The positions and triangles of the points. If each triangle has the same number, there are the most points, and
    /// storing them would take more memory than the rest of a fit. They are then computed when needed.
    kept: Option<(Vec<DVec3>, Vec<u32>)>,
    /// The factor on the squared distances at each triangle of the original.
    importance: Option<&'a [f64]>,
}

/// The number of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Count {
    /// This number on each triangle.
    OnEach(usize),
    /// About this number in total, by area.
    About(usize),
}

/// The number of points in a block for one thread.
const BLOCK: usize = 512;

impl<'a> Targets<'a> {
    pub(super) fn new(original: &'a Surface, count: Count, seed: u64) -> Self {
        let (order, corners) = (original.in_space(), |t: u32| original.triangle(t as usize));
        let spread = match count {
            Count::OnEach(count) => Spread::on_each(order, corners, count, seed),
            Count::About(count) => Spread::new(order, corners, count, seed),
        };
        let kept = spread.places().map(|places| {
            let mut points = Vec::with_capacity(spread.len());
            for_blocks_in_turn(
                spread.len(),
                BLOCK,
                |range| spread.points(corners, range),
                |made| points.extend(made),
            );
            (points, places)
        });
        Self { original, spread, kept, importance: None }
    }

    /// The same points, with a factor on the squared distances at each triangle of the original.
    pub(super) fn weighted(self, importance: Option<&'a [f64]>) -> Self {
        Self { importance, ..self }
    }

    fn importance_at(&self, triangle: u32) -> f64 {
        self.importance.map_or(1.0, |all| all[triangle as usize])
    }

    /// The factor on the squared distance of a point.
    #[inline]
    pub(super) fn importance_of(&self, index: usize) -> f64 {
        match self.importance {
            None => 1.0,
            Some(_) => self.importance_at(self.spread.triangle(self.place(index))),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.spread.len()
    }

    pub(super) fn points(&self, range: Range<usize>) -> Cow<'_, [DVec3]> {
        match &self.kept {
            Some((points, _)) => Cow::Borrowed(&points[range]),
            None => Cow::Owned(self.spread.points(|t| self.original.triangle(t as usize), range)),
        }
    }

    #[inline]
    pub(super) fn point(&self, index: usize) -> DVec3 {
        match &self.kept {
            Some((points, _)) => points[index],
            None => self.spread.point(|t| self.original.triangle(t as usize), index),
        }
    }

    /// The place of the triangle of a point.
    #[inline]
    pub(super) fn place(&self, index: usize) -> usize {
        match &self.kept {
            Some((_, places)) => places[index] as usize,
            None => self.spread.place_of(index),
        }
    }

    /// The normal of the triangle of a point, of any length.
    #[inline]
    pub(super) fn normal(&self, index: usize) -> DVec3 {
        let triangle = self.spread.triangle(self.place(index));
        let [a, b, c] = self.original.triangle(triangle as usize);
        (b - a).cross(c - a)
    }

    /// The data shared by the targets on the triangle at a place. `density` is the share of a target that represents
    /// the mean area of all.
    pub(super) fn on(&self, place: usize, density: f64) -> Ground {
        let triangle = self.spread.triangle(place);
        let (normal, area) = normal_and_area(self.original.triangle(triangle as usize));
        let share = density * self.spread.share(place, || area) * self.importance_at(triangle);
        Ground { place, triangle, normal, share }
    }
}

/// The data of a triangle of the original that its targets share.
pub(super) struct Ground {
    pub(super) place: usize,
    triangle: u32,
    normal: DVec3,
    share: f64,
}

impl Ground {
    #[inline]
    pub(super) fn target(&self, point: DVec3) -> FitTarget {
        let Self { normal, share, triangle, .. } = *self;
        FitTarget { point, normal, share, triangle: Some(triangle) }
    }
}
