//! Cutting polygons into triangles.
//!
//! Quadrilaterals are split along the better valid diagonal. Larger polygons are cut by ear clipping in the coordinate
//! plane onto which their projection is largest. Dropping a coordinate rounds nothing and the orientation tests are
//! exact (Shewchuk, *Adaptive precision floating-point arithmetic and fast robust geometric predicates*, 1997), so an
//! ear of a simple polygon always exists (Meisters, *Polygons have ears*, 1975) and is found.
//!
//! Clipping an ear can change only whether its two neighbours are ears, so there are at most `3 n` ear tests. Each test
//! searches for reflex corners inside the ear in a tree of bounding boxes, and visits only boxes that meet the ear.
//! There are few of them, even where corners are dense. A polygon that still needs more than [`STEPS_PER_CORNER`] steps
//! is triangulated as a polygon that is not simple, so that the time stays linear. This happens for long ears along
//! chains of corners that almost touch them.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};

use crate::index::as_u32;
use crate::measure::any_size::{orient2d, unit_sized_points};

/// Cuts polygons into triangles; keeps its working arrays between polygons.
#[derive(Default)]
pub struct Triangulator {
    points: Vec<DVec2>,
    corners: Vec<Corner>,
    queue: VecDeque<u32>,
    blockers: Blockers,
}

/// How well a polygon could be cut into triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Triangulation {
    /// The triangles cover the polygon, seen along its normal, without overlap.
    Proper,
    /// The polygon is not simple (it crosses itself or has no area): triangles may overlap, be
    /// reversed, or use a vertex twice.
    Fallback,
}

/// A corner of the rest of the polygon.
#[derive(Clone, Copy)]
struct Corner {
    previous: u32,
    next: u32,
    /// Whether the polygon turns left here.
    is_convex: bool,
    is_clipped: bool,
    is_queued: bool,
}

/// Which corners may be clipped; relaxed step by step when none is left.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Rule {
    /// Ears: the triangle turns left, its third side lies inside the polygon at both ends, and no
    /// other corner lies in it or on it.
    Ear,
    /// The triangle turns left and no other corner lies strictly inside.
    Touching,
    /// The triangle turns left.
    Convex,
    /// The three vertices are distinct.
    Distinct,
    /// Anything.
    Any,
}

impl Rule {
    fn relaxed(self) -> Self {
        match self {
            Self::Ear => Self::Touching,
            Self::Touching => Self::Convex,
            Self::Convex => Self::Distinct,
            Self::Distinct | Self::Any => Self::Any,
        }
    }
}

/// Number of times that a polygon may run out of corners to clip. Then the rest is clipped in any order, so
/// that no input takes quadratic time.
const MAX_RELAXATIONS: usize = 64;

impl Triangulator {
    /// Appends the `n - 2` triangles of a polygon, as corner numbers from `0` to `n - 1`.
    ///
    /// The polygon may be concave, not quite planar, with corners on straight sides, and may touch itself, as polygons
    /// do that are connected to their holes by bridges. `vertices` tells which corners are the same vertex; no triangle
    /// uses a vertex twice if that can be avoided. Polygons with fewer than three corners have no triangles.
    ///
    /// # Panics
    /// When there are fewer `vertices` than `positions`.
    pub fn triangulate(
        &mut self,
        positions: &[DVec3],
        vertices: &[u32],
        triangles: &mut Vec<[u32; 3]>,
    ) -> Triangulation {
        let (positions, _) = match positions.len() {
            0..=3 => (positions.into(), 1.0),
            _ => unit_sized_points(positions),
        };
        match *positions {
            [] | [_] | [_, _] => Triangulation::Proper,
            [_, _, _] => {
                triangles.push([0, 1, 2]);
                Triangulation::Proper
            }
            [a, b, c, d] if all_distinct(&vertices[..4]) => {
                let vertices = [vertices[0], vertices[1], vertices[2], vertices[3]];
                triangles.extend(split_quadrilateral([a, b, c, d], vertices));
                Triangulation::Proper
            }
            _ => self.clip_ears(&positions, vertices, triangles),
        }
    }

