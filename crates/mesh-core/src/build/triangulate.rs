//! Cutting polygons into triangles.
//!
//! Quadrilaterals are split along the better valid diagonal, larger polygons by ear clipping in the
//! coordinate plane onto which their projection is largest. Dropping a coordinate rounds nothing
//! and the orientation tests are exact (Shewchuk, *Adaptive precision floating-point arithmetic and
//! fast robust geometric predicates*, 1997), so a simple polygon always has an ear (Meisters,
//! *Polygons have ears*, 1975) and it is found.
//!
//! Clipping an ear changes at most whether its two neighbours are ears, so there are at most `3 n`
//! ear tests. Each looks at the reflex corners inside the bounding box of the ear, found through a
//! grid. This is close to linear where neighbouring corners are close together, about `n^1.5` for
//! long thin spikes, and `O(n r)` with `r` reflex corners at worst.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};
use robust::{Coord, orient2d};

/// Cuts polygons into triangles; keeps its working arrays from one polygon to the next.
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

/// A corner of what is left of the polygon.
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

/// After so many times of running out of corners, a polygon is beyond help and the rest is clipped
/// in any order, so that no input takes quadratic time for lack of ears.
const MAX_RELAXATIONS: usize = 64;

impl Triangulator {
    /// Appends the `n - 2` triangles of a polygon, as corner numbers from `0` to `n - 1`.
    ///
    /// The polygon may be concave, need not be quite planar, may have corners on straight sides,
    /// and may touch itself, as polygons do that reach their holes through bridges. `vertices` says
    /// which corners are the same vertex; as long as the polygon leaves a choice, no triangle has a
    /// vertex twice. Polygons with fewer than three corners have no triangles.
    ///
    /// # Panics
    /// When there are fewer `vertices` than `positions`.
    pub fn triangulate(
        &mut self,
        positions: &[DVec3],
        vertices: &[u32],
        triangles: &mut Vec<[u32; 3]>,
    ) -> Triangulation {
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
            _ => self.clip_ears(positions, vertices, triangles),
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
        while left > 2 {
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
        let n = positions.len() as u32;
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

    /// Clips corners at the position of the next one, which leaves triangles of no area, and
    /// returns how many.
    fn clip_repeated(&mut self, positions: &[DVec3], triangles: &mut Vec<[u32; 3]>) -> usize {
        let mut clipped = 0;
        for tip in 0..positions.len() as u32 {
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

    /// Tells convex corners from the others and queues all.
    fn classify(&mut self) {
        for i in 0..self.corners.len() as u32 {
            self.corners[i as usize].is_convex = self.turn_at(i) > 0.0;
        }
        self.blockers.collect(&self.points, &self.corners);
        self.queue_all();
    }

    fn queue_all(&mut self) {
        for i in 0..self.corners.len() as u32 {
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

    /// Removes a corner from the ring and looks at its two neighbours anew.
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

    /// Twice the signed area of the triangle of three corners.
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

    /// Whether the side from `c` to `a` starts into the interior of the polygon at both ends. This
    /// is what tells apart corners at the same position, where the polygon touches itself.
    fn third_side_is_inside(&self, [a, b, c]: [u32; 3]) -> bool {
        let before = self.corners[a as usize].previous;
        let after = self.corners[c as usize].next;
        // At a reflex corner everything left of `ab` and `bc` is inside.
        let is_inside_at_a = self.turn(before, a, b) <= 0.0 || self.turn(before, a, c) > 0.0;
        let is_inside_at_c = self.turn(b, c, after) <= 0.0 || self.turn(a, c, after) > 0.0;
        before == c || is_inside_at_a && is_inside_at_c
    }

    /// Whether a reflex or straight corner lies in the triangle; on its sides too if `closed`.
    /// Corners at the positions of the triangle's own do not count.
    fn is_blocked(&mut self, triangle: [u32; 3], closed: bool) -> bool {
        let [a, b, c] = triangle.map(|i| self.points[i as usize]);
        let points = &self.points;
        let corners = &self.corners;
        let is_live = |i: u32| {
            let corner = corners[i as usize];
            !corner.is_convex && !corner.is_clipped
        };
        let blocks = |i: u32| {
            let p = points[i as usize];
            let least = turn(a, b, p).min(turn(b, c, p)).min(turn(c, a, p));
            (least > 0.0 || closed && least == 0.0) && p != a && p != b && p != c
        };
        self.blockers.any_in_box(a.min(b).min(c), a.max(b).max(c), points, is_live, blocks)
    }
}

fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, c)
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

/// Splits a quadrilateral along a diagonal whose two triangles face the same way. If both do, the
/// one that satisfies the Delaunay criterion better is taken: the one with the larger sum of the
/// cotangents of the two angles opposite it. Ties, such as rectangles, are split from the vertex
/// with the smallest index, so that it does not matter at which corner a face starts, nor which way
/// it runs.
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

/// The corners that can lie inside an ear: the reflex and straight ones, in a uniform grid.
#[derive(Default)]
struct Blockers {
    low: DVec2,
    /// Cells per unit of length.
    scale: DVec2,
    columns: usize,
    rows: usize,
    /// Where each cell starts in `items`, and where its live items end.
    starts: Vec<u32>,
    ends: Vec<u32>,
    items: Vec<u32>,
}

impl Blockers {
    fn collect(&mut self, points: &[DVec2], corners: &[Corner]) {
        let is_blocker = |i: &u32| {
            let corner = corners[*i as usize];
            !corner.is_convex && !corner.is_clipped
        };
        let blockers = || (0..points.len() as u32).filter(is_blocker);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for i in blockers() {
            low = low.min(points[i as usize]);
            high = high.max(points[i as usize]);
        }
        let count = blockers().count();
        // About one blocker to a cell; a handful needs no grid.
        let resolution = if count <= 16 { 1 } else { (count as f64).sqrt().ceil() as usize };
        (self.columns, self.rows, self.low) = (resolution, resolution, low);
        let size = high - low;
        let cells = resolution as f64;
        let per_unit = |length: f64| if length > 0.0 { cells / length } else { 0.0 };
        self.scale = DVec2::new(per_unit(size.x), per_unit(size.y));

        self.starts.clear();
        self.starts.resize(resolution * resolution + 1, 0);
        for i in blockers() {
            let cell = self.cell(points[i as usize]);
            self.starts[cell + 1] += 1;
        }
        for cell in 1..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
        self.ends.clear();
        self.ends.extend_from_slice(&self.starts[..resolution * resolution]);
        self.items.clear();
        self.items.resize(count, 0);
        for i in blockers() {
            let cell = self.cell(points[i as usize]);
            self.items[self.ends[cell] as usize] = i;
            self.ends[cell] += 1;
        }
    }

    /// Column and row of a position; positions outside the grid count to its border.
    fn column_and_row(&self, p: DVec2) -> (usize, usize) {
        let offset = (p - self.low) * self.scale;
        let column = (offset.x as usize).min(self.columns - 1);
        let row = (offset.y as usize).min(self.rows - 1);
        (column, row)
    }

    fn cell(&self, p: DVec2) -> usize {
        let (column, row) = self.column_and_row(p);
        row * self.columns + column
    }

    /// Whether any corner in a box blocks. Corners that are no longer live are forgotten on the
    /// way.
    fn any_in_box(
        &mut self,
        low: DVec2,
        high: DVec2,
        points: &[DVec2],
        is_live: impl Fn(u32) -> bool,
        blocks: impl Fn(u32) -> bool,
    ) -> bool {
        let (first_column, first_row) = self.column_and_row(low);
        let (last_column, last_row) = self.column_and_row(high);
        for row in first_row..=last_row {
            for cell in row * self.columns + first_column..=row * self.columns + last_column {
                let mut read = self.starts[cell] as usize;
                while read < self.ends[cell] as usize {
                    let i = self.items[read];
                    if !is_live(i) {
                        self.ends[cell] -= 1;
                        self.items[read] = self.items[self.ends[cell] as usize];
                        continue;
                    }
                    let p = points[i as usize];
                    if p.cmpge(low).all() && p.cmple(high).all() && blocks(i) {
                        return true;
                    }
                    read += 1;
                }
            }
        }
        false
    }
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
        // A frame: the hole is reached through a bridge that is walked twice.
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
