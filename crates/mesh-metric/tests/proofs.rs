//! Certified bounds compared with exact arithmetic: every distance here is a quotient of integers.
#![allow(clippy::unwrap_used)]

use core::cmp::Ordering;

use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_metric::{
    CertifyOptions, Surface, closest_on_triangle, hausdorff_bounds, one_sided_bounds,
};
use num_bigint::BigInt;

/// In units of 2^-SCALE, all coordinates must be integers.
const SCALE: i32 = 200;

/// A finite number as an integer times a power of two.
fn parts(number: f64) -> (i64, i32) {
    let bits = number.to_bits();
    let exponent = ((bits >> 52) & 0x7FF) as i32;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let magnitude = if exponent == 0 { fraction } else { fraction | 1 << 52 };
    (if number < 0.0 { -magnitude } else { magnitude }, exponent.max(1) - 1075)
}

#[derive(Clone, Debug, PartialEq)]
struct Exact([BigInt; 3]);

impl Exact {
    fn new(point: DVec3) -> Self {
        Self(point.to_array().map(|coordinate| {
            let (integer, exponent) = parts(coordinate);
            let shift = exponent + SCALE;
            assert!(integer == 0 || shift >= 0, "{coordinate:e} is too fine");
            BigInt::from(integer) << shift.max(0)
        }))
    }

    fn sub(&self, other: &Self) -> Self {
        Self([0, 1, 2].map(|i| &self.0[i] - &other.0[i]))
    }

    fn dot(&self, other: &Self) -> BigInt {
        (0..3).map(|i| &self.0[i] * &other.0[i]).sum()
    }

    fn cross(&self, other: &Self) -> Self {
        Self(
            [(1, 2), (2, 0), (0, 1)]
                .map(|(i, j)| &self.0[i] * &other.0[j] - &self.0[j] * &other.0[i]),
        )
    }
}

/// A squared distance in squared units, as a quotient with a positive denominator.
#[derive(Clone, Debug)]
struct Squared {
    numerator: BigInt,
    denominator: BigInt,
}

impl Squared {
    fn compare(&self, other: &Self) -> Ordering {
        (&self.numerator * &other.denominator).cmp(&(&other.numerator * &self.denominator))
    }

    /// Compares the distance with a non-negative number.
    fn compare_root(&self, number: f64) -> Ordering {
        assert!(number >= 0.0 && number.is_finite());
        let (integer, exponent) = parts(number);
        let square = BigInt::from(integer) * integer;
        let shift = 2 * (exponent + SCALE);
        if shift >= 0 {
            self.numerator.cmp(&((square << shift) * &self.denominator))
        } else {
            (&self.numerator << -shift).cmp(&(square * &self.denominator))
        }
    }
}

fn to_segment(p: &Exact, from: &Exact, to: &Exact) -> Squared {
    let (along, offset) = (to.sub(from), p.sub(from));
    let (squared, at) = (along.dot(&along), offset.dot(&along));
    let zero = BigInt::from(0);
    if at <= zero {
        return Squared { numerator: offset.dot(&offset), denominator: BigInt::from(1) };
    }
    if at >= squared {
        let offset = p.sub(to);
        return Squared { numerator: offset.dot(&offset), denominator: BigInt::from(1) };
    }
    let across = along.cross(&offset);
    Squared { numerator: across.dot(&across), denominator: squared }
}

fn to_triangle(p: &Exact, [a, b, c]: &[Exact; 3]) -> Squared {
    let normal = b.sub(a).cross(&c.sub(a));
    let squared = normal.dot(&normal);
    let zero = BigInt::from(0);
    let inside = |from: &Exact, to: &Exact| normal.dot(&to.sub(from).cross(&p.sub(from))) >= zero;
    if squared > zero && inside(a, b) && inside(b, c) && inside(c, a) {
        let height = normal.dot(&p.sub(a));
        return Squared { numerator: &height * &height, denominator: squared };
    }
    let sides = [to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a)];
    sides.into_iter().min_by(Squared::compare).unwrap()
}