    fn clip_ears(
        &mut self,
        positions: &[DVec3],
        vertices: &[u32],
        triangles: &mut Vec<[u32; 3]>,
    ) -> Triangulation {
        self.start(positions);
        let mut left = positions.len() - self.clip_repeated(positions, triangles);
        self.classify();
        let mut rule = Rule::Ear;
        let mut worst = Rule::Ear;
        let mut relaxations = 0;
        let most_steps = STEPS_PER_CORNER * positions.len();
        while left > 2 {
            if self.blockers.steps > most_steps {
                rule = rule.max(Rule::Convex);
            }
            let Some(tip) = self.queue.pop_front() else {
                rule = rule.relaxed();
                if relaxations >= MAX_RELAXATIONS {
                    rule = rule.max(Rule::Distinct);
                }
                relaxations += 1;
                self.queue_all();
                continue;
            };
            let Corner { previous, next, .. } = self.corners[tip as usize];
            self.corners[tip as usize].is_queued = false;
            if self.corners[tip as usize].is_clipped || !self.may_clip(tip, vertices, rule) {
                continue;
            }
            triangles.push([previous, tip, next]);
            left -= 1;
            self.clip(tip);
            worst = worst.max(rule);
            if relaxations < MAX_RELAXATIONS {
                rule = Rule::Ear;
            }
        }
        if worst <= Rule::Touching { Triangulation::Proper } else { Triangulation::Fallback }
    }

    /// Sets up the ring of corners.
    fn start(&mut self, positions: &[DVec3]) {
        project(positions, &mut self.points);
        let n = as_u32(positions.len());
        self.corners.clear();
        self.corners.extend((0..n).map(|i| Corner {
            previous: if i == 0 { n - 1 } else { i - 1 },
            next: if i + 1 == n { 0 } else { i + 1 },
            is_convex: false,
            is_clipped: false,
            is_queued: false,
        }));
        self.queue.clear();
    }

    /// Clips corners at the same position as the next one, which makes triangles without area. Returns their number.
    fn clip_repeated(&mut self, positions: &[DVec3], triangles: &mut Vec<[u32; 3]>) -> usize {
        let mut clipped = 0;
        for tip in 0..as_u32(positions.len()) {
            let Corner { previous, next, .. } = self.corners[tip as usize];
            let is_repeated = positions[tip as usize] == positions[next as usize];
            if is_repeated && clipped + 2 < positions.len() {
                triangles.push([previous, tip, next]);
                self.clip(tip);
                clipped += 1;
            }
        }
        clipped
    }

    /// Separates convex corners from the others and queues all.
    fn classify(&mut self) {
        for i in 0..as_u32(self.corners.len()) {
            self.corners[i as usize].is_convex = self.turn_at(i) > 0.0;
        }
        self.blockers.collect(&self.points, &self.corners);
        self.queue_all();
    }

    fn queue_all(&mut self) {
        for i in 0..as_u32(self.corners.len()) {
            self.queue_corner(i);
        }
    }

    fn queue_corner(&mut self, i: u32) {
        let corner = &mut self.corners[i as usize];
        if !corner.is_clipped && !corner.is_queued {
            corner.is_queued = true;
            self.queue.push_back(i);
        }
    }

    /// Removes a corner from the ring and classifies its two neighbours again.
    fn clip(&mut self, tip: u32) {
        let Corner { previous, next, .. } = self.corners[tip as usize];
        self.corners[tip as usize].is_clipped = true;
        self.corners[previous as usize].next = next;
        self.corners[next as usize].previous = previous;
        for neighbour in [previous, next] {
            self.corners[neighbour as usize].is_convex = self.turn_at(neighbour) > 0.0;
            self.queue_corner(neighbour);
        }
    }

    /// Twice the signed area of the triangle with these corners.
    fn turn(&self, a: u32, b: u32, c: u32) -> f64 {
        let [a, b, c] = [a, b, c].map(|i| self.points[i as usize]);
        turn(a, b, c)
    }

    fn turn_at(&self, i: u32) -> f64 {
        let corner = self.corners[i as usize];
        self.turn(corner.previous, i, corner.next)
    }

    fn may_clip(&mut self, tip: u32, vertices: &[u32], rule: Rule) -> bool {
        let Corner { previous, next, is_convex, .. } = self.corners[tip as usize];
        let triangle = [previous, tip, next];
        match rule {
            Rule::Ear => {
                is_convex && self.third_side_is_inside(triangle) && !self.is_blocked(triangle, true)
            }
            Rule::Touching => is_convex && !self.is_blocked(triangle, false),
            Rule::Convex => is_convex,
            Rule::Distinct => all_distinct(&triangle.map(|i| vertices[i as usize])),
            Rule::Any => true,
        }
    }

