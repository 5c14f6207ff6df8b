//! A bounding volume hierarchy: a tree of boxes over triangles, eight by eight.
//!
//! The triangles are ordered so that those of a leaf, of eight leaves, of sixty-four leaves and so
//! on are close together: at multiples of these numbers they are parted at the median of their
//! centres along the longest extent. What belongs together is then known from the place alone, and
//! there is nothing to point to. The eight boxes of a node, and the eight triangles of a leaf, are
//! measured side by side, with the widest vector instructions that the processor has.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f64x8};
use glam::DVec3;
use mesh_core::parallel;

use crate::needles::{Piece, bounds_of, pieces};
use crate::proved::at_least;
use crate::slab::{Slab, Slabs};
use crate::wide::{Columns, LANES, Wide, closest_on_triangles, squared_gaps};

/// Below this many triangles a part is ordered by one thread.
const SEQUENTIAL: usize = 4096;

/// More than there can be in the tree over `u32` many triangles at any one time.
const MAX_TASKS: usize = 96;

/// The tree and its triangles.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    simd: Level,
    leaves: Vec<Leaf>,
    /// The nodes of each height, those over leaves first, the root last.
    heights: Vec<Vec<Node>>,
    /// The index that each triangle had when the tree was built.
    original: Vec<u32>,
    /// What of the triangle in each place the boxes are round; nothing where that is all of it.
    pieces: Vec<Piece>,
    /// What the triangles of eight leaves each are between, where some have several pieces.
    slabs: Vec<Slabs>,
    /// Every triangle once, in the order of the leaves, where some have several pieces.
    in_space: Vec<u32>,
}

/// Eight triangles; the last one is repeated where there are fewer.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Leaf {
    corners: [Columns; 3],
}

/// The boxes of eight leaves or nodes; those that are missing are infinitely far.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Node {
    min: Columns,
    max: Columns,
}

/// The answer of a closest-point query.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    /// From the query to the closest point.
    pub(crate) offset: DVec3,
    pub(crate) squared: f64,
    /// Place of the triangle in the tree; a good first guess for a query nearby.
    pub(crate) slot: u32,
}

impl Leaf {
    fn new(triangle: impl Fn(usize) -> [DVec3; 3]) -> Self {
        let mut corners = [[[0.0; LANES]; 3]; 3];
        for lane in 0..LANES {
            for (columns, corner) in corners.iter_mut().zip(triangle(lane)) {
                set(columns, lane, corner);
            }
        }
        Self { corners }
    }

    #[inline(always)]
    pub(crate) fn triangle(&self, lane: usize) -> [DVec3; 3] {
        let [a, b, c] = &self.corners;
        [get(a, lane), get(b, lane), get(c, lane)]
    }

    /// The bounds of the triangles.
    fn bounds(&self) -> [DVec3; 2] {
        bounds(&self.corners, &self.corners)
    }

    #[inline(always)]
    pub(crate) fn wide<S: Simd>(&self, simd: S) -> [Wide<S>; 3] {
        let [a, b, c] = &self.corners;
        [Wide::load(simd, a), Wide::load(simd, b), Wide::load(simd, c)]
    }
}

impl Node {
    const EMPTY: Self =
        Self { min: [[f64::INFINITY; LANES]; 3], max: [[f64::NEG_INFINITY; LANES]; 3] };

    fn new(children: impl Iterator<Item = [DVec3; 2]>) -> Self {
        let mut node = Self::EMPTY;
        for (lane, [min, max]) in children.enumerate() {
            set(&mut node.min, lane, min);
            set(&mut node.max, lane, max);
        }
        node
    }

    /// The bounds of the boxes.
    fn bounds(&self) -> [DVec3; 2] {
        bounds(&[self.min], &[self.max])
    }

    #[inline(always)]
    pub(crate) fn wide<S: Simd>(&self, simd: S) -> [Wide<S>; 2] {
        [Wide::load(simd, &self.min), Wide::load(simd, &self.max)]
    }
}

fn set([x, y, z]: &mut Columns, lane: usize, value: DVec3) {
    (x[lane], y[lane], z[lane]) = value.into();
}

#[inline(always)]
fn get([x, y, z]: &Columns, lane: usize) -> DVec3 {
    DVec3::new(x[lane], y[lane], z[lane])
}

