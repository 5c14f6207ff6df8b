//! The largest distance from many points to all triangles.
//!
//! The exact distance of a point matters only if it exceeds the largest distance so far. The search for a
//! point, or for eight points, ends with the first triangle that is closer than that.

use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use glam::DVec3;
use mesh_core::as_u32;
use mesh_core::simd::{LANES, Vec3x8};

use crate::bvh::{Bvh, TraversalStack};
use crate::packet_traversal::{Packet, along_a_curve};
use crate::simd_distance::squared_gaps;

impl Bvh {
    /// The maximum of `known` and the squared distances of points. Non-finite points are ignored.
    pub(crate) fn farthest(&self, points: &[DVec3], known: f64) -> f64 {
        self.farthest_until(f64::INFINITY, points, known)
    }

    /// Whether all squared distances of finite points are at most `most`.
    pub(crate) fn are_within(&self, points: &[DVec3], most: f64) -> bool {
        self.farthest_until(most, points, most) <= most
    }

    /// [`Bvh::farthest`], or any value above `enough` if the result is above it.
    fn farthest_until(&self, enough: f64, points: &[DVec3], known: f64) -> f64 {
        let order = along_a_curve(points);
        let mut largest = known;
        dispatch!(self.simd(), simd => {
            let (mut hint, mut stack) = (0, TraversalStack::new(self.root_height()));
            for eight in order.chunks(LANES) {
                if largest > enough {
                    break;
                }
                if self.is_one_packet(points, eight, hint) {
                    hint = self.farthest_of_eight(simd, points, eight, hint, &mut stack, &mut largest);
                } else {
                    for &index in eight {
                        hint = self.farthest_of_one(simd, points[index as usize], hint, &mut stack, &mut largest);
                    }
                }
            }
        });
        largest
    }

    /// Includes the distances of up to eight points. Returns the slot of a triangle near one of them.
    #[inline(always)]
    fn farthest_of_eight<S: Simd>(
        &self,
        simd: S,
        points: &[DVec3],
        eight: &[u32],
        hint: u32,
        stack: &mut TraversalStack,
        largest: &mut f64,
    ) -> u32 {
        let mut packet = Packet::new(simd, points, eight);
        packet.measure(self.triangle(hint), hint);
        self.search_packet(&mut packet, stack, *largest);
        *largest = largest.max(packet.farthest());
        packet.slot(eight.len() - 1)
    }

    /// As [`Bvh::farthest_of_eight`], for one point.
    #[inline(always)]
    fn farthest_of_one<S: Simd>(
        &self,
        simd: S,
        point: DVec3,
        hint: u32,
        stack: &mut TraversalStack,
        largest: &mut f64,
    ) -> u32 {
        let point = Vec3x8::splat(simd, point);
        let mut best = self.nearest_in_leaf(simd, point, hint / as_u32(LANES));
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