    /// Whether the side from `c` to `a` starts into the interior of the polygon at both ends. This distinguishes
    /// corners at the same position, where the polygon touches itself.
    fn third_side_is_inside(&self, [a, b, c]: [u32; 3]) -> bool {
        let before = self.corners[a as usize].previous;
        let after = self.corners[c as usize].next;
        // At a reflex corner everything left of `ab` and `bc` is inside.
        let is_inside_at_a = self.turn(before, a, b) <= 0.0 || self.turn(before, a, c) > 0.0;
        let is_inside_at_c = self.turn(b, c, after) <= 0.0 || self.turn(a, c, after) > 0.0;
        before == c || is_inside_at_a && is_inside_at_c
    }

    /// Whether a reflex or straight corner lies in the triangle; on its sides too if `closed`. Corners at the position
    /// of a corner of the triangle do not count.
    fn is_blocked(&mut self, triangle: [u32; 3], closed: bool) -> bool {
        let [a, b, c] = triangle.map(|i| self.points[i as usize]);
        let points = &self.points;
        let corners = &self.corners;
        let is_live = |i: u32| {
            let corner = corners[i as usize];
            !corner.is_convex && !corner.is_clipped
        };
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let blocks = |i: u32| {
            let p = points[i as usize];
            if !(p.cmpge(low).all() && p.cmple(high).all()) {
                return false;
            }
            let least = turn(a, b, p).min(turn(b, c, p)).min(turn(c, a, p));
            (least > 0.0 || closed && least == 0.0) && p != a && p != b && p != c
        };
        self.blockers.any_in_triangle([a, b, c], points, is_live, blocks)
    }
}

fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    orient2d([a, b, c])
}

fn all_distinct(vertices: &[u32]) -> bool {
    vertices.iter().enumerate().all(|(i, vertex)| !vertices[..i].contains(vertex))
}

/// Projects a polygon onto the coordinate plane where its projection is largest, counter-clockwise.
fn project(positions: &[DVec3], points: &mut Vec<DVec2>) {
    let normal = newell_normal(positions);
    let size = normal.abs();
    let (x, y, height) = if size.x >= size.y && size.x >= size.z {
        (1, 2, normal.x)
    } else if size.y >= size.z {
        (2, 0, normal.y)
    } else {
        (0, 1, normal.z)
    };
    let (x, y) = if height < 0.0 { (y, x) } else { (x, y) };
    points.clear();
    points.extend(positions.iter().map(|p| DVec2::new(p[x], p[y])));
}

/// Twice the area vector of a polygon, relative to its first corner (Newell's method).
fn newell_normal(positions: &[DVec3]) -> DVec3 {
    let origin = positions[0];
    positions
        .windows(2)
        .map(|side| (side[0] - origin).cross(side[1] - origin))
        .fold(DVec3::ZERO, |sum, part| sum + part)
}

/// Splits a quadrilateral along a diagonal whose two triangles face the same way. If both diagonals do, the one that
/// satisfies the Delaunay criterion better is taken: the one with the larger sum of the cotangents of the two angles
/// opposite to it. Ties, such as rectangles, are split from the vertex with the smallest index, so that the result
/// depends neither on the first corner nor on the orientation of the face.
fn split_quadrilateral(p: [DVec3; 4], vertices: [u32; 4]) -> [[u32; 3]; 2] {
    let normal = |a: usize, b: usize, c: usize| (p[b] - p[a]).cross(p[c] - p[a]);
    let is_valid = |a: DVec3, b: DVec3| a.dot(b) > 0.0;
    let first = is_valid(normal(0, 1, 2), normal(0, 2, 3));
    let second = is_valid(normal(1, 2, 3), normal(1, 3, 0));
    let cotangent = |before: usize, at: usize, after: usize| {
        let (u, v) = (p[before] - p[at], p[after] - p[at]);
        u.dot(v) / u.cross(v).length()
    };
    let prefers_second = || {
        let opposite_first = cotangent(0, 1, 2) + cotangent(2, 3, 0);
        let opposite_second = cotangent(1, 2, 3) + cotangent(3, 0, 1);
        let advantage = opposite_second - opposite_first;
        // Rounding must not decide between equal diagonals; cotangents have no unit.
        if advantage.abs() > 1e-9 {
            advantage > 0.0
        } else {
            vertices[1].min(vertices[3]) < vertices[0].min(vertices[2])
        }
    };
    if (second && !first) || (second == first && prefers_second()) {
        [[0, 1, 3], [1, 2, 3]]
    } else {
        [[0, 1, 2], [0, 2, 3]]
    }
}

