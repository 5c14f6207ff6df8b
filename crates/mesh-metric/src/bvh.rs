//! A bounding volume hierarchy over triangles with eight children per node.
//!
//! The triangles are ordered by median splits of their centres along the longest extent, at multiples of 8, 64,
//! 512 and so on. Children follow from the index alone, so there are no pointers. The eight boxes of a node,
//! and the eight triangles of a leaf, are measured side by side with the widest vector instructions of the
//! processor.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f64x8};
use glam::DVec3;
use mesh_core::as_u32;
use mesh_core::closest_point::closest_on_triangle;
use mesh_core::parallel;
use mesh_core::simd::{LANES, Vec3x8};

use crate::bvh_storage::BvhStorage;
use crate::distance_bounds::lower_bound;
use crate::early_split::{Section, bounds_of, split_long_triangles};
use crate::simd_distance::{closest_on_triangles, squared_gaps};
use crate::slab::{Slabs, slab_of};

/// Parts with fewer triangles are ordered by one thread.
const SEQUENTIAL: usize = 4096;

/// More entries than the stack can hold in a tree over 2^32 triangles.
const MAX_ENTRIES: usize = 96;

/// The tree and its triangles.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    simd: Level,
    boxes: BvhStorage,
    /// The index that each triangle had when the tree was built.
    original: Vec<u32>,
    /// Per slot, the section of the triangle that is in the box; empty if all triangles are whole.
    pieces: Vec<Section>,
    /// Slabs around the triangles of eight leaves each; empty if all triangles are whole.
    slabs: Vec<Slabs>,
    /// Every triangle once, in the order of the leaves; empty if all triangles are whole.
    in_space: Vec<u32>,
}

/// The result of a closest-point query.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    /// The vector from the query to the closest point.
    pub(crate) offset: DVec3,
    pub(crate) squared: f64,
    /// Slot of the triangle in the tree; a good hint for the next query nearby.
    pub(crate) slot: u32,
}

impl Bvh {
    /// A tree over at least one triangle.
    pub(crate) fn new(corners: impl Fn(usize) -> [DVec3; 3] + Sync, count: usize) -> Self {
        let whole = |t: usize| bounds_of(corners(t).into_iter());
        let (mut pieces_in_order, mut in_space) = (Vec::new(), Vec::new());
        let original = if let Some((triangles, pieces)) = split_long_triangles(&corners, count) {
            let slots =
                in_leaves(pieces.len(), |i| pieces[i].bounds(&corners(triangles[i] as usize)));
            let original: Vec<u32> =
                parallel::collect(slots.len(), |slot| triangles[slots[slot] as usize]);
            pieces_in_order = parallel::collect(slots.len(), |slot| pieces[slots[slot] as usize]);
            let mut is_there = vec![false; count];
            let first = |&t: &u32| !core::mem::replace(&mut is_there[t as usize], true);
            in_space = original.iter().copied().filter(first).collect();
            original
        } else {
            in_leaves(count, whole)
        };
        let (boxes, slabs) = enclose(&original, &pieces_in_order, corners);
        Self { simd: Level::new(), boxes, original, pieces: pieces_in_order, slabs, in_space }
    }

    /// Refits the boxes to moved triangles; the order stays.
    pub(crate) fn follow(&mut self, corners: impl Fn(usize) -> [DVec3; 3] + Sync) {
        (self.boxes, self.slabs) = enclose(&self.original, &self.pieces, corners);
    }

    /// Every triangle once, in the order of the leaves.
    pub(crate) fn in_space(&self) -> &[u32] {
        if self.pieces.is_empty() { &self.original } else { &self.in_space }
    }

    pub(crate) fn original(&self, slot: u32) -> u32 {
        self.original[slot as usize]
    }

    #[inline]
    pub(crate) fn triangle(&self, slot: u32) -> [DVec3; 3] {
        self.boxes.triangle(slot)
    }

    /// The bounds of the triangle, or of the section of it, in a slot.
    pub(crate) fn bounds(&self, slot: u32) -> [DVec3; 2] {
        let triangle = self.triangle(slot);
        match self.pieces.get(slot as usize) {
            Some(piece) => piece.bounds(&triangle),
            None => bounds_of(triangle.into_iter()),
        }
    }

    /// The closest point of all triangles. `hint` is the slot of any triangle, if possible a near one.
    pub(crate) fn nearest(&self, point: DVec3, hint: u32) -> Nearest {
        dispatch!(self.simd, simd => self.nearest_with(simd, point, hint))
    }

