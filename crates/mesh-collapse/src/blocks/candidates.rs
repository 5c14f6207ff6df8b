//! Costs of edge collapses, four in parallel, as far as quadrics determine them.

use fearless_simd::f64x4;
use fearless_simd::prelude::*;
use glam::DVec3;

use crate::blocks::block_vertex::BlockVertex;
use crate::blocks::lanes::{LANES, Row, Vectors, columns};
use crate::geometry::quadric::DAMPING;

/// The largest accepted distance from the midpoint of an edge, in edge lengths.
pub(super) const FARTHEST: f64 = 10.0;

/// A term relative to the fourth power of the edge length. It is so small that it decides only between edges whose cost
/// is rounding error.
pub(super) const TIE: f64 = 1e-12;

/// The best positions of the remaining vertices of four edges, and their costs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidates {
    /// Positions relative to the midpoint of each edge, by coordinate.
    places: [Row; 3],
    pub(super) costs: Row,
}

impl Candidates {
    #[inline(always)]
    pub(super) fn place(&self, lane: usize) -> DVec3 {
        let [x, y, z] = &self.places;
        DVec3::new(x[lane], y[lane], z[lane])
    }
}

/// One end of each of four edges.
struct Ends<S: Simd> {
    position: Vectors<S>,
    matrix: Matrices<S>,
    linear: Vectors<S>,
    constant: f64x4<S>,
}

/// Four symmetric matrices.
#[derive(Clone, Copy)]
struct Matrices<S: Simd> {
    diagonal: Vectors<S>,
    mixed: Vectors<S>,
}

impl<S: Simd> Ends<S> {
    #[inline(always)]
    fn load(simd: S, vertices: &[BlockVertex], ends: [u32; LANES]) -> Self {
        let [a, b, c, d] = ends;
        let [a, b] = [&vertices[a as usize], &vertices[b as usize]];
        let [c, d] = [&vertices[c as usize], &vertices[d as usize]];
        let place = [&a.place(), &b.place(), &c.place(), &d.place()];
        let position = Vectors::of(columns(simd, place));
        let [a, b, c, d] = [a.quadric_rows(), b.quadric_rows(), c.quadric_rows(), d.quadric_rows()];
        let diagonal = columns(simd, [&a[0], &b[0], &c[0], &d[0]]);
        let mixed = columns(simd, [&a[1], &b[1], &c[1], &d[1]]);
        let linear = columns(simd, [&a[2], &b[2], &c[2], &d[2]]);
        let constant = diagonal[3];
        let matrix = Matrices { diagonal: Vectors::of(diagonal), mixed: Vectors::of(mixed) };
        Self { position, matrix, linear: Vectors::of(linear), constant }
    }
}

impl<S: Simd> Matrices<S> {
    #[inline(always)]
    fn times(&self, v: Vectors<S>) -> Vectors<S> {
        let Self { diagonal: d, mixed: m } = *self;
        Vectors {
            x: d.x * v.x + m.z * v.y + m.y * v.z,
            y: m.z * v.x + d.y * v.y + m.x * v.z,
            z: m.y * v.x + m.x * v.y + d.z * v.z,
        }
    }
}