/// Limit of boxes and corners visited per corner of a polygon.
const STEPS_PER_CORNER: usize = 1024;

/// Corners in a leaf of the tree.
const LEAF: usize = 4;

/// An axis-aligned rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rectangle {
    low: DVec2,
    high: DVec2,
}

impl Rectangle {
    const EMPTY: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY };

    fn of(points: impl Iterator<Item = DVec2>) -> Self {
        points.fold(Self::EMPTY, |r, p| Self { low: r.low.min(p), high: r.high.max(p) })
    }

    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Whether the rectangle meets a triangle that turns left, up to rounding: it does not if one of them lies beyond a
    /// side of the other.
    fn meets(&self, [a, b, c]: [DVec2; 3]) -> bool {
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        if !(self.low.cmple(high).all() && low.cmple(self.high).all()) {
            return false;
        }
        // The corner of the rectangle that is farthest to the left of a side.
        [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
            let along = to - from;
            let x = if along.y < 0.0 { self.high.x } else { self.low.x };
            let y = if along.x < 0.0 { self.low.y } else { self.high.y };
            let (up, across) = (along.x * (y - from.y), along.y * (x - from.x));
            // Rounding must not hide a corner; NaN hides nothing.
            let is_right = up - across < -1e-14 * (up.abs() + across.abs());
            !is_right
        })
    }
}

/// The corners that can lie inside an ear: the reflex and straight ones, in a complete binary tree
/// of rectangles.
#[derive(Default)]
struct Blockers {
    /// The root first; the children of box i are 2i + 1 and 2i + 2.
    boxes: Vec<Rectangle>,
    /// The corners, leaf after leaf.
    items: Vec<u32>,
    /// Where the corners of each leaf start and end. Corners that are no longer live are moved to the end of their leaf
    /// and cut off.
    leaves: Vec<[u32; 2]>,
    /// Number of boxes and corners visited so far.
    steps: usize,
}

impl Blockers {
    fn collect(&mut self, points: &[DVec2], corners: &[Corner]) {
        let is_blocker = |i: &u32| {
            let corner = corners[*i as usize];
            !corner.is_convex && !corner.is_clipped
        };
        self.items.clear();
        self.items.extend((0..as_u32(points.len())).filter(is_blocker));
        self.steps = 0;
        let leaves = self.items.len().div_ceil(LEAF).next_power_of_two();
        self.leaves.clear();
        arrange(points, &mut self.items, 0, leaves, &mut self.leaves);
        self.boxes.clear();
        self.boxes.resize(2 * leaves - 1, Rectangle::EMPTY);
        for leaf in 0..leaves {
            self.boxes[leaves - 1 + leaf] = self.leaf_box(points, leaf);
        }
        for node in (0..leaves - 1).rev() {
            self.boxes[node] = self.boxes[2 * node + 1].union(self.boxes[2 * node + 2]);
        }
    }

    fn leaf_box(&self, points: &[DVec2], leaf: usize) -> Rectangle {
        let [start, end] = self.leaves[leaf];
        let items = &self.items[start as usize..end as usize];
        Rectangle::of(items.iter().map(|&i| points[i as usize]))
    }