    #[inline(always)]
    pub(crate) fn nearest_with<S: Simd>(&self, simd: S, point: DVec3, hint: u32) -> Nearest {
        let point = Vec3x8::splat(simd, point);
        let first = hint / as_u32(LANES);
        let mut best = self.nearest_in_leaf(simd, point, first);
        let mut stack = TraversalStack::new(self.root_height());
        // The distance of a non-finite point is NaN.
        while let Some(task) = stack.pop().filter(|_| !best.squared.is_nan()) {
            if task.squared >= best.squared {
                continue;
            }
            if task.height > 0 {
                let squares = self.squared_gaps(simd, point, task);
                stack.push_children(task, squares, best.squared);
            } else if task.index != first {
                let candidate = self.nearest_in_leaf(simd, point, task.index);
                if candidate.squared < best.squared {
                    best = candidate;
                }
            }
        }
        best
    }

    /// For each point, the closest point of all triangles, if it is closer than the distance given for it. Fast if most
    /// points are farther away, and if each eight consecutive points are close together.
    pub(crate) fn nearer_than_each(&self, points: &[DVec3], than: &[f64]) -> Vec<Option<Nearest>> {
        let count = points.len().min(than.len());
        let mut found = vec![None; count];
        // Loops, because closures are compiled for the baseline instruction set.
        dispatch!(self.simd, simd => {
            let mut stack = TraversalStack::new(self.root_height());
            for start in (0..count).step_by(LANES) {
                let eight = start..count.min(start + LANES);
                let box_of_eight = bounds_of(points[eight.clone()].iter().copied());
                let farthest = than[eight.clone()].iter().copied().fold(0.0, f64::max);
                if self.has_leaf_within(simd, box_of_eight, farthest, &mut stack) {
                    for i in eight {
                        found[i] = self.nearer_than(simd, points[i], than[i], &mut stack);
                    }
                }
            }
        });
        found
    }

    /// Whether the box of a leaf is closer to a box than a distance.
    #[inline(always)]
    fn has_leaf_within<S: Simd>(
        &self,
        simd: S,
        [min, max]: [DVec3; 2],
        distance: f64,
        stack: &mut TraversalStack,
    ) -> bool {
        let bounds = [Vec3x8::splat(simd, min), Vec3x8::splat(simd, max)];
        let enough = distance * distance;
        stack.restart(self.root_height());
        while let Some(task) = stack.pop() {
            if task.height == 0 {
                return true;
            }
            let squares = squared_gaps(bounds, self.node(simd, task));
            stack.push_children(task, squares, enough);
        }
        false
    }

    #[inline(always)]
    fn nearer_than<S: Simd>(
        &self,
        simd: S,
        point: DVec3,
        than: f64,
        stack: &mut TraversalStack,
    ) -> Option<Nearest> {
        let point = Vec3x8::splat(simd, point);
        let mut best = None;
        let mut enough = than * than;
        stack.restart(self.root_height());
        while let Some(task) = stack.pop() {
            if task.squared >= enough {
                continue;
            }
            if task.height > 0 {
                let squares = self.squared_gaps(simd, point, task);
                stack.push_children(task, squares, enough);
            } else {
                let candidate = self.nearest_in_leaf(simd, point, task.index);
                if candidate.squared < enough {
                    enough = candidate.squared;
                    best = Some(candidate);
                }
            }
        }
        best
    }

    /// A lower bound of the distance from a point to all triangles, up to
    /// [`Rounding`](crate::distance_bounds::Rounding), but at most `distance`.
    pub(crate) fn lower_bound(&self, point: DVec3, distance: f64) -> f64 {
        dispatch!(self.simd, simd => self.lower_bound_with(simd, point, distance))
    }

    #[inline(always)]
    fn lower_bound_with<S: Simd>(&self, simd: S, point: DVec3, distance: f64) -> f64 {
        let wide = Vec3x8::splat(simd, point);
        let mut nearest = distance;
        let mut stack = TraversalStack::new(self.root_height());
        while let Some(task) = stack.pop() {
            let enough = nearest * nearest;
            if task.squared >= enough {
                continue;
            }
            if task.height > 0 {
                let squares = self.squared_gaps(simd, wide, task);
                stack.push_children(task, squares, enough);
            } else {
                for lane in 0..as_u32(LANES) {
                    let triangle = self.triangle(task.index * as_u32(LANES) + lane);
                    nearest = nearest.min(lower_bound(point, &triangle));
                }
            }
        }
        nearest
    }

