//! Early split clipping: long thin triangles get several small boxes (Ernst, Greiner 2007).
//!
//! The box of a long thin triangle across the axes is as wide as the triangle is long. Around the apex of a
//! finely divided cone, each point is in a large share of all boxes, and a query visits nearly all triangles.
//! There the tree contains each long triangle several times, each time with the box of one section. The
//! sections cover the triangle, so the closest point is found through one of them. Distances are measured to
//! the whole triangle, so the result is the same.

use glam::DVec3;
use mesh_core::as_u32;
use mesh_core::parallel;

/// Fewer triangles are never split.
const FEW: usize = 256;

/// Largest ratio of box surfaces to triangle areas without splitting.
const OVERLAP: f64 = 64.0;

/// Largest mean number of sections per triangle.
const PIECES: usize = 16;

/// Largest number of additional sections, which bounds the memory.
const MOST: usize = 1 << 20;

/// Section `number` of `of` sections of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Section {
    number: u16,
    of: u16,
}

/// All sections with their triangles, triangle by triangle; `None` if splitting is not worthwhile.
pub(crate) fn split_long_triangles(
    corners: impl Fn(usize) -> [DVec3; 3] + Sync,
    count: usize,
) -> Option<(Vec<u32>, Vec<Section>)> {
    if count < FEW {
        return None;
    }
    let sizes = |t: usize| [size_of_box(&corners(t)), doubled_area(&corners(t))];
    let add = |[b, a]: [f64; 2], [box_size, area]: [f64; 2]| [b + box_size, a + area];
    let [boxes, areas] = parallel::fold(count, [0.0; 2], sizes, add);
    // Also on overflow.
    if !(boxes > OVERLAP * areas && boxes.is_finite()) {
        return None;
    }
    // The sum of box surface / sections is minimal if sections are proportional to the root of the box surface.
    let root = |t: usize| {
        let [box_size, area] = sizes(t);
        (box_size - area).max(0.0).sqrt()
    };
    let roots = parallel::fold(count, 0.0, root, |a, b| a + b);
    let extra = MOST.min((PIECES - 1) * count) as f64;
    let (mut triangles, mut pieces) = (Vec::new(), Vec::new());
    for t in 0..count {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "1000 at most; NaN gives 0"
        )]
        let of = 1 + (extra * (root(t) / roots)).min(1000.0) as u16;
        for number in 0..of {
            triangles.push(as_u32(t));
            pieces.push(Section { number, of });
        }
    }
    Some((triangles, pieces))
}

impl Section {
    /// The bounds of the section between two chords from the longest side to the other two, widened for
    /// rounding.
    pub(crate) fn bounds(self, corners: &[DVec3; 3]) -> [DVec3; 2] {
        let [p, q, r] = along_longest(corners);
        let side = q - p;
        // Position of the third corner along the longest side; any position is valid, 0 stands for NaN.
        let along = (r - p).dot(side) / side.length_squared();
        let apex = if along > 0.0 { along.min(1.0) } else { 0.0 };
        let [from, to] = [self.number, self.number + 1].map(|n| f64::from(n) / f64::from(self.of));
        let across = |t: f64| {
            if t < apex {
                p.lerp(r, t / apex)
            } else if apex < 1.0 {
                r.lerp(q, (t - apex) / (1.0 - apex))
            } else {
                r
            }
        };
        let mut points = [p.lerp(q, from), p.lerp(q, to), across(from), across(to), across(to)];
        if from <= apex && apex <= to {
            points[4] = r;
        }
        let [low, high] = bounds_of(points.into_iter());
        let rounding = 8.0 * f64::EPSILON * low.abs().max(high.abs()).max_element();
        let found = [low - rounding, high + rounding];
        if found.iter().all(|p| p.is_finite()) { found } else { bounds_of(corners.iter().copied()) }
    }
}

/// The corners, so that the longest side runs from the first to the second, starting at the apex of a long thin
/// triangle. The two long sides have nearly the same length, and tiny moves change which is longer; the
/// sections must not jump then.
fn along_longest(&[a, b, c]: &[DVec3; 3]) -> [DVec3; 3] {
    let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| p.distance_squared(q));
    let ([p, q, r], [qr, rp]) = if ab >= bc && ab >= ca {
        ([a, b, c], [bc, ca])
    } else if bc >= ca {
        ([b, c, a], [ca, ab])
    } else {
        ([c, a, b], [ab, bc])
    };
    if qr > 4.0 * rp { [q, p, r] } else { [p, q, r] }
}

