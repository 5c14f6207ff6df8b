//! Storage of triangles and boxes, eight side by side, in single precision where that is exact.
//!
//! Scanners, STL, glTF and most PLY files have positions in single precision. Such a surface takes half the
//! memory; queries convert it back to double precision without loss.

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, f64x8};
use glam::DVec3;
use mesh_core::parallel;
use mesh_core::simd::{LANES, Vec3x8};

/// Eight numbers in memory, aligned to a cache line or half of one.
pub(crate) trait Column: Copy + Send + Sync {
    /// Eight zeros.
    const ZERO: Self;

    /// Stores `value`, rounded down.
    fn set_below(&mut self, lane: usize, value: f64);

    /// Stores `value`, rounded up.
    fn set_above(&mut self, lane: usize, value: f64);

    fn get(&self, lane: usize) -> f64;

    fn load<S: Simd>(&self, simd: S) -> f64x8<S>;
}

/// Eight numbers in single precision.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(crate) struct Single([f32; LANES]);

/// Eight numbers in double precision.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Double([f64; LANES]);

impl Column for Single {
    const ZERO: Self = Self([0.0; LANES]);

    fn set_below(&mut self, lane: usize, value: f64) {
        let near = value as f32;
        self.0[lane] = if f64::from(near) > value { near.next_down() } else { near };
    }

    fn set_above(&mut self, lane: usize, value: f64) {
        let near = value as f32;
        self.0[lane] = if f64::from(near) < value { near.next_up() } else { near };
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> f64 {
        f64::from(self.0[lane])
    }

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S) -> f64x8<S> {
        let all: f32x8<S> = self.0.simd_into(simd);
        let (low, high) = all.widen();
        low.combine(high)
    }
}

impl Column for Double {
    const ZERO: Self = Self([0.0; LANES]);

    fn set_below(&mut self, lane: usize, value: f64) {
        self.0[lane] = value;
    }

    fn set_above(&mut self, lane: usize, value: f64) {
        self.0[lane] = value;
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S) -> f64x8<S> {
        self.0.simd_into(simd)
    }
}

/// Eight triangles; the last one is repeated where there are fewer.
#[derive(Clone, Copy, Debug)]
struct Leaf<C> {
    corners: [[C; 3]; 3],
}

/// The boxes of eight children; missing children are infinitely far away.
#[derive(Clone, Copy, Debug)]
struct Node<C> {
    min: [C; 3],
    max: [C; 3],
}

impl<C: Column> Leaf<C> {
    fn new(triangle: impl Fn(usize) -> [DVec3; 3]) -> Self {
        let mut corners = [[C::ZERO; 3]; 3];
        for lane in 0..LANES {
            for (columns, corner) in corners.iter_mut().zip(triangle(lane)) {
                for (column, value) in columns.iter_mut().zip(corner.to_array()) {
                    column.set_below(lane, value);
                }
            }
        }
        Self { corners }
    }

    #[inline(always)]
    fn triangle(&self, lane: usize) -> [DVec3; 3] {
        let [a, b, c] = &self.corners;
        [get(a, lane), get(b, lane), get(c, lane)]
    }

    #[inline(always)]
    fn wide<S: Simd>(&self, simd: S) -> [Vec3x8<S>; 3] {
        let [a, b, c] = &self.corners;
        [load(simd, a), load(simd, b), load(simd, c)]
    }

    /// The bounds of the triangles.
    fn bounds(&self) -> [DVec3; 2] {
        bounds(&self.corners, &self.corners)
    }
}

impl<C: Column> Node<C> {
    fn new(mut children: impl Iterator<Item = [DVec3; 2]>) -> Self {
        let mut node = Self { min: [C::ZERO; 3], max: [C::ZERO; 3] };
        for lane in 0..LANES {
            let [min, max] = children.next().unwrap_or([DVec3::INFINITY, DVec3::NEG_INFINITY]);
            for axis in 0..3 {
                node.min[axis].set_below(lane, min[axis]);
                node.max[axis].set_above(lane, max[axis]);
            }
        }
        node
    }

