//! Needles in pieces, so that their boxes do not cover everything.
//!
//! The box round a long thin triangle that lies across the axes is as wide as the needle is long.
//! Where very many of them lie side by side, as round the apex of a finely divided cone, each point is
//! in a large share of all boxes, and a query comes close to looking at every triangle. There the tree
//! has each needle several times, every time with the box round one piece of it only. The pieces
//! together cover the needle, so the closest point is found in one of them; and as the needle as a
//! whole is measured, it is the same point.

use glam::DVec3;
use mesh_core::parallel;

/// Fewer triangles are looked at quickly however their boxes lie.
const FEW: usize = 256;

/// The most that all boxes together may be larger than all triangles: needles are left whole below.
const OVERLAP: f64 = 64.0;

/// The most pieces per triangle in the mean.
const PIECES: usize = 16;

/// The most pieces beyond one per triangle, which bounds the memory.
const MOST: usize = 1 << 20;

/// One of so many pieces of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Section {
    number: u16,
    of: u16,
}

/// Every piece with its triangle, triangle by triangle; `None` where all triangles are best left whole.
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
    // Also where a size is beyond what numbers hold.
    if !(boxes > OVERLAP * areas && boxes.is_finite()) {
        return None;
    }
    // The sum of box / pieces is least when the pieces go with the root of the box.
    let root = |t: usize| {
        let [box_size, area] = sizes(t);
        (box_size - area).max(0.0).sqrt()
    };
    let roots = parallel::fold(count, 0.0, root, |a, b| a + b);
    let extra = MOST.min((PIECES - 1) * count) as f64;
    let (mut triangles, mut pieces) = (Vec::new(), Vec::new());
    for t in 0..count {
        let of = 1 + (extra * (root(t) / roots)).min(1000.0) as u16;
        for number in 0..of {
            triangles.push(t as u32);
            pieces.push(Section { number, of });
        }
    }
    Some((triangles, pieces))
}

impl Section {
    /// The bounds of the piece: what lies between two chords from the longest side to the other two,
    /// and rounding.
    pub(crate) fn bounds(self, corners: &[DVec3; 3]) -> [DVec3; 2] {
        let [p, q, r] = along_longest(corners);
        let side = q - p;
        // Where the third corner is along the longest side; any place will do, 0 for one that is not a
        // number.
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

/// The corners, with the longest side from the first to the second, and from the tip where there is one.
/// Two sides of a needle are about as long as each other, and which of them is longer changes with the
/// slightest move; its pieces have to stay where they are.
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

/// The smallest and the largest coordinates.
#[inline(always)]
pub(crate) fn bounds_of(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// Half the surface of the bounding box, which is about how large the box looks.
fn size_of_box(corners: &[DVec3; 3]) -> f64 {
    let [low, high] = bounds_of(corners.iter().copied());
    let extent = high - low;
    extent.dot(DVec3::new(extent.y, extent.z, extent.x))
}

/// How large the box of the triangle is at least, whichever way it lies.
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

    /// The corners of a cone with so many faces.
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
            // The two long sides change places.
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
        // Needles along an axis, few needles, and sizes beyond what numbers hold.
        assert!(
            split_long_triangles(|t| grid(t).map(|p| p * DVec3::new(1e6, 1.0, 0.0)), 10_000)
                .is_none()
        );
        assert!(split_long_triangles(cone(200), 200).is_none());
        assert!(split_long_triangles(|t| cone(5000)(t).map(|p| p * 1e200), 5000).is_none());
    }
}