/// The smallest coordinates of some columns and the largest of others.
fn bounds(low: &[Columns], high: &[Columns]) -> [DVec3; 2] {
    let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for columns in low {
        for axis in 0..3 {
            for x in columns[axis] {
                min[axis] = min[axis].min(x);
            }
        }
    }
    for columns in high {
        for axis in 0..3 {
            for x in columns[axis] {
                max[axis] = max[axis].max(x);
            }
        }
    }
    [min, max].map(DVec3::from_array)
}

impl Bvh {
    /// A tree over at least one triangle.
    pub(crate) fn new(corners: impl Fn(usize) -> [DVec3; 3] + Sync, count: usize) -> Self {
        let whole = |t: usize| bounds_of(corners(t).into_iter());
        let mut tree = Self {
            simd: Level::new(),
            leaves: Vec::new(),
            heights: Vec::new(),
            original: Vec::new(),
            pieces: Vec::new(),
            slabs: Vec::new(),
            in_space: Vec::new(),
        };
        if let Some((triangles, pieces)) = pieces(&corners, count) {
            let slots =
                in_leaves(pieces.len(), |i| pieces[i].bounds(&corners(triangles[i] as usize)));
            tree.original = parallel::collect(slots.len(), |slot| triangles[slots[slot] as usize]);
            tree.pieces = parallel::collect(slots.len(), |slot| pieces[slots[slot] as usize]);
            let mut is_there = vec![false; count];
            let first = |&t: &u32| !core::mem::replace(&mut is_there[t as usize], true);
            tree.in_space = tree.original.iter().copied().filter(first).collect();
        } else {
            tree.original = in_leaves(count, whole);
        }
        tree.follow(corners);
        tree
    }

