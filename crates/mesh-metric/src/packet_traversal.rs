//! Packet traversal: closest points of eight queries in one walk through the tree.
//!
//! Queries that are close together, compared with the size of the triangles, visit nearly the same nodes. One
//! walk serves all: a node is entered if the box of all queries is near enough, and a triangle is measured from
//! all eight side by side.

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f64x8};
use glam::DVec3;
use mesh_core::as_u32;
use mesh_core::simd::{LANES, Vec3x8};

use crate::bvh::{Bvh, Nearest, StackEntry, TraversalStack};
use crate::early_split::bounds_of;
use crate::simd_distance::{closest_on_triangles, squared_gaps};

impl Bvh {
    /// The closest points of many points; faster if the points are close together. NaN for non-finite points.
    pub(crate) fn nearest_to_each(&self, points: &[DVec3]) -> Vec<Nearest> {
        self.nearest_in_order(points, &along_a_curve(points))
    }

    /// As [`Bvh::nearest_to_each`], for points in spatial order.
    pub(crate) fn nearest_to_neighbours(&self, points: &[DVec3]) -> Vec<Nearest> {
        let finite = (0..as_u32(points.len())).filter(|&index| points[index as usize].is_finite());
        self.nearest_in_order(points, &finite.collect::<Vec<_>>())
    }

    fn nearest_in_order(&self, points: &[DVec3], order: &[u32]) -> Vec<Nearest> {
        let nowhere = Nearest { offset: DVec3::NAN, squared: f64::NAN, slot: 0 };
        let mut nearest = vec![nowhere; points.len()];
        dispatch!(self.simd(), simd => {
            let (mut hint, mut stack) = (0, TraversalStack::new(self.root_height()));
            for eight in order.chunks(LANES) {
                hint = self.nearest_to_eight(simd, points, eight, hint, (&mut stack, &mut nearest));
            }
        });
        nearest
    }

    /// The closest points to up to eight of the points. Returns the slot of one of them.
    #[inline(always)]
    fn nearest_to_eight<S: Simd>(
        &self,
        simd: S,
        points: &[DVec3],
        eight: &[u32],
        hint: u32,
        (stack, nearest): (&mut TraversalStack, &mut [Nearest]),
    ) -> u32 {
        if !self.is_one_packet(points, eight, hint) {
            let mut hint = hint;
            for &index in eight {
                let found = self.nearest_with(simd, points[index as usize], hint);
                hint = found.slot;
                nearest[index as usize] = found;
            }
            return hint;
        }
        let mut packet = Packet::new(simd, points, eight);
        packet.measure(self.triangle(hint), hint);
        self.search_packet(&mut packet, stack, 0.0);
        for (lane, &index) in eight.iter().enumerate() {
            nearest[index as usize] = Nearest {
                offset: packet.offsets.at(lane),
                squared: packet.squares[lane],
                slot: packet.slot(lane),
            };
        }
        packet.slot(eight.len() - 1)
    }

    /// Whether up to eight points are so close together, compared with a triangle near them, that a packet
    /// pays.
    #[inline(always)]
    pub(crate) fn is_one_packet(&self, points: &[DVec3], eight: &[u32], hint: u32) -> bool {
        let [min, max] = bounds_of(eight.iter().map(|&index| points[index as usize]));
        let [low, high] = self.bounds(hint);
        let is_wide = (max - min).length_squared() > 4.0 * (high - low).length_squared();
        !is_wide && !self.has_sections()
    }

    /// Finds the closest points of a packet; ends early if all squared distances are at most `enough`.
    #[inline(always)]
    pub(crate) fn search_packet<S: Simd>(
        &self,
        packet: &mut Packet<S>,
        stack: &mut TraversalStack,
        enough: f64,
    ) {
        stack.restart(self.root_height());
        while let Some(task) = stack.pop().filter(|_| packet.farthest > enough) {
            if task.squared >= packet.farthest {
                continue;
            }
            if task.height > 0 {
                let squares = squared_gaps(packet.bounds, self.node(packet.squares.simd, task));
                stack.push_children(task, squares, packet.farthest);
            } else {
                packet.measure_leaf(self, task);
            }
        }
    }
}