    /// Whether a triangle is no farther from a point than a distance, and is accepted. Triangles are named by their slots.
    pub(crate) fn has_within(
        &self,
        point: DVec3,
        distance: f64,
        mut accepts: impl FnMut(u32) -> bool,
    ) -> bool {
        let enough = distance * distance;
        let is_near =
            |slot| closest_on_triangle(point, &self.triangle(slot)).length_squared() <= enough;
        let mut stack = TraversalStack::new(self.root_height());
        while let Some(task) = stack.pop() {
            if task.height > 0 {
                dispatch!(self.simd, simd => {
                    let squares = self.squared_gaps(simd, Vec3x8::splat(simd, point), task);
                    stack.push_children(task, squares, enough);
                });
            } else {
                // The last leaf is filled up.
                let end = ((task.index + 1) * as_u32(LANES)).min(as_u32(self.original.len()));
                if (task.index * as_u32(LANES)..end).any(|slot| is_near(slot) && accepts(slot)) {
                    return true;
                }
            }
        }
        false
    }

    /// Lower bounds of the squared distances from a point to the children of a node. Slabs are tighter than the
    /// boxes of leaves with long thin triangles.
    #[inline(always)]
    fn squared_gaps<S: Simd>(&self, simd: S, point: Vec3x8<S>, node: StackEntry) -> f64x8<S> {
        let squares = squared_gaps([point, point], self.node(simd, node));
        match self.slabs.get(node.index as usize) {
            Some(slabs) if node.height == 1 => squares.max(slabs.squared_gaps(simd, point)),
            _ => squares,
        }
    }

    /// Whether some triangles are split into sections; then single queries are faster than packets.
    #[inline(always)]
    pub(crate) fn has_sections(&self) -> bool {
        !self.pieces.is_empty()
    }

    #[inline(always)]
    pub(crate) fn nearest_in_leaf<S: Simd>(&self, simd: S, point: Vec3x8<S>, leaf: u32) -> Nearest {
        let triangles = self.boxes.leaf(simd, leaf);
        let (offsets, squares) = closest_on_triangles(point, triangles);
        let squared = squares.reduce_min();
        let lane = squares.simd_eq(squared).to_bitmask().trailing_zeros() % as_u32(LANES);
        Nearest { offset: offsets.at(lane as usize), squared, slot: leaf * as_u32(LANES) + lane }
    }

    #[inline(always)]
    pub(crate) fn simd(&self) -> Level {
        self.simd
    }

    #[inline(always)]
    pub(crate) fn root_height(&self) -> usize {
        self.boxes.root_height()
    }

    #[inline(always)]
    pub(crate) fn leaf<S: Simd>(&self, simd: S, index: u32) -> [Vec3x8<S>; 3] {
        self.boxes.leaf(simd, index)
    }

    /// The boxes of the children of a node.
    #[inline(always)]
    pub(crate) fn node<S: Simd>(&self, simd: S, task: StackEntry) -> [Vec3x8<S>; 2] {
        self.boxes.node(simd, task.height, task.index)
    }
}

/// The stack of a traversal: subtrees that are still to be searched.
pub(crate) struct TraversalStack {
    stack: [StackEntry; MAX_ENTRIES],
    count: usize,
}

impl TraversalStack {
    #[inline(always)]
    pub(crate) fn new(height: usize) -> Self {
        let mut stack = [StackEntry::default(); MAX_ENTRIES];
        stack[0].height = as_u32(height);
        Self { stack, count: 1 }
    }

