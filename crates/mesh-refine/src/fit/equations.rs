//! Assembly of the normal equations of a mesh, or of a part of it.

use core::hint::select_unpredictable;

use glam::DVec3;
use mesh_core::{FaceId, TriMesh, parallel};
use mesh_metric::{Surface, foot_inside, weights_of_closest};

use crate::block_loop::for_blocks_in_turn;
use crate::fit::element::{Element, Pair, Tally, Weighting, share_of_one};
use crate::fit::spread::{Spot, Spread};
use crate::fit::system::System;
use crate::fit::targets::{FitTarget, normal_and_area};

/// Input of the equations of some faces, without the targets.
pub(super) struct Equations<'a> {
    pub(super) mesh: &'a TriMesh,
    pub(super) original: &'a Surface,
    /// All faces of the mesh.
    pub(super) faces: &'a [FaceId],
    /// The indices of the faces to include, ordered so that consecutive faces are close in space.
    pub(super) order: &'a [u32],
    /// The number of samples on each of these faces.
    pub(super) samples: usize,
    pub(super) seed: u64,
    /// The factor on the squared distances at each triangle of the original.
    pub(super) importance: Option<&'a [f64]>,
}

/// The number of faces in a block for one thread.
const BLOCK: usize = 64;

/// No triangle.
const NOWHERE: u32 = u32::MAX;

impl Equations<'_> {
    /// Adds the pairs of every face: the targets assigned to it, and its own samples with the closest points of the
    /// original.
    pub(super) fn add_to(
        &self,
        system: &mut System,
        weighting: Weighting,
        targets_of: impl Fn(FaceId, &mut dyn FnMut(&FitTarget)) + Sync,
    ) -> Tally {
        let corners = |index: u32| self.mesh.triangle(self.faces[index as usize]);
        let spread = Spread::on_each(self.order, corners, self.samples, self.seed);
        let own_weighting = match weighting.tail > 0.0 {
            true => {
                Weighting { largest: self.farthest(&spread).max(weighting.largest), ..weighting }
            }
            false => weighting,
        };
        let density = share_of_one(self.samples);
        let mut tally = Tally::default();
        for_blocks_in_turn(
            self.order.len(),
            BLOCK,
            |places| {
                let start = places.start;
                let mut elements = vec![Element::default(); places.len()];
                let (mut near, mut asked) = (Vec::new(), Vec::new());
                for (place, element) in places.zip(&mut elements) {
                    let face = self.faces[self.order[place] as usize];
                    let corners = self.mesh.triangle(face);
                    near.clear();
                    targets_of(face, &mut |target| {
                        element.add(&draw(&corners, target), &weighting);
                        near.extend(target.triangle.map(|triangle| (target.point, triangle)));
                    });
                    for spot in spread.spots_on(|_| corners, place).iter() {
                        match self.foot_near(&spot, density, &near) {
                            Some(pair) => element.add(&pair, &own_weighting),
                            None => asked.push(spot),
                        }
                    }
                }
                let points: Vec<DVec3> = asked.iter().map(|spot| spot.point).collect();
                let closest = self.original.closest_to_neighbours(&points);
                for (spot, closest) in asked.iter().zip(closest) {
                    let on = self.original.triangle(closest.triangle as usize);
                    let pair = Pair {
                        weights: spot.weights,
                        gap: -closest.offset,
                        normal: normal_and_area(on).0,
                        share: density * spot.share * self.importance_at(closest.triangle),
                    };
                    elements[spot.place - start].add(&pair, &own_weighting);
                }
                (start, elements)
            },
            |(start, elements)| {
                for (&index, element) in self.order[start..].iter().zip(&elements) {
                    system.add(self.mesh, self.faces[index as usize], element);
                    tally.join(element.tally);
                }
            },
        );
        tally
    }

    /// A sample with its foot on the triangle of one of the two nearest of these points of the original, if the foot
    /// lies inside the triangle and the surface is near. This is usually the closest point, and it needs no search.
    #[inline]
    fn foot_near(&self, spot: &Spot, density: f64, near: &[(DVec3, u32)]) -> Option<Pair> {
        let [first, second] = nearest_two(spot.point, near);
        let on = |triangle: u32| {
            let corners =
                (triangle != NOWHERE).then(|| self.original.triangle(triangle as usize))?;
            Some((triangle, foot_inside(spot.point, &corners).ok()?))
        };
        let (triangle, foot) = on(first).or_else(|| on(second))?;
        let share = density * spot.share * self.importance_at(triangle);
        let weights = spot.weights;
        Some(Pair { weights, gap: -foot.offset, normal: foot.normal, share })
    }

    #[inline]
    fn importance_at(&self, triangle: u32) -> f64 {
        self.importance.map_or(1.0, |all| all[triangle as usize])
    }

    /// The largest squared distance of a sample from the original.
    fn farthest(&self, spread: &Spread<'_>) -> f64 {
        const POINTS: usize = 1024;
        let corners = |index: u32| self.mesh.triangle(self.faces[index as usize]);
        let count = spread.len();
        let of_blocks = parallel::collect_with(
            count.div_ceil(POINTS),
            || (),
            |(), block| {
                let range = block * POINTS..count.min((block + 1) * POINTS);
                let points = spread.points(corners, range);
                let closest = self.original.closest_to_neighbours(&points);
                closest.iter().map(|closest| closest.offset.length_squared()).fold(0.0, f64::max)
            },
        );
        of_blocks.into_iter().fold(0.0, f64::max)
    }
}