/// Eight queries and the best results so far.
pub(crate) struct Packet<S: Simd> {
    points: Vec3x8<S>,
    /// Their bounding box, eight times.
    bounds: [Vec3x8<S>; 2],
    offsets: Vec3x8<S>,
    squares: f64x8<S>,
    /// Slots as numbers, exactly.
    slots: f64x8<S>,
    /// The largest of the squares.
    farthest: f64,
}

impl<S: Simd> Packet<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, points: &[DVec3], eight: &[u32]) -> Self {
        let [min, max] = bounds_of(eight.iter().map(|&index| points[index as usize]));
        let mut columns = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            // The last one is repeated where there are fewer.
            let point = points[eight[lane.min(eight.len() - 1)] as usize];
            columns[0][lane] = point.x;
            columns[1][lane] = point.y;
            columns[2][lane] = point.z;
        }
        Self {
            points: Vec3x8::load(simd, &columns),
            bounds: [Vec3x8::splat(simd, min), Vec3x8::splat(simd, max)],
            offsets: Vec3x8::splat(simd, DVec3::INFINITY),
            squares: f64x8::splat(simd, f64::INFINITY),
            slots: f64x8::splat(simd, 0.0),
            farthest: f64::INFINITY,
        }
    }

    /// The largest of the squared distances so far.
    #[inline(always)]
    pub(crate) fn farthest(&self) -> f64 {
        self.farthest
    }

    /// The slot of the triangle that is closest to one of the points.
    #[inline(always)]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the lanes hold numbers of slots"
    )]
    pub(crate) fn slot(&self, lane: usize) -> u32 {
        self.slots[lane] as u32
    }

    #[inline(always)]
    pub(crate) fn measure(&mut self, triangle: [DVec3; 3], slot: u32) {
        let simd = self.squares.simd;
        let [a, b, c] = triangle;
        let triangle = [Vec3x8::splat(simd, a), Vec3x8::splat(simd, b), Vec3x8::splat(simd, c)];
        let (offsets, squares) = closest_on_triangles(self.points, triangle);
        let nearer = squares.simd_lt(self.squares);
        self.offsets = Vec3x8::select(nearer, offsets, self.offsets);
        self.squares = nearer.select(squares, self.squares);
        self.slots = nearer.select(f64x8::splat(simd, f64::from(slot)), self.slots);
        self.farthest = self.squares.reduce_max();
    }

    #[inline(always)]
    fn measure_leaf(&mut self, bvh: &Bvh, task: StackEntry) {
        let [a, b, c] = bvh.leaf(self.squares.simd, task.index);
        let bounds = [a.min(b).min(c), a.max(b).max(c)];
        let squares = squared_gaps(self.bounds, bounds);
        let mut nearer = squares.simd_lt(self.farthest).to_bitmask();
        while nearer != 0 {
            let lane = nearer.trailing_zeros();
            nearer &= nearer - 1;
            let slot = task.index * as_u32(LANES) + lane;
            self.measure(bvh.triangle(slot), slot);
        }
    }
}

/// The indices of the finite points along a Morton curve with 1024 steps per axis.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "0 to 1024; the lower half of a key is an index"
)]
pub(crate) fn along_a_curve(points: &[DVec3]) -> Vec<u32> {
    let finite = || points.iter().enumerate().filter(|(_, p)| p.is_finite());
    let [min, max] = bounds_of(finite().map(|(_, p)| *p));
    let scale = STEPS / (max - min).max_element().max(f64::MIN_POSITIVE);
    let key = |(index, point): (usize, &DVec3)| {
        let [x, y, z] = ((*point - min) * scale).to_array().map(|c| spread(c as u32));
        u64::from(x | y << 1 | z << 2) << 32 | index as u64
    };
    let mut keys: Vec<u64> = finite().map(key).collect();
    keys.sort_unstable();
    keys.into_iter().map(|key| key as u32).collect()
}

/// The largest number that [`spread`] takes.
const STEPS: f64 = 1023.0;

/// Two zero bits before each of the ten bits of a number.
fn spread(number: u32) -> u32 {
    let mut bits = number & 1023;
    bits = (bits | bits << 16) & 0x0300_00FF;
    bits = (bits | bits << 8) & 0x0300_F00F;
    bits = (bits | bits << 4) & 0x030C_30C3;
    (bits | bits << 2) & 0x0924_9249
}
