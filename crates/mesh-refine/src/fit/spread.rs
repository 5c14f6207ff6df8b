//! Points spread over triangles by area, each with its share of the area.
//!
//! Consecutive triangles should be neighbours in space. Points are placed at equal steps of area along this order. So
//! every block of triangles receives its share of the points, rounded up or down, and eight consecutive points are
//! close to each other.

use core::ops::Range;

use glam::DVec3;
use mesh_core::parallel;
use mesh_core::{SplitMix64, as_u32};

/// The distribution of points over triangles. The caller passes the corners of the triangles with each query.
pub(crate) struct Spread<'a> {
    /// Indices of triangles, in an order in which neighbours are close in space.
    order: &'a [u32],
    numbers: Numbers,
    /// The mean area per point.
    step: f64,
    /// Whether every triangle has a point, with different shares; otherwise all points have the same share.
    shares: bool,
    /// Start of the sequence across the triangles, in [0, 1).
    shift: f64,
}

/// The points of each triangle, by number.
enum Numbers {
    /// This number of points on each.
    Each(usize),
    /// For each triangle, the number at which its points end.
    Until(Vec<u32>),
}

/// One of the points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    /// The place of its triangle in the order.
    pub(crate) place: usize,
    pub(crate) triangle: u32,
    pub(crate) point: DVec3,
    /// Barycentric weights.
    pub(crate) weights: DVec3,
    /// The area per point, relative to the mean.
    pub(crate) share: f64,
}

/// A triangle and its points.
pub(crate) struct Spots {
    place: usize,
    pub(crate) triangle: u32,
    pub(crate) corners: [DVec3; 3],
    numbers: Range<usize>,
    /// The area that each point represents, relative to the mean.
    pub(crate) share: f64,
    shift: f64,
}

/// The fractional part of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Weights of a rule with three points that integrates quadratic functions over a triangle exactly. Each point is
/// nearest to one corner (Strang and Fix 1973, table 4.1).
const THREE: [f64; 3] = [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0];

/// Weights of a rule with six points that is exact for cubic functions; the points are all permutations of these
/// weights (ibid.).
const SIX: [f64; 3] = [0.659_027_622_374_092, 0.231_933_368_553_031, 0.109_039_009_072_877];

impl<'a> Spread<'a> {
    /// About `count` points. If there are fewer triangles than that, each has at least one point; otherwise some have
    /// none.
    pub(crate) fn new(
        order: &'a [u32],
        corners: impl Fn(u32) -> [DVec3; 3] + Sync,
        count: usize,
        seed: u64,
    ) -> Self {
        Self::by_area(order, corners, count, (order.len() <= count, seed))
    }

    /// About `count` points with equal shares. Small triangles may have none.
    pub(crate) fn even(
        order: &'a [u32],
        corners: impl Fn(u32) -> [DVec3; 3] + Sync,
        count: usize,
        seed: u64,
    ) -> Self {
        Self::by_area(order, corners, count, (false, seed))
    }

    /// `count` points on each triangle of any size; no points if the total area is zero.
    pub(crate) fn on_each(
        order: &'a [u32],
        corners: impl Fn(u32) -> [DVec3; 3] + Sync,
        count: usize,
        seed: u64,
    ) -> Self {
        let total = parallel::sum(order.len(), |i| area(&corners(order[i])));
        let count = if total > 0.0 { count } else { 0 };
        let step = total / (order.len() * count).max(1) as f64;
        Self { order, numbers: Numbers::Each(count), step, shares: true, shift: shift(seed) }
    }