/// The best positions for four edges, without any knowledge of the faces: the minimum of the sum of both quadrics, or
/// the best of the midpoint and the ends if the minimum is too far away. With `is_marginal`, errors that the ends have
/// accumulated cost nothing.
#[inline(always)]
pub(super) fn candidates<S: Simd>(
    simd: S,
    vertices: &[BlockVertex],
    ends: &[[u32; 2]; LANES],
    is_marginal: bool,
) -> Candidates {
    let [[a0, b0], [a1, b1], [a2, b2], [a3, b3]] = *ends;
    let a = Ends::load(simd, vertices, [a0, a1, a2, a3]);
    let b = Ends::load(simd, vertices, [b0, b1, b2, b3]);
    let (zero, one, two) =
        (f64x4::splat(simd, 0.0), f64x4::splat(simd, 1.0), f64x4::splat(simd, 2.0));
    let half = (b.position - a.position) * f64x4::splat(simd, 0.5);
    let squared_half = half.squared();
    // As in `Quadric::joined`: the sum about the midpoint.
    let (diagonal, mixed) =
        (a.matrix.diagonal + b.matrix.diagonal, a.matrix.mixed + b.matrix.mixed);
    let matrix = Matrices { diagonal, mixed };
    let difference = Matrices {
        diagonal: a.matrix.diagonal - b.matrix.diagonal,
        mixed: a.matrix.mixed - b.matrix.mixed,
    };
    let linear = a.linear + b.linear + difference.times(half);
    let made = a.constant + b.constant;
    let slope = (a.linear - b.linear) * two;
    let constant = made + half.dot(matrix.times(half) + slope);

    // As in `Symmetric3::factors`.
    let (d, m) = (diagonal, mixed);
    let damping = (d.x + d.y + d.z) * DAMPING;
    let least_pivot = damping * 0.25;
    let p0 = d.x + damping;
    let r0 = one / p0;
    let (l10, l20) = (m.z * r0, m.y * r0);
    let p1 = d.y + damping - l10 * m.z;
    let r1 = one / p1;
    let below = m.x - l10 * m.y;
    let l21 = below * r1;
    let p2 = d.z + damping - l20 * m.y - l21 * below;
    let r2 = one / p2;
    let is_sound = p0.simd_gt(zero) & p1.simd_gt(least_pivot) & p2.simd_gt(least_pivot);
    let y1 = l10 * linear.x - linear.y;
    let y2 = l20 * linear.x - linear.z - l21 * y1;
    let z = y2 * r2;
    let y = y1 * r1 - l21 * z;
    let x = -linear.x * r0 - l10 * y - l20 * z;

    let mut place = Vectors { x, y, z };
    let farthest = squared_half * (4.0 * FARTHEST * FARTHEST);
    let is_near = is_sound & place.squared().simd_le(farthest);
    let twice = linear * two;
    let rising = matrix.times(place) + twice;
    let mut value = place.dot(rising) + constant;
    if !is_near.all_true() {
        let middle = Vectors::splat(simd, DVec3::ZERO);
        let (first, second) = (middle - half, half);
        let at_first = first.dot(matrix.times(first) + twice) + constant;
        let at_second = second.dot(matrix.times(second) + twice) + constant;
        let is_first = at_first.simd_lt(constant);
        let (best, least) =
            (Vectors::select(is_first, first, middle), is_first.select(at_first, constant));
        let is_second = at_second.simd_lt(least);
        let (best, least) =
            (Vectors::select(is_second, second, best), is_second.select(at_second, least));
        place = Vectors::select(is_near, place, best);
        value = is_near.select(value, least);
    }
    let squared_length = squared_half * 4.0;
    let tie = squared_length * squared_length * TIE;
    let made = if is_marginal { made } else { zero };
    let cost = (value - made).max_precise(zero) + tie;
    let places = [place.x.to_array(), place.y.to_array(), place.z.to_array()];
    Candidates { places, costs: cost.to_array() }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use mesh_core::SplitMix64;

    use super::*;
    use crate::blocks::lanes::levels;
    use crate::geometry::quadric::Quadric;

    /// Vertices with quadrics of this many planes each. With one or two planes the minimum is not unique.
    fn vertices(count: usize, planes: usize) -> Vec<BlockVertex> {
        let mut random = SplitMix64::new(planes as u64);
        let mut number = || 2.0 * random.uniform() - 1.0;
        let mut vector = || DVec3::new(number(), number(), number());
        let mut vertex = |_| {
            let mut quadric = Quadric::default();
            for _ in 0..planes {
                let (normal, along) = (vector(), vector());
                quadric += Quadric::plane(normal, 0.1 * along.x, 0.5 + 0.2 * along.y);
            }
            BlockVertex::new(3.0 * vector(), &quadric)
        };
        (0..count).map(&mut vertex).collect()
    }

    fn place_and_cost(
        vertices: &[BlockVertex],
        [a, b]: [u32; 2],
        is_marginal: bool,
    ) -> (DVec3, f64) {
        let [a, b] = [&vertices[a as usize], &vertices[b as usize]];
        let half = 0.5 * (b.position - a.position);
        let joined = a.quadric().joined(&b.quadric(), half);
        let near = 4.0 * FARTHEST * FARTHEST * half.length_squared();
        let best = joined.minimizer(None).filter(|x| x.length_squared() <= near);
        let best = best.unwrap_or_else(|| {
            let places = [DVec3::ZERO, -half, half];
            places
                .into_iter()
                .reduce(|a, b| if joined.value(b) < joined.value(a) { b } else { a })
                .unwrap()
        });
        let made = a.quadric().constant + b.quadric().constant;
        let cost = joined.value(best) - if is_marginal { made } else { 0.0 };
        (best, cost.max(0.0) + TIE * (4.0 * half.length_squared()).powi(2))
    }

    #[test]
    fn four_at_once_are_four_one_by_one_with_the_same_bits_everywhere() {
        let mut far = 0;
        for planes in [0, 1, 2, 3, 8] {
            let vertices = vertices(80, planes);
            for (first, is_marginal) in (0..76).zip([false, true].into_iter().cycle()) {
                let ends = [0, 1, 2, 3].map(|i| [first + i, (7 * first + 3 * i + 5) % 80]);
                let all = levels().into_iter().map(
                    |level| dispatch!(level, simd => candidates(simd, &vertices, &ends, is_marginal)),
                );
                let all: Vec<Candidates> = all.collect();
                let bits = |candidates: &Candidates| {
                    let rows = [
                        candidates.places[0],
                        candidates.places[1],
                        candidates.places[2],
                        candidates.costs,
                    ];
                    rows.map(|row| row.map(f64::to_bits))
                };
                assert!(all.iter().all(|candidates| bits(candidates) == bits(&all[0])));
                for (lane, ends) in ends.into_iter().enumerate() {
                    let (x, cost) = place_and_cost(&vertices, ends, is_marginal);
                    let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * (1.0 + b.abs());
                    assert!(close(all[0].costs[lane], cost), "{planes} {ends:?} {cost}");
                    let is_far = all[0].place(lane).distance(x) > 1e-3;
                    far += usize::from(is_far && planes > 2);
                }
            }
        }
        assert_eq!(far, 0);
    }
}
