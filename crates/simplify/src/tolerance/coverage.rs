//! What is within a distance of triangles: points, and segments at all their points.
//!
//! The distance from a triangle is a convex function: no point of a segment is farther away than the ends.
//! So a segment is covered whose parts have both their ends close to one of the triangles each.

use glam::DVec3;
use mesh_core::BoundingBox;
use mesh_metric::closest_on_triangle;

use crate::tolerance::prepared_triangle::{Prepared, Triangle};

pub(super) type Segment = [DVec3; 2];

/// The length of the shortest parts, relative to the distance.
const LEAST: f64 = 0.1;
/// The same, relative to the largest coordinate.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A distance, and how finely it is looked at.
#[derive(Clone, Copy)]
pub(super) struct Reach {
    distance: f64,
    squared: f64,
    least: f64,
}

impl Reach {
    /// A distance between surfaces in a box.
    pub(super) fn new(distance: f64, bounds: BoundingBox) -> Self {
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        // Between the ends of a part there has to be a middle that is neither of them.
        let least = (LEAST * distance).max(ROUNDING * largest);
        Self { distance, squared: distance * distance, least }
    }

    pub(super) fn distance(&self) -> f64 {
        self.distance
    }

    /// The length of parts of edges that are not divided any more.
    pub(super) fn least(&self) -> f64 {
        self.least
    }

    fn has(&self, point: DVec3, triangle: &Prepared) -> bool {
        triangle.squared_distance(point, self.squared).is_some()
    }

    /// One of some triangles that a point is close enough to. Two are tried first.
    pub(super) fn find(
        &self,
        point: DVec3,
        triangles: &[Prepared],
        first: [usize; 2],
    ) -> Option<usize> {
        let has = |&i: &usize| triangles.get(i).is_some_and(|t| self.has(point, t));
        first.into_iter().find(has).or_else(|| (0..triangles.len()).find(has))
    }

    /// Whether each part of a segment is close enough to one of some triangles, which `used` hears of; parts
    /// that are not divided any more when their ends are. `last` are those of the ends of the segment before, which
    /// are tried first: it may begin at the same place.
    pub(super) fn cover(
        &self,
        [p, q]: Segment,
        triangles: &[Prepared],
        last: &mut [usize; 2],
        used: &mut impl FnMut(usize),
    ) -> bool {
        let Some(of_p) = self.find(p, triangles, *last) else { return false };
        let Some(of_q) = self.find(q, triangles, [of_p, last[1]]) else { return false };
        *last = [of_p, of_q];
        self.cover_between([(p, of_p), (q, of_q)], triangles, used)
    }

    /// The same for a part of which it is known which triangle each end is close to.
    fn cover_between(
        &self,
        [start, end]: [(DVec3, usize); 2],
        triangles: &[Prepared],
        used: &mut impl FnMut(usize),
    ) -> bool {
        let ((p, of_p), (q, of_q)) = (start, end);
        if of_p == of_q || self.has(q, &triangles[of_p]) {
            used(of_p);
        } else if self.has(p, &triangles[of_q]) {
            used(of_q);
        } else if let Some([[_, middle], _]) = self.halves(&[p, q]) {
            let Some(found) = self.find(middle, triangles, [of_p, of_q]) else { return false };
            let middle = (middle, found);
            return self.cover_between([start, middle], triangles, used)
                && self.cover_between([middle, end], triangles, used);
        } else {
            used(of_p);
            used(of_q);
        }
        true
    }

    pub(super) fn covers(&self, triangle: &Triangle, ends: &Segment) -> bool {
        ends.iter().all(|&p| closest_on_triangle(p, triangle).length_squared() <= self.squared)
    }

    /// The halves of a segment; `None` when it is too short.
    pub(super) fn halves(&self, &[p, q]: &Segment) -> Option<[Segment; 2]> {
        let middle = p + 0.5 * (q - p);
        (p.distance_squared(q) > self.least * self.least).then_some([[p, middle], [middle, q]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A roof of two triangles whose ridge is 1 above the ground, and a segment across on the ground.
    #[test]
    fn a_segment_is_covered_when_all_of_it_is_close_to_one_triangle_or_the_next() {
        let at = DVec3::new;
        let ridge = [at(0.0, -9.0, 1.0), at(0.0, 9.0, 1.0)];
        let roof = [4.0, -4.0].map(|x| [ridge[0], ridge[1], at(x, 0.0, 0.0)]).map(Prepared::new);
        let across = [at(-3.0, 0.0, 0.0), at(3.0, 0.0, 0.0)];
        let bounds = BoundingBox { min: at(-4.0, -9.0, 0.0), max: at(4.0, 9.0, 1.0) };
        let covered = |distance: f64| {
            let mut used = Vec::new();
            let mut last = [0; 2];
            let reach = Reach::new(distance, bounds);
            let covers = reach.cover(across, &roof, &mut last, &mut |i| used.push(i));
            used.sort_unstable();
            used.dedup();
            covers.then_some(used)
        };
        // Below the ridge it is 4 / sqrt(17) away from both.
        let farthest = 4.0 / 17.0_f64.sqrt();
        assert_eq!(covered(1.001 * farthest), Some(vec![0, 1]));
        assert_eq!(covered(0.9 * farthest), None);
        // One is enough where it has both ends.
        assert_eq!(covered(3.2), Some(vec![0]));
    }

    /// The distance is far below what coordinates are rounded to.
    #[test]
    fn segments_are_not_divided_beyond_the_rounding_of_their_ends() {
        let far = DVec3::splat(1e6);
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y].map(|p| far + p);
        let [a, b, c, d] = corners;
        let bounds = BoundingBox { min: a, max: d };
        let halves = [[a, b, c], [b, d, c]].map(Prepared::new);
        let reach = Reach::new(1e-13, bounds);
        let mut parts = 0;
        reach.cover([a, d], &halves, &mut [0; 2], &mut |_| parts += 1);
        assert!(parts < 100, "{parts}");
    }
}
