//! A bounding volume hierarchy: a binary tree of boxes over triangles.
//!
//! The triangles are halved at the median of their centres along the longest extent. A tree over
//! `k` leaves takes `2k - 1` consecutive nodes, the left subtree following its parent directly, so
//! the place of every subtree is known beforehand and the two halves are built in parallel into
//! their own parts of the arrays.

use glam::DVec3;
use mesh_core::parallel;

use crate::closest::closest_on_triangle;

/// Triangles per leaf, except for the last.
const LEAF: usize = 4;

/// Below this many triangles a subtree is built by one thread.
#[cfg(feature = "rayon")]
const SEQUENTIAL: usize = 4096;

/// More than the depth of any tree over `u32` many triangles.
const MAX_DEPTH: usize = 40;

#[derive(Clone, Copy, Debug)]
struct Node {
    min: DVec3,
    max: DVec3,
    /// Of an inner node, the right child; of a leaf, its first triangle.
    start: u32,
    /// Of a leaf, the number of triangles; 0 for an inner node.
    count: u32,
}

impl Node {
    const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY, start: 0, count: 0 };

    /// The squared distance from a point to the box.
    #[inline]
    fn squared_distance(&self, point: DVec3) -> f64 {
        (self.min - point).max(point - self.max).max(DVec3::ZERO).length_squared()
    }
}

/// The tree and its triangles, in the order of the leaves.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    triangles: Vec<[DVec3; 3]>,
    /// The index that each triangle had when the tree was built.
    original: Vec<u32>,
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

impl Bvh {
    /// A tree over at least one triangle.
    pub(crate) fn new(corners: impl Fn(usize) -> [DVec3; 3] + Sync, count: usize) -> Self {
        let centers = parallel::collect(count, |t| {
            let [a, b, c] = corners(t);
            // Halved first, so that no sum overflows.
            0.5 * a.min(b).min(c) + 0.5 * a.max(b).max(c)
        });
        let mut original: Vec<u32> = (0..count as u32).collect();
        let mut nodes = vec![Node::EMPTY; 2 * count.div_ceil(LEAF).max(1) - 1];
        Builder { corners: &corners, centers: &centers }.build(&mut nodes, &mut original, 0, 0);
        let triangles = parallel::collect(count, |slot| corners(original[slot] as usize));
        Self { nodes, triangles, original }
    }

    pub(crate) fn original(&self, slot: u32) -> u32 {
        self.original[slot as usize]
    }

    pub(crate) fn triangle(&self, slot: u32) -> &[DVec3; 3] {
        &self.triangles[slot as usize]
    }

    /// The closest point of triangle `slot` only.
    #[inline]
    pub(crate) fn nearest_on(&self, point: DVec3, slot: u32) -> Nearest {
        let offset = closest_on_triangle(point, self.triangle(slot));
        Nearest { offset, squared: offset.length_squared(), slot }
    }

    /// The closest point of all triangles, `guess` being any triangle that is hoped to be near.
    pub(crate) fn nearest(&self, point: DVec3, guess: u32) -> Nearest {
        let mut best = self.nearest_on(point, guess);
        let mut stack = [(0_u32, 0.0_f64); MAX_DEPTH];
        let mut height = 0;
        let mut current = 0_u32;
        loop {
            let node = &self.nodes[current as usize];
            if node.count > 0 {
                for slot in node.start..node.start + node.count {
                    let candidate = self.nearest_on(point, slot);
                    if candidate.squared < best.squared {
                        best = candidate;
                    }
                }
            } else {
                let (left, right) = (current + 1, node.start);
                let mut near = (left, self.nodes[left as usize].squared_distance(point));
                let mut far = (right, self.nodes[right as usize].squared_distance(point));
                if far.1 < near.1 {
                    (near, far) = (far, near);
                }
                if far.1 < best.squared {
                    stack[height] = far;
                    height += 1;
                }
                if near.1 < best.squared {
                    current = near.0;
                    continue;
                }
            }
            // The next subtree that can still hold something closer.
            loop {
                if height == 0 {
                    return best;
                }
                height -= 1;
                if stack[height].1 < best.squared {
                    current = stack[height].0;
                    break;
                }
            }
        }
    }
}

struct Builder<'a, F> {
    corners: &'a F,
    centers: &'a [DVec3],
}

impl<F: Fn(usize) -> [DVec3; 3] + Sync> Builder<'_, F> {
    /// Fills `nodes` with the tree over the triangles of `slots`. The first of them have the
    /// indices `first_node` and `first_slot` in the whole tree. Returns the bounds.
    fn build(
        &self,
        nodes: &mut [Node],
        slots: &mut [u32],
        first_node: u32,
        first_slot: u32,
    ) -> (DVec3, DVec3) {
        let Some((root, below)) = nodes.split_first_mut() else {
            return (DVec3::INFINITY, DVec3::NEG_INFINITY);
        };
        if below.is_empty() {
            let (min, max) = self.bounds(slots);
            *root = Node { min, max, start: first_slot, count: slots.len() as u32 };
            return (min, max);
        }
        let left_leaves = slots.len().div_ceil(LEAF) / 2;
        let left_nodes = 2 * left_leaves - 1;
        self.divide(slots, left_leaves * LEAF);
        let (left_slots, right_slots) = slots.split_at_mut(left_leaves * LEAF);
        let (left, right) = below.split_at_mut(left_nodes);
        let right_node = first_node + 1 + left_nodes as u32;
        let right_slot = first_slot + left_slots.len() as u32;
        let (l, r) = join(
            left_slots.len(),
            || self.build(left, left_slots, first_node + 1, first_slot),
            || self.build(right, right_slots, right_node, right_slot),
        );
        let (min, max) = (l.0.min(r.0), l.1.max(r.1));
        *root = Node { min, max, start: right_node, count: 0 };
        (min, max)
    }

    /// Moves the `count` triangles with the smallest centres to the front, along the axis in which
    /// the centres are spread widest.
    fn divide(&self, slots: &mut [u32], count: usize) {
        let spread = slots.iter().map(|&t| self.centers[t as usize]);
        let (min, max) = spread
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
        let axis = (max - min).max_position();
        slots.select_nth_unstable_by(count, |&s, &t| {
            let (p, q) = (self.centers[s as usize], self.centers[t as usize]);
            p[axis].total_cmp(&q[axis]).then(s.cmp(&t))
        });
    }

    fn bounds(&self, slots: &[u32]) -> (DVec3, DVec3) {
        slots
            .iter()
            .flat_map(|&t| (self.corners)(t as usize))
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)))
    }
}

/// Both, at the same time when the smaller one has enough work.
#[cfg(feature = "rayon")]
fn join<T: Send>(
    triangles: usize,
    left: impl FnOnce() -> T + Send,
    right: impl FnOnce() -> T + Send,
) -> (T, T) {
    if triangles >= SEQUENTIAL { rayon::join(left, right) } else { (left(), right()) }
}

#[cfg(not(feature = "rayon"))]
fn join<T>(_: usize, left: impl FnOnce() -> T, right: impl FnOnce() -> T) -> (T, T) {
    (left(), right())
}