fn to_triangles(p: &Exact, triangles: &[[Exact; 3]]) -> Squared {
    triangles.iter().map(|triangle| to_triangle(p, triangle)).min_by(Squared::compare).unwrap()
}

struct Draw(SplitMix64);

impl Draw {
    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.0.symmetric(), self.0.symmetric(), self.0.symmetric())
    }

    /// A power of ten with an exponent between two.
    fn power(&mut self, low: f64, high: f64) -> f64 {
        10.0_f64.powf(low + (high - low) * self.0.uniform())
    }

    /// A triangle of length about 1. Its smallest angle, or two of its angles, have sines between 1e-8 and 1e-3.
    fn needle(&mut self) -> [DVec3; 3] {
        let (start, along) = (self.vector(), self.vector().normalize());
        let across = along.cross(self.vector()).normalize() * self.power(-8.0, -3.0);
        // The opposite corner lies over the side, over its end, or slightly beyond.
        let at = [self.0.uniform(), 1.0, 1.05, 0.02][self.0.bits() as usize % 4];
        let mut corners = [start, start + along, start + along * at + across];
        corners.rotate_left(self.0.bits() as usize % 3);
        corners
    }

    /// A point above, on or beside a triangle.
    fn near(&mut self, [a, b, c]: [DVec3; 3]) -> DVec3 {
        let (v, w) = (self.0.uniform(), self.0.uniform());
        let (v, w) = if v + w > 1.0 { (1.0 - v, 1.0 - w) } else { (v, w) };
        let stretch = if self.0.bits().is_multiple_of(4) { 1.2 } else { 1.0 };
        let height = [0.0, self.power(-12.0, -6.0), self.power(-6.0, 0.0)];
        let height = height[self.0.bits() as usize % 3];
        a + (b - a) * (v * stretch) + (c - a) * w + self.vector() * height
    }

    /// A position far from the origin, where coordinates have fewer digits for the shape.
    fn place(&mut self) -> DVec3 {
        let far = [0.0, 10.0, 1e4][self.0.bits() as usize % 3];
        far * self.vector()
    }
}