    fn by_area(
        order: &'a [u32],
        corners: impl Fn(u32) -> [DVec3; 3] + Sync,
        count: usize,
        (on_each, seed): (bool, u64),
    ) -> Self {
        let areas = parallel::collect(order.len(), |i| area(&corners(order[i])));
        let total: f64 = areas.iter().sum();
        let step = total / count.max(1) as f64;
        let (mut covered, mut given, mut end) = (0.0, 0, 0);
        let ends = areas.iter().map(|&area| {
            covered += area;
            // The offset of half a step puts each point in the middle of its step.
            let until = (covered / step + 0.5) as u64;
            let points = (until - given).max(u64::from(on_each));
            given = until;
            end += if area > 0.0 { points } else { 0 };
            u32::try_from(end).unwrap_or(u32::MAX)
        });
        let numbers = Numbers::Until(ends.collect());
        Self { order, numbers, step, shares: on_each, shift: shift(seed) }
    }

    /// The number of points.
    pub(crate) fn len(&self) -> usize {
        self.until(self.order.len())
    }

    /// The numbers of the points on the triangles in a range of places.
    pub(crate) fn on(&self, places: Range<usize>) -> Range<usize> {
        self.until(places.start)..self.until(places.end)
    }

    /// The number of points on the triangles before a place.
    fn until(&self, place: usize) -> usize {
        match &self.numbers {
            Numbers::Each(count) => place * count,
            Numbers::Until(ends) => place.checked_sub(1).map_or(0, |last| ends[last] as usize),
        }
    }

    /// The place of the triangle of each point; `None` if all triangles have the same number.
    pub(crate) fn places(&self) -> Option<Vec<u32>> {
        let Numbers::Until(ends) = &self.numbers else { return None };
        let mut places = Vec::with_capacity(self.len());
        for (place, &end) in ends.iter().enumerate() {
            places.resize(end as usize, as_u32(place));
        }
        Some(places)
    }

    /// The position of a point.
    #[inline]
    pub(crate) fn point(&self, corners: impl Fn(u32) -> [DVec3; 3], number: usize) -> DVec3 {
        self.spots_with(corners, self.place_of(number), |_| 1.0).spot(number).point
    }

    /// The positions of a range of points.
    pub(crate) fn points(
        &self,
        corners: impl Fn(u32) -> [DVec3; 3],
        range: Range<usize>,
    ) -> Vec<DVec3> {
        let mut points = Vec::with_capacity(range.len());
        let mut place = self.place_of(range.start);
        while points.len() < range.len() && place < self.order.len() {
            let spots = self.spots_with(&corners, place, |_| 1.0);
            let numbers = spots.numbers.start.max(range.start)..spots.numbers.end.min(range.end);
            points.extend(numbers.map(|number| spots.spot(number).point));
            place += 1;
        }
        points
    }

    /// The place of the triangle that a point is on.
    #[inline]
    pub(crate) fn place_of(&self, number: usize) -> usize {
        match &self.numbers {
            Numbers::Each(count) => number / (*count).max(1),
            Numbers::Until(ends) => ends.partition_point(|&end| end as usize <= number),
        }
    }

    /// The points in a range of numbers.
    pub(crate) fn spots<'s>(
        &'s self,
        corners: impl Fn(u32) -> [DVec3; 3] + 's,
        range: Range<usize>,
    ) -> impl Iterator<Item = Spot> + 's {
        (self.place_of(range.start)..self.order.len())
            .map(move |place| self.spots_on(&corners, place))
            .take_while(move |spots| spots.numbers.start < range.end)
            .flat_map(move |spots| {
                let numbers =
                    spots.numbers.start.max(range.start)..spots.numbers.end.min(range.end);
                numbers.map(move |number| spots.spot(number))
            })
    }

    /// The area that each point on the triangle at this place represents, relative to the mean.
    #[inline]
    pub(crate) fn share(&self, place: usize, area: impl FnOnce() -> f64) -> f64 {
        let count = self.on(place..place + 1).len().max(1) as f64;
        if self.shares { area() / (count * self.step) } else { 1.0 }
    }

    /// The triangle at a place.
    pub(crate) fn triangle(&self, place: usize) -> u32 {
        self.order[place]
    }

    /// The triangle at a place, with its points.
    #[inline]
    pub(crate) fn spots_on(&self, corners: impl Fn(u32) -> [DVec3; 3], place: usize) -> Spots {
        self.spots_with(corners, place, |corners| self.share(place, || area(corners)))
    }

    #[inline]
    fn spots_with(
        &self,
        corners: impl Fn(u32) -> [DVec3; 3],
        place: usize,
        share: impl FnOnce(&[DVec3; 3]) -> f64,
    ) -> Spots {
        let numbers = self.on(place..place + 1);
        let triangle = self.order[place];
        let corners = corners(triangle);
        let share = share(&corners);
        Spots { place, triangle, corners, numbers, share, shift: self.shift }
    }
}