/// The triangles of the two points nearest to a point, the nearest first; [`NOWHERE`] if there are too few points.
///
/// The loop has no branches, because a processor could not predict the comparisons. Distances are compared by their
/// bits as integers, which is correct for numbers that are not negative.
#[inline]
fn nearest_two(to: DVec3, points: &[(DVec3, u32)]) -> [u32; 2] {
    let infinity = f64::INFINITY.to_bits();
    let ([mut first, mut second], mut on) = ([infinity; 2], [NOWHERE; 2]);
    for &(point, triangle) in points {
        let squared = (point - to).length_squared().to_bits();
        let (is_first, is_second) = (squared < first, squared < second);
        second = select_unpredictable(is_second, squared, second);
        on[1] = select_unpredictable(is_second, triangle, on[1]);
        second = select_unpredictable(is_first, first, second);
        on[1] = select_unpredictable(is_first, on[0], on[1]);
        first = select_unpredictable(is_first, squared, first);
        on[0] = select_unpredictable(is_first, triangle, on[0]);
    }
    on
}

/// A target and the point of the face that is closest to it.
#[inline]
fn draw(corners: &[DVec3; 3], target: &FitTarget) -> Pair {
    let weights = weights_of_closest(target.point, corners);
    let from = |corner: DVec3| corner - target.point;
    let [a, b, c] = *corners;
    let gap = from(a) * weights.x + from(b) * weights.y + from(c) * weights.z;
    Pair { weights, gap, normal: target.normal, share: target.share }
}

#[cfg(test)]
mod tests {
    use super::{NOWHERE, nearest_two};
    use glam::DVec3;

    #[test]
    fn the_two_nearest_of_some_points_are_those_of_a_sorted_list() {
        let at = |i: u32| DVec3::new(f64::from(i * 37 % 11), f64::from(i * 53 % 13), 0.5);
        let points: Vec<(DVec3, u32)> = (0..40).map(|i| (at(i), i)).collect();
        let to = DVec3::new(3.2, 4.9, -1.0);
        for count in 2..points.len() {
            let mut sorted = points[..count].to_vec();
            sorted.sort_by(|(p, _), (q, _)| p.distance(to).total_cmp(&q.distance(to)));
            assert_eq!(nearest_two(to, &points[..count]), [sorted[0].1, sorted[1].1]);
        }
        assert_eq!(nearest_two(to, &points[..1]), [0, NOWHERE]);
        // A query that is NaN has no nearest point.
        assert_eq!(nearest_two(DVec3::NAN, &points), [NOWHERE; 2]);
    }
}