    #[inline(always)]
    fn wide<S: Simd>(&self, simd: S) -> [Vec3x8<S>; 2] {
        [load(simd, &self.min), load(simd, &self.max)]
    }

    /// The bounds of the boxes.
    fn bounds(&self) -> [DVec3; 2] {
        bounds(&[self.min], &[self.max])
    }
}

#[inline(always)]
fn get<C: Column>([x, y, z]: &[C; 3], lane: usize) -> DVec3 {
    DVec3::new(x.get(lane), y.get(lane), z.get(lane))
}

#[inline(always)]
fn load<S: Simd, C: Column>(simd: S, [x, y, z]: &[C; 3]) -> Vec3x8<S> {
    Vec3x8 { x: x.load(simd), y: y.load(simd), z: z.load(simd) }
}

/// The smallest coordinates of some columns and the largest of others.
fn bounds<C: Column>(low: &[[C; 3]], high: &[[C; 3]]) -> [DVec3; 2] {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for lane in 0..LANES {
        for columns in low {
            min = min.min(get(columns, lane));
        }
        for columns in high {
            max = max.max(get(columns, lane));
        }
    }
    [min, max]
}

/// All levels from the leaves to the root.
#[derive(Clone, Debug)]
struct Levels<C> {
    leaves: Vec<Leaf<C>>,
    /// The nodes of each height, from the parents of leaves to the root.
    heights: Vec<Vec<Node<C>>>,
}

impl<C: Column> Levels<C> {
    fn new(
        triangles: usize,
        triangle: impl Fn(usize) -> [DVec3; 3] + Sync,
        bounds_of_leaf: Option<&(dyn Fn(usize) -> [DVec3; 2] + Sync)>,
    ) -> Self {
        let leaf =
            |leaf: usize| Leaf::new(|lane| triangle((leaf * LANES + lane).min(triangles - 1)));
        let leaves: Vec<Leaf<C>> = parallel::collect(triangles.div_ceil(LANES), leaf);
        let over_leaves = nodes(leaves.len(), |leaf| match bounds_of_leaf {
            Some(bounds) => bounds(leaf),
            None => leaves[leaf].bounds(),
        });
        let mut heights = vec![over_leaves];
        while let Some(below) = heights.last().filter(|below| below.len() > 1) {
            let above = nodes(below.len(), |node| below[node].bounds());
            heights.push(above);
        }
        Self { leaves, heights }
    }

    #[inline(always)]
    fn node(&self, height: u32, index: u32) -> &Node<C> {
        &self.heights[height as usize - 1][index as usize]
    }
}

/// Nodes over children with these bounds.
fn nodes<C: Column>(children: usize, bounds: impl Fn(usize) -> [DVec3; 2] + Sync) -> Vec<Node<C>> {
    let node = |node: usize| {
        let range = node * LANES..children.min((node + 1) * LANES);
        Node::new(range.map(&bounds))
    };
    parallel::collect(children.div_ceil(LANES), node)
}

/// The triangles of a tree by slot, and its boxes.
#[derive(Clone, Debug)]
pub(crate) struct BvhStorage(Precision);

#[derive(Clone, Debug)]
enum Precision {
    Single(Levels<Single>),
    Double(Levels<Double>),
}

impl BvhStorage {
    /// Storage for at least one triangle. The box of a leaf contains its triangles, unless other bounds are
    /// given.
    pub(crate) fn new(
        triangles: usize,
        triangle: impl Fn(usize) -> [DVec3; 3] + Sync,
        bounds_of_leaf: Option<&(dyn Fn(usize) -> [DVec3; 2] + Sync)>,
    ) -> Self {
        Self(if are_single(triangles, &triangle) {
            Precision::Single(Levels::new(triangles, triangle, bounds_of_leaf))
        } else {
            Precision::Double(Levels::new(triangles, triangle, bounds_of_leaf))
        })
    }

    /// The height of the root above the leaves, at least one.
    #[inline(always)]
    pub(crate) fn root_height(&self) -> usize {
        match &self.0 {
            Precision::Single(levels) => levels.heights.len(),
            Precision::Double(levels) => levels.heights.len(),
        }
    }