fn surface(triangles: &[[DVec3; 3]]) -> Surface {
    let indices: Vec<[u32; 3]> =
        (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Surface::from_triangles(triangles.as_flattened(), &indices).unwrap()
}

fn exact(triangles: &[[DVec3; 3]]) -> Vec<[Exact; 3]> {
    triangles.iter().map(|corners| corners.map(Exact::new)).collect()
}

/// The number of cases: `CURVMESH_PROOFS`, or a small number by default.
fn cases() -> u64 {
    std::env::var("CURVMESH_PROOFS").ok().and_then(|cases| cases.parse().ok()).unwrap_or(6000)
}

/// The distance to one triangle is largest at a corner, so it is known exactly.
#[test]
fn bounds_of_the_distance_to_a_needle_hold_exactly() {
    let mut plain = 0;
    for seed in 0..cases() {
        let mut draw = Draw(SplitMix64::new(seed));
        let place = draw.place();
        let needle = draw.needle();
        let near = [0; 3].map(|_| draw.near(needle) + place);
        let needle = needle.map(|corner| corner + place);
        let target = exact(&[needle]);
        let distances = near.map(|corner| to_triangles(&Exact::new(corner), &target));
        let farthest = distances.iter().max_by(|a, b| a.compare(b)).unwrap();
        let options = CertifyOptions { max_pieces: 64, ..CertifyOptions::default() };
        let bounds = one_sided_bounds(&surface(&[near]), &surface(&[needle]), &options);
        assert!(farthest.compare_root(bounds.upper).is_le(), "{seed}: {bounds:?} is too low");
        assert!(farthest.compare_root(bounds.lower).is_ge(), "{seed}: {bounds:?} is too high");
        // The ordinary distances, with twice the slack that the size alone requires.
        let size = needle.iter().map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
        let slack = 32.0 * f64::EPSILON * size;
        let distance = near.map(|corner| closest_on_triangle(corner, &needle).length());
        let distance = distance.into_iter().fold(0.0, f64::max);
        plain += u32::from(
            farthest.compare_root(distance + slack).is_gt()
                || farthest.compare_root((distance - slack).max(0.0)).is_lt(),
        );
    }
    // The test is effective: without the certified bounds, many distances are wrong.
    assert!(u64::from(plain) > cases() / 50, "{plain} of {}", cases());
}

/// Between several needles: no point is farther away than the upper bound, and the point of the lower bound is at least
/// that far away.
#[test]
fn bounds_between_needles_hold_exactly_at_every_point() {
    for seed in 0..cases() / 4 {
        let mut draw = Draw(SplitMix64::new(!seed));
        let place = draw.place();
        let needles = [0; 3].map(|_| draw.needle());
        let from: Vec<[DVec3; 3]> =
            (0..2).map(|i| [0; 3].map(|_| draw.near(needles[i]) + place)).collect();
        let to = needles.map(|needle| needle.map(|corner| corner + place));
        let (target, origin) = (exact(&to), exact(&from));
        let (from, to) = (surface(&from), surface(&to));
        let options = CertifyOptions {
            tolerance: draw.power(-12.0, -2.0),
            max_pieces: 2000,
            ..CertifyOptions::default()
        };
        let bounds = one_sided_bounds(&from, &to, &options);
        let at = to_triangles(&Exact::new(bounds.at), &target);
        assert!(at.compare_root(bounds.lower).is_ge(), "{seed}: {bounds:?} is too high");
        for [a, b, c] in &origin {
            // Corners and points between them, with weights that are multiples of a quarter; so the unit is divided by
            // four.
            for weights in [[4, 0, 0], [0, 4, 0], [0, 0, 4], [2, 1, 1], [1, 2, 1], [0, 1, 3]] {
                let point =
                    Exact([0, 1, 2].map(|i| {
                        &a.0[i] * weights[0] + &b.0[i] * weights[1] + &c.0[i] * weights[2]
                    }));
                let fine: Vec<[Exact; 3]> = target
                    .iter()
                    .map(|t| t.clone().map(|corner| Exact(corner.0.map(|x| x << 2))))
                    .collect();
                let mut distance = to_triangles(&point, &fine);
                distance.denominator <<= 4;
                let holds = distance.compare_root(bounds.upper).is_le();
                assert!(holds, "{seed}: {bounds:?} is too low");
            }
        }
        let both = hausdorff_bounds(&from, &to, &options);
        assert!(both.lower <= both.upper && both.upper >= bounds.lower);
    }
}

/// Whole triangles count as pieces. A fixed limit would stop the search on large surfaces before it starts.
#[test]
fn the_budget_grows_with_the_number_of_faces() {
    let cells = 40;
    let grid = |height: f64, bumps: f64| {
        let at = |i: usize| [(i % (cells + 1)) as f64, (i / (cells + 1)) as f64, height];
        let points: Vec<[f64; 3]> = (0..(cells + 1) * (cells + 1))
            .map(at)
            .map(|[x, y, z]| [x, y, z + bumps * (x + 2.0 * y).sin()])
            .collect();
        let triangles: Vec<[u32; 3]> = (0..cells * cells)
            .flat_map(|i| {
                let a = (i / cells * (cells + 1) + i % cells) as u32;
                let above = a + cells as u32 + 1;
                [[a, a + 1, above + 1], [a, above + 1, above]]
            })
            .collect();
        Surface::from_triangles(&points, &triangles).unwrap()
    };
    let (a, b) = (grid(0.0, 0.1), grid(1.0, 0.3));
    // A budget for the whole triangles only.
    let options = CertifyOptions {
        tolerance: 1e-6,
        max_pieces: a.triangle_count(),
        max_pieces_per_face: 0,
        limit: None,
    };
    assert!(!hausdorff_bounds(&a, &b, &options).converged);
    let default = CertifyOptions { max_pieces: options.max_pieces, ..CertifyOptions::default() };
    let per_face = CertifyOptions { tolerance: 1e-6, ..default };
    let bounds = hausdorff_bounds(&a, &b, &per_face);
    assert!(bounds.converged && bounds.upper - bounds.lower < 1.001e-6, "{bounds:?}");
    assert!(bounds.pieces > 2 * a.triangle_count());
}