impl Spots {
    pub(crate) fn iter(&self) -> impl Iterator<Item = Spot> + '_ {
        self.numbers.clone().map(|number| self.spot(number))
    }

    #[inline]
    fn spot(&self, number: usize) -> Spot {
        let Self { place, triangle, corners: [a, b, c], share, .. } = *self;
        let weights = self.weights(number);
        let point = a + (b - a) * weights.y + (c - a) * weights.z;
        Spot { place, triangle, point, weights, share }
    }

    /// The barycentric weights of a point.
    fn weights(&self, number: usize) -> DVec3 {
        let (index, count) = (number - self.numbers.start, self.numbers.len());
        match count {
            1 => DVec3::splat(1.0 / 3.0),
            3 => turned(THREE, index),
            6 => {
                let [p, q, r] = SIX;
                turned(if index < 3 { [p, q, r] } else { [p, r, q] }, index % 3)
            }
            _ => {
                let root = ((index as f64 + 0.5) / count as f64).sqrt();
                // Steps of the golden ratio spread consecutive points evenly in the other direction.
                let across = (self.shift + number as f64 * GOLDEN).fract();
                DVec3::new(1.0 - root, root * (1.0 - across), root * across)
            }
        }
    }
}

/// Weights, rotated by `by` corners.
fn turned([p, q, r]: [f64; 3], by: usize) -> DVec3 {
    match by {
        0 => DVec3::new(p, q, r),
        1 => DVec3::new(r, p, q),
        _ => DVec3::new(q, r, p),
    }
}

/// The start of the sequence across the triangles.
fn shift(seed: u64) -> f64 {
    SplitMix64::new(!seed).uniform()
}