    /// Takes up the triangles from where they are now, in the order as it is.
    pub(crate) fn follow(&mut self, corners: impl Fn(usize) -> [DVec3; 3] + Sync) {
        let original = &self.original;
        let last = original.len() - 1;
        let leaf = |leaf: usize| {
            Leaf::new(|lane| corners(original[(leaf * LANES + lane).min(last)] as usize))
        };
        let leaves = parallel::collect(original.len().div_ceil(LANES), leaf);
        let pieces = &self.pieces;
        let bounds = |leaf: usize| {
            if pieces.is_empty() {
                return leaves[leaf].bounds();
            }
            let slots = leaf * LANES..pieces.len().min((leaf + 1) * LANES);
            let of_slot = |slot: usize| pieces[slot].bounds(&corners(original[slot] as usize));
            slots.map(of_slot).fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[min, max], [p, q]| {
                [min.min(p), max.max(q)]
            })
        };
        let mut heights = vec![nodes(leaves.len(), bounds)];
        while let Some(below) = heights.last().filter(|below| below.len() > 1) {
            let above = nodes(below.len(), |node| below[node].bounds());
            heights.push(above);
        }
        if !pieces.is_empty() {
            let slab = |leaf: usize| {
                Slab::new(core::array::from_fn::<_, LANES, _>(|lane| leaves[leaf].triangle(lane)))
            };
            self.slabs = parallel::collect(leaves.len().div_ceil(LANES), |node| {
                Slabs::new((node * LANES..leaves.len().min((node + 1) * LANES)).map(slab))
            });
        }
        (self.leaves, self.heights) = (leaves, heights);
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
        self.leaves[slot as usize / LANES].triangle(slot as usize % LANES)
    }

    /// The bounds of a triangle in the tree, or of the piece of it that is in this place.
    pub(crate) fn bounds(&self, slot: u32) -> [DVec3; 2] {
        let triangle = self.triangle(slot);
        match self.pieces.get(slot as usize) {
            Some(piece) => piece.bounds(&triangle),
            None => bounds_of(triangle.into_iter()),
        }
    }

    /// The closest point of all triangles, `guess` being any triangle that is hoped to be near.
    pub(crate) fn nearest(&self, point: DVec3, guess: u32) -> Nearest {
        dispatch!(self.simd, simd => self.nearest_with(simd, point, guess))
    }

    #[inline(always)]
    pub(crate) fn nearest_with<S: Simd>(&self, simd: S, point: DVec3, guess: u32) -> Nearest {
        let point = Wide::splat(simd, point);
        let first = guess / LANES as u32;
        let mut best = self.nearest_in_leaf(simd, point, first);
        let mut tasks = Tasks::new(self.heights.len());
        // A point that is not finite has no distance.
        while let Some(task) = tasks.pop().filter(|_| !best.squared.is_nan()) {
            if task.squared >= best.squared {
                continue;
            }
            if task.height > 0 {
                let squares = self.squared_gaps(simd, point, task);
                tasks.push_children(task, squares, best.squared);
            } else if task.index != first {
                let candidate = self.nearest_in_leaf(simd, point, task.index);
                if candidate.squared < best.squared {
                    best = candidate;
                }
            }
        }
        best
    }

    /// For each point the closest one of all triangles, if that is closer than a distance. Where most are
    /// not, it takes little time for points of which eight that follow each other are close together.
    pub(crate) fn nearer_than_each(&self, points: &[DVec3], than: &[f64]) -> Vec<Option<Nearest>> {
        let count = points.len().min(than.len());
        let mut found = vec![None; count];
        // Loops, for what is in a closure is compiled for the plainest processor.
        dispatch!(self.simd, simd => {
            let mut tasks = Tasks::new(self.heights.len());
            for start in (0..count).step_by(LANES) {
                let eight = start..count.min(start + LANES);
                let box_of_eight = bounds_of(points[eight.clone()].iter().copied());
                let farthest = than[eight.clone()].iter().copied().fold(0.0, f64::max);
                if self.has_leaf_within(simd, box_of_eight, farthest, &mut tasks) {
                    for i in eight {
                        found[i] = self.nearer_than(simd, points[i], than[i], &mut tasks);
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
        tasks: &mut Tasks,
    ) -> bool {
        let bounds = [Wide::splat(simd, min), Wide::splat(simd, max)];
        let enough = distance * distance;
        tasks.restart(self.heights.len());
        while let Some(task) = tasks.pop() {
            if task.height == 0 {
                return true;
            }
            let squares = squared_gaps(bounds, self.node(task).wide(simd));
            tasks.push_children(task, squares, enough);
        }
        false
    }

    #[inline(always)]
    fn nearer_than<S: Simd>(
        &self,
        simd: S,
        point: DVec3,
        than: f64,
        tasks: &mut Tasks,
    ) -> Option<Nearest> {
        let point = Wide::splat(simd, point);
        let mut best = None;
        let mut enough = than * than;
        tasks.restart(self.heights.len());
        while let Some(task) = tasks.pop() {
            if task.squared >= enough {
                continue;
            }
            if task.height > 0 {
                let squares = self.squared_gaps(simd, point, task);
                tasks.push_children(task, squares, enough);
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

    /// A number that the distance from a point to all triangles is not below, up to
    /// [`Rounding`](crate::proved::Rounding), and that is not above `distance`.
    pub(crate) fn at_least(&self, point: DVec3, distance: f64) -> f64 {
        dispatch!(self.simd, simd => self.at_least_with(simd, point, distance))
    }

    #[inline(always)]
    fn at_least_with<S: Simd>(&self, simd: S, point: DVec3, distance: f64) -> f64 {
        let wide = Wide::splat(simd, point);
        let mut nearest = distance;
        let mut tasks = Tasks::new(self.heights.len());
        while let Some(task) = tasks.pop() {
            let enough = nearest * nearest;
            if task.squared >= enough {
                continue;
            }
            if task.height > 0 {
                let squares = self.squared_gaps(simd, wide, task);
                tasks.push_children(task, squares, enough);
            } else {
                for lane in 0..LANES {
                    nearest = nearest.min(at_least(point, &self.leaf(task.index).triangle(lane)));
                }
            }
        }
        nearest
    }

    /// Numbers that the squared distances from a point to the children of a node are not below. The box of
    /// a leaf may be near where its needles are not.
    #[inline(always)]
    fn squared_gaps<S: Simd>(&self, simd: S, point: Wide<S>, node: Task) -> f64x8<S> {
        let squares = squared_gaps([point, point], self.node(node).wide(simd));
        match self.slabs.get(node.index as usize) {
            Some(slabs) if node.height == 1 => squares.max(slabs.squared_gaps(simd, point)),
            _ => squares,
        }
    }

    /// Whether there are needles in pieces, which queries are quicker for one by one.
    #[inline(always)]
    pub(crate) fn has_pieces(&self) -> bool {
        !self.pieces.is_empty()
    }

    #[inline(always)]
    pub(crate) fn nearest_in_leaf<S: Simd>(&self, simd: S, point: Wide<S>, leaf: u32) -> Nearest {
        let triangles = self.leaves[leaf as usize].wide(simd);
        let (offsets, squares) = closest_on_triangles(point, triangles);
        let squared = squares.reduce_min();
        let lane = squares.simd_eq(squared).to_bitmask().trailing_zeros() % LANES as u32;
        Nearest { offset: offsets.at(lane as usize), squared, slot: leaf * LANES as u32 + lane }
    }

    #[inline(always)]
    pub(crate) fn simd(&self) -> Level {
        self.simd
    }

    #[inline(always)]
    pub(crate) fn root_height(&self) -> usize {
        self.heights.len()
    }

    #[inline(always)]
    pub(crate) fn leaf(&self, index: u32) -> &Leaf {
        &self.leaves[index as usize]
    }

    #[inline(always)]
    pub(crate) fn node(&self, task: Task) -> &Node {
        &self.heights[task.height as usize - 1][task.index as usize]
    }
}

/// The parts of the tree that wait to be searched.
pub(crate) struct Tasks {
    tasks: [Task; MAX_TASKS],
    count: usize,
}

impl Tasks {
    #[inline(always)]
    pub(crate) fn new(height: usize) -> Self {
        let mut tasks = [Task::default(); MAX_TASKS];
        tasks[0].height = height as u32;
        Self { tasks, count: 1 }
    }

    /// Only the root.
    #[inline(always)]
    pub(crate) fn restart(&mut self, height: usize) {
        self.tasks[0] = Task { height: height as u32, ..Task::default() };
        self.count = 1;
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<Task> {
        self.count = self.count.checked_sub(1)?;
        Some(self.tasks[self.count])
    }

    /// Adds the children of a node that are nearer than `enough`, the nearest last.
    #[inline(always)]
    pub(crate) fn push_children<S: Simd>(&mut self, node: Task, squares: f64x8<S>, enough: f64) {
        let mut nearer = squares.simd_lt(enough).to_bitmask();
        let lowest = self.count;
        while nearer != 0 {
            let lane = nearer.trailing_zeros();
            nearer &= nearer - 1;
            let squared = squares[lane as usize];
            let mut place = self.count;
            while place > lowest && self.tasks[place - 1].squared < squared {
                self.tasks[place] = self.tasks[place - 1];
                place -= 1;
            }
            let index = node.index * LANES as u32 + lane;
            self.tasks[place] = Task { squared, index, height: node.height - 1 };
            self.count += 1;
        }
    }
}

/// A part of the tree that may hold the closest triangle.
#[derive(Clone, Copy, Default)]
pub(crate) struct Task {
    /// The squared distance to its box.
    pub(crate) squared: f64,
    pub(crate) index: u32,
    /// Of a leaf, 0.
    pub(crate) height: u32,
}

/// Nodes over children with these bounds.
fn nodes(children: usize, bounds: impl Fn(usize) -> [DVec3; 2] + Sync) -> Vec<Node> {
    let node = |node: usize| {
        let range = node * LANES..children.min((node + 1) * LANES);
        Node::new(range.map(&bounds))
    };
    parallel::collect(children.div_ceil(LANES), node)
}

/// The numbers of these boxes in the order of the leaves, which is by their centres.
fn in_leaves(count: usize, bounds: impl Fn(usize) -> [DVec3; 2] + Sync) -> Vec<u32> {
    let mut places = places(&parallel::collect(count, |i| {
        let [min, max] = bounds(i);
        // Halved first, so that no sum overflows.
        0.5 * min + 0.5 * max
    }));
    order(&mut places);
    parallel::collect(count, |slot| places[slot].triangle)
}

/// A triangle, or piece of one, and where its centre is, in steps of a 2^32th of the longest extent of all centres.
#[derive(Clone, Copy)]
struct Place {
    center: [u32; 3],
    triangle: u32,
}

fn places(centers: &[DVec3]) -> Vec<Place> {
    let add = |[min, max]: [DVec3; 2], [p, q]: [DVec3; 2]| [min.min(p), max.max(q)];
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [min, max] = parallel::fold(centers.len(), nothing, |t| [centers[t]; 2], add);
    let scale = f64::from(u32::MAX) / (0.5 * max - 0.5 * min).max_element().max(f64::MIN_POSITIVE);
    parallel::collect(centers.len(), |t| {
        let center = (0.5 * centers[t] - 0.5 * min) * scale;
        Place { center: center.to_array().map(|c| c as u32), triangle: t as u32 }
    })
}

/// The most centres to find the longest extent from.
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