    /// The triangle in a slot: eight times the leaf plus the lane.
    #[inline(always)]
    pub(crate) fn triangle(&self, slot: u32) -> [DVec3; 3] {
        let (leaf, lane) = (slot as usize / LANES, slot as usize % LANES);
        match &self.0 {
            Precision::Single(levels) => levels.leaves[leaf].triangle(lane),
            Precision::Double(levels) => levels.leaves[leaf].triangle(lane),
        }
    }

    /// The triangles of a leaf.
    #[inline(always)]
    pub(crate) fn leaf<S: Simd>(&self, simd: S, leaf: u32) -> [Vec3x8<S>; 3] {
        match &self.0 {
            Precision::Single(levels) => levels.leaves[leaf as usize].wide(simd),
            Precision::Double(levels) => levels.leaves[leaf as usize].wide(simd),
        }
    }

    /// The boxes of the children of a node at a height above the leaves.
    #[inline(always)]
    pub(crate) fn node<S: Simd>(&self, simd: S, height: u32, index: u32) -> [Vec3x8<S>; 2] {
        match &self.0 {
            Precision::Single(levels) => levels.node(height, index).wide(simd),
            Precision::Double(levels) => levels.node(height, index).wide(simd),
        }
    }
}

/// Whether all coordinates are exact in single precision.
fn are_single(triangles: usize, triangle: impl Fn(usize) -> [DVec3; 3] + Sync) -> bool {
    let is_single = |slot| triangle(slot).into_iter().all(|p| p.as_vec3().as_dvec3() == p);
    parallel::holds_in_blocks(triangles, |mut range| range.all(is_single))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use mesh_core::SplitMix64;

    fn triangles(count: usize, keep: impl Fn(f64) -> f64) -> Vec<[DVec3; 3]> {
        let mut random = SplitMix64::new(5);
        let mut point = || DVec3::from_array([(); 3].map(|()| keep(random.symmetric())));
        (0..count).map(|_| [(); 3].map(|()| point())).collect()
    }

    fn is_single(boxes: &BvhStorage) -> bool {
        matches!(boxes.0, Precision::Single(_))
    }

    #[test]
    fn half_the_memory_is_enough_where_every_digit_is_kept() {
        let single = triangles(100, |x| f64::from(x as f32));
        let mut double = single.clone();
        double[99][2].z = 0.1;
        for (triangles, expected) in [(&single, true), (&double, false)] {
            let boxes = BvhStorage::new(100, |t| triangles[t], None);
            assert_eq!(is_single(&boxes), expected);
            assert!((0..100).all(|t| boxes.triangle(t as u32) == triangles[t]));
            let leaf = dispatch!(Level::new(), simd => boxes.leaf(simd, 12).map(|c| c.at(3)));
            // The last triangle is repeated.
            assert_eq!(leaf, triangles[99]);
        }
        assert_eq!(size_of::<Leaf<Single>>(), 36 * LANES);
        assert_eq!(2 * size_of::<Node<Single>>(), size_of::<Node<Double>>());
        // Too large for single precision.
        assert!(!is_single(&BvhStorage::new(1, |_| [DVec3::splat(1e39); 3], None)));
    }

    #[test]
    fn bounds_that_are_given_are_rounded_away_from_what_is_inside() {
        let single = triangles(64, |x| f64::from(x as f32));
        let given = |leaf: usize| [DVec3::splat(-0.1 * leaf as f64), DVec3::splat(0.1)];
        let boxes = BvhStorage::new(64, |t| single[t], Some(&given));
        assert!(is_single(&boxes));
        let [min, max] = dispatch!(Level::new(), simd => {
            let [min, max] = boxes.node(simd, 1, 0);
            [[0, 1, 2, 3, 4, 5, 6, 7].map(|lane| min.at(lane)), [max.at(0); LANES]]
        });
        for leaf in 0..LANES {
            let [low, high] = given(leaf);
            assert!(min[leaf].cmple(low).all() && min[leaf].abs_diff_eq(low, 1e-7));
            assert!(max[leaf].cmpge(high).all() && max[leaf].abs_diff_eq(high, 1e-7));
        }
    }
}