#[inline]
pub(crate) fn area(&[a, b, c]: &[DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strips; the first one is twice as wide as the others.
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
            let sum: f64 = spread.spots(strip, 0..spread.len()).map(|spot| spot.share).sum();
            let wanted = spread.step * sum;
            // If some triangles have no point, the total is rounded to whole points.
            let rounding = if count < 100 { spread.step } else { 1e-9 };
            assert!((wanted - total).abs() <= rounding, "{count}: {wanted}, not {total}");
            assert!(spread.len().abs_diff(count) <= 100);
        }
    }

    #[test]
    fn each_triangle_has_as_many_points_and_its_share_of_the_area() {
        let order = [3, 0, 2];
        let spread = Spread::on_each(&order, strip, 6, 1);
        let all: Vec<Spot> = spread.spots(strip, 0..spread.len()).collect();
        assert_eq!((all.len(), spread.on(1..2)), (18, 6..12));
        let total: f64 = order.iter().map(|&t| area(&strip(t))).sum();
        for (number, spot) in all.iter().enumerate() {
            assert_eq!((spot.place, spread.place_of(number)), (number / 6, number / 6));
            assert_eq!(spread.point(strip, number), spot.point);
            assert_eq!(spot.weights.min_element(), SIX[2]);
            let share = 18.0 * area(&strip(spot.triangle)) / (6.0 * total);
            assert!((spot.share - share).abs() < 1e-14);
        }
        let part = spread.points(strip, 5..13);
        assert!(part.iter().eq(all[5..13].iter().map(|spot| &spot.point)));
        // Without area there are no points.
        assert_eq!(Spread::on_each(&[0, 1], |_| [DVec3::ONE; 3], 6, 1).len(), 0);
        assert_eq!(Spread::on_each(&order, strip, 0, 1).spots(strip, 0..0).count(), 0);
    }

    #[test]
    fn even_points_stand_for_the_same_area() {
        let order: Vec<u32> = (0..100).collect();
        let spread = Spread::even(&order, strip, 300, 3);
        let counts: Vec<usize> = (0..100).map(|place| spread.on(place..place + 1).len()).collect();
        let areas = order.iter().map(|&t| area(&strip(t)));
        let step = areas.clone().sum::<f64>() / 300.0;
        assert!(counts.iter().zip(areas).all(|(&n, area)| (n as f64 - area / step).abs() <= 1.0));
        assert!(spread.spots(strip, 0..300).all(|spot| spot.share == 1.0));
    }

    #[test]
    fn points_are_on_their_triangles_and_numbered_through() {
        let order = [3, 0, 2];
        let spread = Spread::new(&order, strip, 40, 1);
        let all: Vec<Spot> = spread.spots(strip, 0..spread.len()).collect();
        assert_eq!(all.len(), spread.len());
        let part: Vec<Spot> = spread.spots(strip, 5..17).collect();
        for (spot, same) in all[5..17].iter().zip(&part) {
            assert_eq!((spot.triangle, spot.point), (same.triangle, same.point));
        }
        let places = spread.places().unwrap();
        for (number, spot) in all.iter().enumerate() {
            assert_eq!(spread.place_of(number), places[number] as usize);
            let on = spread.spots_on(strip, places[number] as usize);
            assert!(on.numbers.contains(&number));
            assert_eq!((spot.place, spot.triangle, spot.share), (on.place, on.triangle, on.share));
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
    fn three_points_are_right_for_quadratic_functions_and_six_for_cubic_ones() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        // The integral of x^i y^j over the triangle is i! j! / (i + j + 2)!, and its area is one half.
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        for (count, degree) in [(1, 1), (3, 2), (6, 3)] {
            let spread = Spread::new(&[0], |_| corners, count, 5);
            for (i, j) in (0..=degree).flat_map(|i| (0..=degree - i).map(move |j| (i, j))) {
                let values = spread
                    .spots(|_| corners, 0..count)
                    .map(|spot| spot.share * spot.point.x.powi(i) * spot.point.y.powi(j));
                let mean = values.sum::<f64>() / count as f64;
                let exact = 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2);
                assert!((mean - exact).abs() < 1e-14, "{count}: x^{i} y^{j}: {mean}, not {exact}");
            }
        }
    }

    /// The part of a triangle within half the distance to a corner has a quarter of its area.
    #[test]
    fn many_points_are_as_many_everywhere() {
        let spread = Spread::new(&[0], strip, 400, 5);
        let spots: Vec<Spot> = spread.spots(strip, 0..400).collect();
        for corner in 0..3 {
            let near = spots.iter().filter(|spot| spot.weights[corner] > 0.5).count();
            assert!(near.abs_diff(100) <= 4, "{corner}: {near}");
        }
    }

    /// For any number n of steps of the golden ratio, no gap is larger than 1.9 / n (Swierczkowski 1958).
    #[test]
    fn many_points_leave_no_gap_across() {
        for seed in 0..20 {
            let spread = Spread::new(&[0], strip, 100, seed);
            let spots = spread.spots(strip, 0..100);
            let across = |w: DVec3| w.z / (w.y + w.z);
            let mut places: Vec<f64> = spots.map(|spot| across(spot.weights)).collect();
            places.sort_unstable_by(f64::total_cmp);
            places.push(places[0] + 1.0);
            assert!(places.windows(2).all(|pair| pair[1] - pair[0] < 0.019), "{seed}");
        }
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