    /// Whether any corner in a triangle blocks it. Drops corners that are no longer live from the leaves it visits.
    fn any_in_triangle(
        &mut self,
        triangle: [DVec2; 3],
        points: &[DVec2],
        is_live: impl Fn(u32) -> bool,
        blocks: impl Fn(u32) -> bool,
    ) -> bool {
        let inner = self.leaves.len() - 1;
        // One open node per level at most, besides the current one.
        let mut open = [0_usize; 64];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = open[count];
            self.steps += 1;
            if !self.boxes[node].meets(triangle) {
                continue;
            }
            if node < inner {
                open[count] = 2 * node + 2;
                open[count + 1] = 2 * node + 1;
                count += 2;
                continue;
            }
            let [start, mut end] = self.leaves[node - inner];
            let mut read = start;
            let mut blocked = false;
            while read < end && !blocked {
                let i = self.items[read as usize];
                self.steps += 1;
                if is_live(i) {
                    blocked = blocks(i);
                    read += 1;
                } else {
                    end -= 1;
                    self.items.swap(read as usize, end as usize);
                }
            }
            if end < self.leaves[node - inner][1] {
                self.leaves[node - inner][1] = end;
                self.shrink(points, node);
            }
            if blocked {
                return true;
            }
        }
        false
    }

    /// Recomputes the boxes of a leaf that lost corners and of its ancestors.
    fn shrink(&mut self, points: &[DVec2], leaf_node: usize) {
        let mut node = leaf_node;
        self.boxes[node] = self.leaf_box(points, node + 1 - self.leaves.len());
        while node > 0 {
            node = (node - 1) / 2;
            let both = self.boxes[2 * node + 1].union(self.boxes[2 * node + 2]);
            if self.boxes[node] == both {
                break;
            }
            self.boxes[node] = both;
        }
    }
}