    /// Clears the stack and pushes the root.
    #[inline(always)]
    pub(crate) fn restart(&mut self, height: usize) {
        self.stack[0] = StackEntry { height: as_u32(height), ..StackEntry::default() };
        self.count = 1;
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<StackEntry> {
        self.count = self.count.checked_sub(1)?;
        Some(self.stack[self.count])
    }

    /// Pushes the children that are nearer than `enough`, the nearest last.
    #[inline(always)]
    pub(crate) fn push_children<S: Simd>(
        &mut self,
        node: StackEntry,
        squares: f64x8<S>,
        enough: f64,
    ) {
        let mut nearer = squares.simd_lt(enough).to_bitmask();
        let lowest = self.count;
        while nearer != 0 {
            let lane = nearer.trailing_zeros();
            nearer &= nearer - 1;
            let squared = squares[lane as usize];
            let mut place = self.count;
            while place > lowest && self.stack[place - 1].squared < squared {
                self.stack[place] = self.stack[place - 1];
                place -= 1;
            }
            let index = node.index * as_u32(LANES) + lane;
            self.stack[place] = StackEntry { squared, index, height: node.height - 1 };
            self.count += 1;
        }
    }
}

/// A subtree that may contain the closest triangle.
#[derive(Clone, Copy, Default)]
pub(crate) struct StackEntry {
    /// The squared distance to its box.
    pub(crate) squared: f64,
    pub(crate) index: u32,
    /// 0 for a leaf.
    pub(crate) height: u32,
}

/// The boxes of triangles or of their sections; slabs if there are sections.
fn enclose(
    original: &[u32],
    pieces: &[Section],
    corners: impl Fn(usize) -> [DVec3; 3] + Sync,
) -> (BvhStorage, Vec<Slabs>) {
    let triangle = |slot: usize| corners(original[slot] as usize);
    if pieces.is_empty() {
        return (BvhStorage::new(original.len(), triangle, None), Vec::new());
    }
    let bounds_of_leaf = |leaf: usize| {
        let slots = leaf * LANES..pieces.len().min((leaf + 1) * LANES);
        let bounds = slots.map(|slot| pieces[slot].bounds(&triangle(slot)));
        bounds.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[min, max], [p, q]| {
            [min.min(p), max.max(q)]
        })
    };
    let slab = |leaf: usize| {
        let slot = |lane: usize| (leaf * LANES + lane).min(original.len() - 1);
        slab_of(core::array::from_fn::<_, LANES, _>(|lane| triangle(slot(lane))))
    };
    let leaves = original.len().div_ceil(LANES);
    let slabs = parallel::collect(leaves.div_ceil(LANES), |node| {
        Slabs::new((node * LANES..leaves.min((node + 1) * LANES)).map(slab))
    });
    (BvhStorage::new(original.len(), triangle, Some(&bounds_of_leaf)), slabs)
}

/// The indices of boxes in the order of the leaves.
fn in_leaves(count: usize, bounds: impl Fn(usize) -> [DVec3; 2] + Sync) -> Vec<u32> {
    let mut places = places(&parallel::collect(count, |i| {
        let [min, max] = bounds(i);
        // Halved first, so that no sum overflows.
        0.5 * min + 0.5 * max
    }));
    order(&mut places);
    parallel::collect(count, |slot| places[slot].triangle)
}

/// A box and its centre, in units of 2^-32 of the longest extent of all centres.
#[derive(Clone, Copy)]
struct Place {
    center: [u32; 3],
    triangle: u32,
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast of a float beyond the range gives its end"
)]
fn places(centers: &[DVec3]) -> Vec<Place> {
    let add = |[min, max]: [DVec3; 2], [p, q]: [DVec3; 2]| [min.min(p), max.max(q)];
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [min, max] = parallel::fold(centers.len(), nothing, |t| [centers[t]; 2], add);
    let scale = f64::from(u32::MAX) / (0.5 * max - 0.5 * min).max_element().max(f64::MIN_POSITIVE);
    parallel::collect(centers.len(), |t| {
        let center = (0.5 * centers[t] - 0.5 * min) * scale;
        Place { center: center.to_array().map(|c| c as u32), triangle: as_u32(t) }
    })
}

/// Largest number of centres that the longest extent is computed from.
const SAMPLES: usize = 1000;

/// Brings triangles into the order of the leaves.
fn order(places: &mut [Place]) {
    if places.len() <= LANES {
        return;
    }
    let mut part = LANES;
    while part * LANES < places.len() {
        part *= LANES;
    }
    let middle = places.len().div_ceil(part) / 2 * part;
    let (mut min, mut max) = ([u32::MAX; 3], [0; 3]);
    for place in places.iter().step_by(places.len().div_ceil(SAMPLES)) {
        for axis in 0..3 {
            min[axis] = min[axis].min(place.center[axis]);
            max[axis] = max[axis].max(place.center[axis]);
        }
    }
    let spread = |axis: usize| max[axis] - min[axis];
    let longest = if spread(0) >= spread(1).max(spread(2)) { 0 } else { 1 };
    let axis = if spread(2) > spread(longest) { 2 } else { longest };
    places.select_nth_unstable_by_key(middle, |place| {
        u64::from(place.center[axis]) << 32 | u64::from(place.triangle)
    });
    let (low, high) = places.split_at_mut(middle);
    if low.len() >= SEQUENTIAL {
        parallel::both(|| order(low), || order(high));
    } else {
        order(low);
        order(high);
    }
}