/// The smallest and the largest coordinates of points.
#[inline(always)]
pub(crate) fn bounds_of(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// Half the surface area of the bounding box.
fn size_of_box(corners: &[DVec3; 3]) -> f64 {
    let [low, high] = bounds_of(corners.iter().copied());
    let extent = high - low;
    extent.dot(DVec3::new(extent.y, extent.z, extent.x))
}

/// Twice the area of a triangle: a lower bound of half the surface of its box in any position.
fn doubled_area([a, b, c]: &[DVec3; 3]) -> f64 {
    (*b - *a).cross(*c - *a).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::SplitMix64;

    fn random_point(random: &mut SplitMix64) -> DVec3 {
        DVec3::new(random.symmetric(), random.symmetric(), random.symmetric())
    }

    #[test]
    fn every_point_of_a_triangle_is_in_a_piece_of_it() {
        let mut random = SplitMix64::new(1);
        for round in 0..2_000 {
            let [a, b, mut c] = [(); 3].map(|()| 1e3 * random_point(&mut random));
            match round % 4 {
                0 => c = a,
                1 => c = a.lerp(b, 1.5 * random.symmetric()),
                2 => c = a + 1e-9 * random_point(&mut random),
                _ => {}
            }
            let of = 1 + (19.0 * random.uniform()) as u16;
            let pieces = (0..of).map(|number| Section { number, of }.bounds(&[a, b, c]));
            let pieces: Vec<_> = pieces.collect();
            for _ in 0..20 {
                let [u, v] = [random.uniform(), random.uniform()];
                let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
                for [u, v] in [[u, v], [0.0, v], [u, 0.0], [u, 1.0 - u], [1.0, 0.0]] {
                    let point = a + u * (b - a) + v * (c - a);
                    // The point itself is rounded.
                    let near = |[low, high]: &[DVec3; 2]| {
                        point.clamp(*low, *high).distance(point) <= 1e-12
                    };
                    assert!(pieces.iter().any(near), "{round}: {point} of {a} {b} {c}");
                }
            }
        }
    }

    /// The corners of a cone with this many faces.
    fn cone(faces: usize) -> impl Fn(usize) -> [DVec3; 3] {
        let rim = move |i: usize| {
            let angle = core::f64::consts::TAU * i as f64 / faces as f64;
            DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        move |t| [DVec3::Z, rim(t), rim(t + 1)]
    }

    #[test]
    fn boxes_of_needles_become_small() {
        let faces = 20_000;
        let corners = cone(faces);
        let (triangles, pieces) = split_long_triangles(&corners, faces).unwrap();
        assert!(triangles.len() <= PIECES * faces);
        let around = |point: DVec3| {
            let boxes = triangles.iter().zip(&pieces);
            let boxes = boxes.map(|(&t, piece)| piece.bounds(&corners(t as usize)));
            boxes.filter(|[low, high]| point.clamp(*low, *high) == point).count()
        };
        let around_whole = |point: DVec3| {
            let boxes = (0..faces).map(|t| bounds_of(corners(t).into_iter()));
            boxes.filter(|[low, high]| point.clamp(*low, *high) == point).count()
        };
        for t in [faces / 8, faces / 3, 7 * faces / 10] {
            let [a, b, c] = corners(t);
            let point = (a + 1.5 * b + 1.5 * c) / 4.0;
            let [before, after] = [around_whole(point), around(point)];
            assert!(10 * after < before, "{before} {after}");
        }
    }

    #[test]
    fn pieces_stay_where_they_are_when_the_other_long_side_becomes_the_longest() {
        let mut random = SplitMix64::new(2);
        for round in 0..1000 {
            let tip = random_point(&mut random) - DVec3::X;
            let [a, b] = [(); 2].map(|()| DVec3::X + 1e-3 * random_point(&mut random));
            let mut corners = [tip, a, b];
            corners.rotate_left(round % 3);
            // The two long sides are swapped.
            let mirrored = corners.map(|corner| match corner {
                corner if corner == a => b,
                corner if corner == b => a,
                tip => tip,
            });
            for number in 0..16 {
                let piece = Section { number, of: 16 };
                let [before, after] = [&corners, &mirrored].map(|corners| {
                    let [low, high] = piece.bounds(corners);
                    0.5 * (low + high)
                });
                assert!(before.distance(after) < 0.01, "{round} {number}: {before} {after}");
            }
        }
    }

    #[test]
    fn usual_triangles_stay_whole() {
        let grid = |t: usize| {
            let at = |x: usize, y: usize| DVec3::new(x as f64, y as f64, ((x * y) as f64).sin());
            let (x, y) = (t % 100, t / 100);
            [at(x, y), at(x + 1, y), at(x, y + 1)]
        };
        assert!(split_long_triangles(grid, 10_000).is_none());
        // Needles along an axis, few needles, and sizes that overflow.
        assert!(
            split_long_triangles(|t| grid(t).map(|p| p * DVec3::new(1e6, 1.0, 0.0)), 10_000)
                .is_none()
        );
        assert!(split_long_triangles(cone(200), 200).is_none());
        assert!(split_long_triangles(|t| cone(5000)(t).map(|p| p * 1e200), 5000).is_none());
    }
}
