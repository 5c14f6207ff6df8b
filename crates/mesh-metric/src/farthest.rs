//! The largest distance of many points from all triangles.
//!
//! Of a point, or of eight of them, that are closer than another one is known to be, it does not
//! matter how close they are: the search ends with the first triangle that tells.

use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use glam::DVec3;
use mesh_core::simd::{LANES, Vec3x8};

use crate::bvh::{Bvh, TraversalStack};
use crate::packet_traversal::{Packet, along_a_curve};
use crate::simd_distance::squared_gaps;

impl Bvh {
    /// The largest of `known` and the squared distances of points from all triangles. Points that are
    /// not finite have none.
    pub(crate) fn farthest(&self, points: &[DVec3], known: f64) -> f64 {
        self.farthest_until(f64::INFINITY, points, known)
    }

    /// Whether all squared distances of points, which are finite, are at most `most`.
    pub(crate) fn are_within(&self, points: &[DVec3], most: f64) -> bool {
        self.farthest_until(most, points, most) <= most
    }

    /// [`Bvh::farthest`], or anything beyond `enough` when that is less.
    fn farthest_until(&self, enough: f64, points: &[DVec3], known: f64) -> f64 {
        let order = along_a_curve(points);
        let mut largest = known;
        dispatch!(self.simd(), simd => {
            let (mut guess, mut stack) = (0, TraversalStack::new(self.root_height()));
            for eight in order.chunks(LANES) {
                if largest > enough {
                    break;
                }
                if self.is_one_packet(points, eight, guess) {
                    guess = self.farthest_of_eight(simd, points, eight, guess, &mut stack, &mut largest);
                } else {
                    for &index in eight {
                        guess = self.farthest_of_one(simd, points[index as usize], guess, &mut stack, &mut largest);
                    }
                }
            }
        });
        largest
    }

    /// Goes on to the distances of up to eight points. Returns the slot of a triangle near one of them.
    #[inline(always)]
    fn farthest_of_eight<S: Simd>(
        &self,
        simd: S,
        points: &[DVec3],
        eight: &[u32],
        guess: u32,
        stack: &mut TraversalStack,
        largest: &mut f64,
    ) -> u32 {
        let mut packet = Packet::new(simd, points, eight);
        packet.measure(self.triangle(guess), guess);
        self.search_packet(&mut packet, stack, *largest);
        *largest = largest.max(packet.farthest());
        packet.slot(eight.len() - 1)
    }

    /// The same for one point.
    #[inline(always)]
    fn farthest_of_one<S: Simd>(
        &self,
        simd: S,
        point: DVec3,
        guess: u32,
        stack: &mut TraversalStack,
        largest: &mut f64,
    ) -> u32 {
        let point = Vec3x8::splat(simd, point);
        let mut best = self.nearest_in_leaf(simd, point, guess / LANES as u32);
        stack.restart(self.root_height());
        while let Some(task) = stack.pop().filter(|_| best.squared > *largest) {
            if task.squared >= best.squared {
                continue;
            }
            if task.height > 0 {
                let squares = squared_gaps([point, point], self.node(simd, task));
                stack.push_children(task, squares, best.squared);
            } else {
                let candidate = self.nearest_in_leaf(simd, point, task.index);
                if candidate.squared < best.squared {
                    best = candidate;
                }
            }
        }
        *largest = largest.max(best.squared);
        best.slot
    }
}