/// Sorts corners by recursive splits along the wider direction, and returns where the leaves start and end.
fn arrange(
    points: &[DVec2],
    items: &mut [u32],
    start: usize,
    leaves: usize,
    ranges: &mut Vec<[u32; 2]>,
) {
    if leaves == 1 {
        ranges.push([as_u32(start), as_u32(start + items.len())]);
        return;
    }
    let middle = items.len() / 2;
    if items.len() > 1 {
        let around = Rectangle::of(items.iter().map(|&i| points[i as usize]));
        let extent = around.high - around.low;
        let axis = usize::from(extent.y > extent.x);
        let key = |i: u32| points[i as usize][axis];
        items.select_nth_unstable_by(middle, |&i, &j| key(i).total_cmp(&key(j)).then(i.cmp(&j)));
    }
    let (low, high) = items.split_at_mut(middle);
    arrange(points, low, start, leaves / 2, ranges);
    arrange(points, high, start + middle, leaves / 2, ranges);
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    /// The triangles of a polygon in the plane `z = x - y`.
    fn triangulate(polygon: &[DVec2], vertices: &[u32]) -> (Vec<[u32; 3]>, Triangulation) {
        let positions: Vec<DVec3> = polygon.iter().map(|p| p.extend(p.x - p.y)).collect();
        let mut triangles = Vec::new();
        let quality = Triangulator::default().triangulate(&positions, vertices, &mut triangles);
        (triangles, quality)
    }

    fn area(polygon: &[DVec2]) -> f64 {
        let next = polygon.iter().cycle().skip(1);
        polygon.iter().zip(next).map(|(p, q)| p.perp_dot(*q) / 2.0).sum()
    }

    /// Checks a triangulation without overlap: all triangles turn left and fill the area.
    fn check_proper(polygon: &[DVec2]) {
        let flat: Vec<DVec3> = polygon.iter().map(|p| p.extend(0.0)).collect();
        let vertices = crate::build::weld_exact(&flat);
        for reversed in [false, true] {
            let mut polygon = polygon.to_vec();
            let mut vertices = vertices.clone();
            if reversed {
                polygon.reverse();
                vertices.reverse();
            }
            let (triangles, quality) = triangulate(&polygon, &vertices);
            assert_eq!(quality, Triangulation::Proper);
            assert_eq!(triangles.len(), polygon.len() - 2);
            let sign = if reversed { -1.0 } else { 1.0 };
            let mut sum = 0.0;
            for triangle in &triangles {
                assert!(all_distinct(&triangle.map(|i| vertices[i as usize])));
                let part = area(&triangle.map(|i| polygon[i as usize]));
                assert!(part * sign > 0.0, "{triangle:?} of {} corners", polygon.len());
                sum += part;
            }
            let whole = area(&polygon);
            assert!((sum - whole).abs() <= 1e-9 * whole.abs(), "{sum} {whole}");
        }
    }

    fn points(coordinates: &[[f64; 2]]) -> Vec<DVec2> {
        coordinates.iter().copied().map(DVec2::from).collect()
    }

    #[test]
    fn concave_quadrilaterals_split_at_the_reflex_corner() {
        let arrow = points(&[[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]]);
        for start in 0..4 {
            let mut polygon = arrow.clone();
            polygon.rotate_left(start);
            check_proper(&polygon);
        }
        // A straight corner: the other diagonal would leave a triangle without area.
        check_proper(&points(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 3.0]]));
    }

    #[test]
    fn rectangles_split_the_same_way_wherever_they_start() {
        // A rectangle in the plane `z = x - y`.
        let square = points(&[[0.0, 0.0], [1.0, 1.0], [3.0, -1.0], [2.0, -2.0]]);
        for start in 0..4 {
            for reversed in [false, true] {
                let mut polygon = square.clone();
                let mut vertices = vec![7, 3, 9, 5];
                if reversed {
                    polygon.reverse();
                    vertices.reverse();
                }
                polygon.rotate_left(start);
                vertices.rotate_left(start);
                let (triangles, _) = triangulate(&polygon, &vertices);
                for triangle in triangles {
                    let triangle = triangle.map(|i| vertices[i as usize]);
                    assert!(triangle.contains(&3) && triangle.contains(&5));
                }
            }
        }
    }

    #[test]
    fn larger_polygons_are_filled() {
        // An L, with corners on straight sides.
        check_proper(&points(&[
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 1.5],
            [1.0, 2.0],
            [0.0, 2.0],
            [0.0, 1.0],
        ]));
        // A triangle with corners on its sides.
        check_proper(&points(&[
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [3.0, 0.0],
            [2.0, 1.0],
            [1.0, 2.0],
            [0.0, 3.0],
            [0.0, 1.0],
        ]));
        // A frame: the hole is connected by a bridge that is traversed twice.
        check_proper(&points(&[
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ]));
        // Two holes with bridges from the same corner.
        check_proper(&points(&[
            [0.0, 0.0],
            [9.0, 0.0],
            [9.0, 9.0],
            [0.0, 9.0],
            [0.0, 0.0],
            [1.0, 4.0],
            [1.0, 7.0],
            [4.0, 7.0],
            [1.0, 4.0],
            [0.0, 0.0],
            [4.0, 1.0],
            [5.0, 3.0],
            [7.0, 1.0],
            [4.0, 1.0],
        ]));
        // A seam into the interior.
        check_proper(&points(&[
            [0.0, 0.0],
            [2.0, 0.0],
            [1.0, 1.0],
            [2.0, 0.0],
            [2.0, 2.0],
            [0.0, 2.0],
        ]));
    }

    #[test]
    fn stars_and_spirals_of_many_corners_are_filled() {
        for n in [5, 6, 7, 50, 1000, 10_000] {
            let star = (0..n).map(|i| {
                let radius = if i % 2 == 0 { 2.0 } else { 1.0 + 0.3 * (i as f64).sin() };
                DVec2::from_angle(TAU * i as f64 / n as f64) * radius
            });
            check_proper(&star.collect::<Vec<_>>());
            let arm = |i: usize, width: f64| {
                let turns = 10.0 * i as f64 / n as f64;
                DVec2::from_angle(TAU * turns) * (1.0 + turns + width)
            };
            let outwards = (0..n).map(|i| arm(i, 0.5));
            let spiral = outwards.chain((0..n).rev().map(|i| arm(i, 0.0)));
            if n >= 1000 {
                check_proper(&spiral.collect::<Vec<_>>());
            }
            let comb = (0..n).map(|i| DVec2::new(i as f64, if i % 2 == 0 { 0.0 } else { 100.0 }));
            let comb = comb.chain([[n as f64, -1.0], [-1.0, -1.0]].map(DVec2::from));
            check_proper(&comb.map(|p| DVec2::new(-p.x, p.y)).collect::<Vec<_>>());
        }
    }

    /// A comb of long teeth along the diagonal, and a dense cluster of reflex corners inside their bounding boxes but
    /// outside the teeth.
    fn comb_beside_a_cluster(teeth: usize, cluster: usize) -> Vec<DVec2> {
        let mut polygon = points(&[[-20.0, -20.0], [20.0, -20.0], [20.0, 0.0]]);
        polygon.extend((0..cluster).map(|i| {
            let share = i as f64 / cluster as f64;
            let depth = if i % 2 == 0 { 0.0 } else { 1e-6 };
            DVec2::new(7.0 - 1e-3 * share, 3.0 - depth)
        }));
        for i in 0..teeth {
            let offset = |i: f64| DVec2::new(1.0, -1.0) * (0.5 - i / teeth as f64);
            polygon.push(offset(i as f64));
            polygon.push(offset(i as f64 + 0.5) + DVec2::splat(10.0));
        }
        polygon.extend(points(&[[-0.5, 0.5], [-20.0, 0.5]]));
        polygon
    }

    #[test]
    fn reflex_corners_in_a_cluster_take_no_quadratic_time() {
        check_proper(&comb_beside_a_cluster(50, 50));
        // Testing every tooth against every corner of the cluster would take 10^10 steps.
        let polygon = comb_beside_a_cluster(100_000, 100_000);
        let positions: Vec<DVec3> = polygon.iter().map(|p| p.extend(0.0)).collect();
        let vertices: Vec<u32> = (0..polygon.len() as u32).collect();
        let mut triangulator = Triangulator::default();
        let mut triangles = Vec::new();
        let quality = triangulator.triangulate(&positions, &vertices, &mut triangles);
        let per_corner = triangulator.blockers.steps as f64 / polygon.len() as f64;
        println!("{per_corner} steps per corner");
        assert_eq!(quality, Triangulation::Proper);
        assert!(per_corner < 200.0, "{per_corner}");
    }

    #[test]
    fn polygons_that_take_too_many_steps_are_cut_all_the_same() {
        // Corners on a slanted line, and ears that pass them closer than the corners are to each other.
        let n = 30_000;
        let chain = (0..n).map(|i| {
            let x = i as f64 / n as f64;
            DVec2::new(x, x + 1e-9 * (x * (1.0 - x)))
        });
        let spikes = (0..n).map(|i| {
            let height = 1e-8 + 1e-12 * i as f64;
            let x = if i % 2 == 0 { 1.0 } else { 0.0 };
            DVec2::new(x, x + height)
        });
        let polygon: Vec<DVec2> = chain.chain(spikes).collect();
        let positions: Vec<DVec3> = polygon.iter().map(|p| p.extend(0.0)).collect();
        let vertices: Vec<u32> = (0..polygon.len() as u32).collect();
        let mut triangulator = Triangulator::default();
        let mut triangles = Vec::new();
        let quality = triangulator.triangulate(&positions, &vertices, &mut triangles);
        assert_eq!(triangles.len(), polygon.len() - 2);
        let per_corner = triangulator.blockers.steps as f64 / polygon.len() as f64;
        println!("{quality:?} after {per_corner} steps per corner");
        // The last search in the tree may exceed the limit.
        assert!(per_corner < (STEPS_PER_CORNER + 4) as f64);
    }

    #[test]
    fn hopeless_polygons_end() {
        let crossed = points(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0], [-1.0, 1.0]]);
        let (triangles, _) = triangulate(&crossed, &[0, 1, 2, 3, 4]);
        assert_eq!(triangles.len(), 3);
        for n in [5_u32, 100_000] {
            let line: Vec<DVec2> = (0..n).map(|i| DVec2::new(f64::from(i), 0.0)).collect();
            let vertices: Vec<u32> = (0..n).collect();
            let (triangles, quality) = triangulate(&line, &vertices);
            assert_eq!((triangles.len(), quality), (n as usize - 2, Triangulation::Fallback));
            let (triangles, _) = triangulate(&vec![DVec2::ONE; n as usize], &vec![0; n as usize]);
            assert_eq!(triangles.len(), n as usize - 2);
            let rounds: Vec<u32> = (0..n).map(|i| i % 4).collect();
            let corners = points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
            let square: Vec<DVec2> = rounds.iter().map(|&i| corners[i as usize]).collect();
            let (triangles, _) = triangulate(&square, &rounds);
            assert_eq!(triangles.len(), n as usize - 2);
        }
    }

    #[test]
    fn repeated_corners_do_not_spoil_the_rest() {
        let polygon = points(&[[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [1.0, 2.0]]);
        let (triangles, quality) = triangulate(&polygon, &[4, 5, 5, 6]);
        assert_eq!(quality, Triangulation::Proper);
        let proper =
            triangles.iter().filter(|t| all_distinct(&t.map(|i| [4, 5, 5, 6][i as usize])));
        assert_eq!(proper.count(), 1);
    }
}
