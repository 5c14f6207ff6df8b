//! Points spread over triangles by area, each with the share of the area that it stands for.
//!
//! Triangles that are given so that neighbours in order are neighbours in space receive points at
//! even steps of the area along the order: so every region receives its share of the points, rounded
//! up or down, and eight consecutive points are close to each other.

use core::ops::Range;

use glam::DVec3;
use mesh_core::parallel;
use mesh_core::shapes::SplitMix64;

/// Points on triangles.
pub(crate) struct Spread<'a, Corners> {
    /// Indices of triangles, neighbours in space.
    order: &'a [u32],
    corners: Corners,
    /// The number of points up to and including each of them.
    ends: Vec<u32>,
    /// The area that a point stands for on average.
    step: f64,
    /// Whether every triangle has a point, or else all points stand for the same area.
    on_each: bool,
    /// Where the sequence across the triangles starts, in [0, 1).
    shift: f64,
}

/// One of the points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    /// The place of its triangle in the order.
    pub(crate) place: usize,
    pub(crate) triangle: u32,
    pub(crate) point: DVec3,
    /// The weights of the corners.
    pub(crate) weights: DVec3,
    /// The area that it stands for, relative to the mean.
    pub(crate) share: f64,
}

/// The fractional part of the golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

impl<'a, Corners: Fn(u32) -> [DVec3; 3] + Sync> Spread<'a, Corners> {
    /// About `count` points. Where there are fewer triangles, each has one at least; where there
    /// are more, some have none.
    pub(crate) fn new(order: &'a [u32], corners: Corners, count: usize, seed: u64) -> Self {
        let areas = parallel::collect(order.len(), |i| area(&corners(order[i])));
        let total: f64 = areas.iter().sum();
        let on_each = order.len() <= count;
        let step = total / count.max(1) as f64;
        let shift = SplitMix64::new(!seed).uniform();
        let (mut covered, mut given, mut end) = (0.0, 0, 0);
        let ends = areas.iter().map(|&area| {
            covered += area;
            // Half a step on, so that the points are in the middle of their steps.
            let until = (covered / step + 0.5) as u64;
            let points = (until - given).max(u64::from(on_each));
            given = until;
            end += if area > 0.0 { points } else { 0 };
            end.min(u64::from(u32::MAX)) as u32
        });
        let ends = ends.collect();
        Self { order, corners, ends, step, on_each, shift }
    }

    /// How many points there are.
    pub(crate) fn len(&self) -> usize {
        self.ends.last().map_or(0, |&end| end as usize)
    }

    /// The points on the triangles in a range of places.
    pub(crate) fn on(&self, places: Range<usize>) -> Range<usize> {
        let until = |place: usize| match place.checked_sub(1) {
            Some(last) => self.ends[last] as usize,
            None => 0,
        };
        until(places.start)..until(places.end)
    }

    /// Points by their numbers, in order.
    pub(crate) fn spots(&self, range: Range<usize>) -> impl Iterator<Item = Spot> + '_ {
        let first = self.ends.partition_point(|&end| end as usize <= range.start);
        (first..self.order.len())
            .map_while(move |place| {
                let on = self.on(place..place + 1);
                (on.start < range.end).then_some((place, on))
            })
            .flat_map(move |(place, on)| {
                let triangle = self.order[place];
                let corners = (self.corners)(triangle);
                let part = 1.0 / on.len().max(1) as f64;
                let share = if self.on_each { part * area(&corners) / self.step } else { 1.0 };
                let numbers = on.start.max(range.start)..on.end.min(range.end);
                numbers.map(move |number| {
                    let weights = match on.len() {
                        1 => DVec3::splat(1.0 / 3.0),
                        _ => self.weights(number, ((number - on.start) as f64 + 0.5) * part),
                    };
                    let [a, b, c] = corners;
                    let point = a + (b - a) * weights.y + (c - a) * weights.z;
                    Spot { place, triangle, point, weights, share }
                })
            })
    }

    /// The weights of the corners for the point that is so far along its triangle.
    fn weights(&self, number: usize, along: f64) -> DVec3 {
        let root = along.sqrt();
        // Steps of the golden section spread consecutive points evenly in the other direction.
        let across = (self.shift + number as f64 * GOLDEN).fract();
        DVec3::new(1.0 - root, root * (1.0 - across), root * across)
    }
}

pub(crate) fn area(&[a, b, c]: &[DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strips of a square, the first one twice as wide as the others.
    fn strip(index: u32) -> [DVec3; 3] {
        let width = if index == 0 { 2.0 } else { 1.0 };
        [DVec3::ZERO, DVec3::new(width, 0.0, 0.0), DVec3::new(0.0, 1.0, f64::from(index))]
    }

    #[test]
    fn shares_add_up_to_the_area() {
        let order: Vec<u32> = (0..100).rev().collect();
        let total: f64 = order.iter().map(|&t| area(&strip(t))).sum();
        for count in [7, 100, 1000] {
            let spread = Spread::new(&order, strip, count, 3);
            let sum: f64 = spread.spots(0..spread.len()).map(|spot| spot.share).sum();
            let wanted = spread.step * sum;
            // Without a point on each triangle the total is rounded to whole points.
            let rounding = if count < 100 { spread.step } else { 1e-9 };
            assert!((wanted - total).abs() <= rounding, "{count}: {wanted}, not {total}");
            assert!(spread.len().abs_diff(count) <= 100);
        }
    }

    #[test]
    fn points_are_on_their_triangles_and_numbered_through() {
        let order = [3, 0, 2];
        let spread = Spread::new(&order, strip, 40, 1);
        let all: Vec<Spot> = spread.spots(0..spread.len()).collect();
        assert_eq!(all.len(), spread.len());
        let part: Vec<Spot> = spread.spots(5..17).collect();
        for (spot, same) in all[5..17].iter().zip(&part) {
            assert_eq!((spot.triangle, spot.point), (same.triangle, same.point));
        }
        assert_eq!(part.len(), 12);
        for spot in &all {
            let [a, b, c] = strip(spot.triangle);
            let w = spot.weights;
            assert!(w.min_element() >= 0.0 && (w.element_sum() - 1.0).abs() < 1e-15);
            assert!((w.x * a + w.y * b + w.z * c).distance(spot.point) < 1e-12);
            assert_eq!(spot.triangle, order[spot.place]);
        }
        let second = spread.on(1..2);
        assert!(all[second].iter().all(|spot| spot.triangle == 0));
    }

    #[test]
    fn triangles_without_area_have_no_points() {
        let flat = |t: u32| if t == 1 { [DVec3::ONE; 3] } else { strip(0) };
        let spread = Spread::new(&[0, 1, 2], flat, 10, 1);
        assert!(spread.on(1..2).is_empty());
        assert_eq!(spread.len(), 10);
        let nothing = Spread::new(&[1], flat, 10, 1);
        assert_eq!(nothing.len(), 0);
    }
}
