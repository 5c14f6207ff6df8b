//! Tests whether points and whole segments are within a distance of triangles.
//!
//! The distance from a triangle is a convex function: no point of a segment is farther from it than the ends. So a
//! segment is covered if it can be divided into parts such that both ends of each part are close to one triangle.

use glam::DVec3;
use mesh_core::BoundingBox;
use mesh_metric::closest_on_triangle;

use crate::tolerance::prepared_triangle::{Prepared, Triangle};

pub(super) type Segment = [DVec3; 2];

/// The shortest length of a part, relative to the distance.
const LEAST: f64 = 0.1;
/// The shortest length of a part, relative to the largest coordinate.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A distance, and the length at which the division of segments ends.
#[derive(Clone, Copy)]
pub(super) struct Tolerance {
    distance: f64,
    squared: f64,
    least: f64,
}

impl Tolerance {
    /// The tolerance for a distance between surfaces in this box.
    pub(super) fn new(distance: f64, bounds: BoundingBox) -> Self {
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        // The middle of a part must differ from both ends.
        let least = (LEAST * distance).max(ROUNDING * largest);
        Self { distance, squared: distance * distance, least }
    }

    pub(super) fn distance(&self) -> f64 {
        self.distance
    }

    /// Parts of at most this length are not divided.
    pub(super) fn least(&self) -> f64 {
        self.least
    }

    fn has(&self, point: DVec3, triangle: &Prepared) -> bool {
        triangle.squared_distance(point, self.squared).is_some()
    }

    /// A triangle that is close enough to the point. The two named in `first` are tried first.
    pub(super) fn find(
        &self,
        point: DVec3,
        triangles: &[Prepared],
        first: [usize; 2],
    ) -> Option<usize> {
        let has = |&i: &usize| triangles.get(i).is_some_and(|t| self.has(point, t));
        first.into_iter().find(has).or_else(|| (0..triangles.len()).find(has))
    }

    /// Whether each part of a segment is close enough to one of the triangles; `used` receives these triangles. For a
    /// part that is too short to divide, it is enough that each end is close to some triangle. `last` are the triangles
    /// found for the ends of the previous segment. They are tried first, since segments often share an end.
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

    /// Does the work of [`Tolerance::cover`] for a part, given a triangle that is close to each end.
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
            let tolerance = Tolerance::new(distance, bounds);
            let covers = tolerance.cover(across, &roof, &mut last, &mut |i| used.push(i));
            used.sort_unstable();
            used.dedup();
            covers.then_some(used)
        };
        // Below the ridge, the distance to both triangles is 4 / sqrt(17).
        let farthest = 4.0 / 17.0_f64.sqrt();
        assert_eq!(covered(1.001 * farthest), Some(vec![0, 1]));
        assert_eq!(covered(0.9 * farthest), None);
        // One triangle is enough if both ends are close to it.
        assert_eq!(covered(3.2), Some(vec![0]));
    }

    /// The distance is far below the rounding of the coordinates.
    #[test]
    fn segments_are_not_divided_beyond_the_rounding_of_their_ends() {
        let far = DVec3::splat(1e6);
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y].map(|p| far + p);
        let [a, b, c, d] = corners;
        let bounds = BoundingBox { min: a, max: d };
        let halves = [[a, b, c], [b, d, c]].map(Prepared::new);
        let tolerance = Tolerance::new(1e-13, bounds);
        let mut parts = 0;
        tolerance.cover([a, d], &halves, &mut [0; 2], &mut |_| parts += 1);
        assert!(parts < 100, "{parts}");
    }
}
