//! Numbers that the Hausdorff distance is proved to lie between.
//!
//! The one-sided distance h(A, B) is the largest distance to B of any point of A. A point of A
//! gives a lower bound. A piece T of a triangle of A gives upper bounds:
//!
//! - the distance to one triangle t of B is a convex function, so that on T it is largest at a
//!   corner: no point of T is farther from B than the farthest corner of T is from t;
//! - no point of T is farther from B than its centre is, plus the radius of T about that centre.
//!
//! Pieces whose upper bound exceeds the lower bound of the whole by more than the tolerance are
//! divided, round by round, until there are none (compare Tang, Lee, Kim 2009 and Kang, Kyung, Yoon,
//! Kim 2018). Those that are much larger than the triangle below their centre are cut into four. Of
//! the others, what lies over that triangle is cut out and done with. Without that, where two
//! surfaces nearly coincide, pieces along every edge would have to become as small as the distance
//! that is to be proved.

use glam::DVec3;

use crate::blocks::in_blocks;
use crate::bvh::Nearest;
use crate::closest::closest_on_triangle;
use crate::surface::Surface;

/// When to stop; see [`hausdorff_bounds`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CertifyOptions {
    /// How far apart the bounds may be, in model units.
    pub tolerance: f64,
    /// How many pieces of triangles may be looked at, for each direction. At the limit the bounds
    /// hold, but are farther apart than the tolerance.
    pub max_pieces: usize,
    /// When only it matters whether the distance is at most this: the search ends as soon as one
    /// of the bounds tells.
    pub limit: Option<f64>,
}

impl Default for CertifyOptions {
    fn default() -> Self {
        Self { tolerance: 0.0, max_pieces: 20_000_000, limit: None }
    }
}

impl CertifyOptions {
    /// Pieces that are not farther away than this need no cutting.
    fn bar(&self, lower: f64, slack: f64) -> f64 {
        // Once more the slack, so that adding it does not round to more than the limit.
        (lower + self.tolerance).max(self.limit.map_or(0.0, |limit| limit - 2.0 * slack))
    }
}

/// Bounds of a Hausdorff distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CertifiedBounds {
    /// The distance is not smaller than this.
    pub lower: f64,
    /// The distance is not larger than this.
    pub upper: f64,
    /// The point that is `lower` away from the other surface.
    pub at: DVec3,
    /// Whether the bounds met the tolerance, or tell on which side of the limit the distance is.
    pub converged: bool,
    /// How many pieces of triangles were looked at.
    pub pieces: usize,
}

/// Bounds of the Hausdorff distance of two surfaces: the larger of the two one-sided distances.
///
/// The bounds allow for rounding: 16 units in the last place of the largest coordinate.
#[must_use]
pub fn hausdorff_bounds(a: &Surface, b: &Surface, options: &CertifyOptions) -> CertifiedBounds {
    // A lower bound of one direction serves the other, where pieces below it need no cutting.
    let from_b = vertex_bound(b, a);
    let forward = refine(a, b, options, from_b);
    let start = Lower { distance: forward.lower, at: forward.at };
    let backward =
        refine(b, a, options, if from_b.distance > start.distance { from_b } else { start });
    let higher = if backward.lower > forward.lower { backward } else { forward };
    CertifiedBounds {
        lower: higher.lower,
        upper: forward.upper.max(backward.upper),
        at: higher.at,
        converged: forward.converged && backward.converged,
        pieces: forward.pieces + backward.pieces,
    }
}

/// Bounds of the one-sided Hausdorff distance: the largest distance to `to` of any point of
/// `from`.
///
/// The bounds allow for rounding, as those of [`hausdorff_bounds`] do.
#[must_use]
pub fn one_sided_bounds(from: &Surface, to: &Surface, options: &CertifyOptions) -> CertifiedBounds {
    refine(from, to, options, Lower { distance: 0.0, at: from.triangle(0)[0] })
}

/// A point and its distance to the other surface.
#[derive(Clone, Copy)]
struct Lower {
    distance: f64,
    at: DVec3,
}

impl Lower {
    fn raise(&mut self, distance: f64, at: DVec3) {
        if distance > self.distance {
            *self = Self { distance, at };
        }
    }
}

/// A corner of a piece, and what is closest to it.
#[derive(Clone, Copy)]
struct Corner {
    at: DVec3,
    distance: f64,
    slot: u32,
}

impl Corner {
    fn new(at: DVec3, to: &Surface, guess: u32) -> Self {
        let Nearest { squared, slot, .. } = to.nearest(at, guess);
        Self { at, distance: squared.sqrt(), slot }
    }
}

type Piece = [Corner; 3];

fn vertex_bound(from: &Surface, to: &Surface) -> Lower {
    let mut lower = Lower { distance: 0.0, at: from.triangle(0)[0] };
    for [a, b, c] in whole_triangles(from, to) {
        for corner in [a, b, c] {
            lower.raise(corner.distance, corner.at);
        }
    }
    lower
}

fn whole_triangles(from: &Surface, to: &Surface) -> Vec<Piece> {
    let blocks = in_blocks(from.positions().len(), |vertices| {
        let mut guess = 0;
        let corner = |v: usize| {
            let corner = Corner::new(from.positions()[v], to, guess);
            guess = corner.slot;
            corner
        };
        vertices.map(corner).collect::<Vec<_>>()
    });
    let corners = blocks.concat();
    from.triangles().iter().map(|t| t.map(|v| corners[v as usize])).collect()
}

fn refine(from: &Surface, to: &Surface, options: &CertifyOptions, start: Lower) -> CertifiedBounds {
    let slack = 16.0 * f64::EPSILON * largest_coordinate(from).max(largest_coordinate(to));
    let mut lower = start;
    let mut settled = start.distance;
    let mut pieces = whole_triangles(from, to);
    let mut looked_at = 0;
    for corner in pieces.as_flattened() {
        lower.raise(corner.distance, corner.at);
    }
    loop {
        looked_at += pieces.len();
        let bar = options.bar(lower.distance, slack);
        let bounds: Vec<_> =
            in_blocks(pieces.len(), |range| bound_pieces(&pieces[range], to, bar)).concat();
        for (_, center) in &bounds {
            if let Some(center) = center {
                lower.raise(center.distance, center.at);
            }
        }
        let bar = options.bar(lower.distance, slack);
        let (mut open, mut highest_open) = (Vec::new(), 0.0_f64);
        for (piece, (upper, center)) in pieces.iter().zip(bounds) {
            match center {
                Some(center) if upper > bar => {
                    open.push((*piece, center));
                    highest_open = highest_open.max(upper);
                }
                _ => settled = settled.max(upper),
            }
        }
        let exceeded = options.limit.is_some_and(|limit| lower.distance - slack > limit);
        let done = open.is_empty() || exceeded;
        if done || looked_at + 4 * open.len() > options.max_pieces {
            return CertifiedBounds {
                lower: (lower.distance - slack).max(0.0),
                upper: lower.distance.max(settled).max(highest_open) + slack,
                at: lower.at,
                converged: done,
                pieces: looked_at,
            };
        }
        let parts = in_blocks(open.len(), |range| divide(&open[range], to, bar));
        settled = parts.iter().map(|parts| parts.settled).fold(settled, f64::max);
        pieces = parts.into_iter().flat_map(|parts| parts.pieces).collect();
        for corner in pieces.as_flattened() {
            lower.raise(corner.distance, corner.at);
        }
    }
}

/// An upper bound for each piece, and its centre where that had to be asked for.
fn bound_pieces(pieces: &[Piece], to: &Surface, bar: f64) -> Vec<(f64, Option<Corner>)> {
    let bound = |piece: &Piece| {
        let by_corner = piece.iter().map(|corner| farthest_corner(piece, to, corner.slot));
        let upper = by_corner.fold(f64::INFINITY, f64::min);
        if upper <= bar {
            return (upper, None);
        }
        let [a, b, c] = piece.map(|corner| corner.at);
        let middle = a + ((b - a) + (c - a)) / 3.0;
        let center = Corner::new(middle, to, piece[0].slot);
        let radius = [a, b, c].map(|p| p.distance(middle)).into_iter().fold(0.0, f64::max);
        let through_center = farthest_corner(piece, to, center.slot);
        (upper.min(through_center).min(center.distance + radius), Some(center))
    };
    pieces.iter().map(bound).collect()
}

/// How far the farthest corner of the piece is from one triangle of the other surface.
fn farthest_corner(piece: &Piece, to: &Surface, slot: u32) -> f64 {
    farthest(&piece.map(|corner| corner.at), &to.bvh().triangle(slot))
}

fn farthest(points: &[DVec3], triangle: &[DVec3; 3]) -> f64 {
    let squared = points.iter().map(|&p| closest_on_triangle(p, triangle).length_squared());
    squared.fold(0.0, f64::max).sqrt()
}

/// What pieces were divided into.
#[derive(Default)]
struct Parts {
    pieces: Vec<Piece>,
    /// No point of what is left out is farther away than this.
    settled: f64,
}

impl Parts {
    /// Adds the four halves-by-halves of a piece.
    fn quarter(&mut self, [a, b, c]: Piece, to: &Surface) {
        let middle = |p: Corner, q: Corner| Corner::new(p.at + 0.5 * (q.at - p.at), to, p.slot);
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        self.pieces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }

    /// Adds what lies outside the prism over a triangle, if all that lies inside is close enough to
    /// the triangle.
    fn cut_out(&mut self, piece: &Piece, to: &Surface, slot: u32, bar: f64) -> bool {
        let triangle = to.bvh().triangle(slot);
        let corners = piece.map(|corner| corner.at);
        let Some(prism) = Prism::new(&triangle, &corners, bar) else { return false };
        let mut inside = Polygon::new(&corners);
        let outside = prism.0.map(|plane| {
            let out = inside.beyond(plane.flipped());
            inside = inside.beyond(plane);
            out
        });
        let far = farthest(inside.corners(), &triangle);
        if far > bar || LEAST * doubled_area(&corners) > inside.doubled_area() {
            return false;
        }
        self.settled = self.settled.max(far);
        for polygon in outside.iter().filter(|polygon| polygon.count > 2) {
            self.add(polygon, piece, to, slot);
        }
        true
    }

    /// Adds the triangles of a fan.
    fn add(&mut self, polygon: &Polygon, of: &Piece, to: &Surface, guess: u32) {
        let corner = |&at: &DVec3| {
            let known = of.iter().find(|corner| corner.at == at);
            known.copied().unwrap_or_else(|| Corner::new(at, to, guess))
        };
        let mut corners = polygon.corners().iter().map(corner);
        let (Some(first), Some(mut last)) = (corners.next(), corners.next()) else { return };
        for corner in corners {
            self.pieces.push([first, last, corner]);
            last = corner;
        }
    }
}

/// Pieces that are larger by this factor than the triangle below them are cut into four.
const LARGER: f64 = 8.0;
/// Nothing is cut out of pieces whose corners are all closer to the centre than this multiple of the
/// distance that is to be proved.
const WIDE: f64 = 2.0;
/// The least part of a piece that is worth cutting out.
const LEAST: f64 = 0.1;

/// Divides pieces that were given with their centres.
fn divide(pieces: &[(Piece, Corner)], to: &Surface, bar: f64) -> Parts {
    let mut parts = Parts::default();
    for (piece, center) in pieces {
        let below = to.bvh().triangle(center.slot);
        let is_small = doubled_area(&piece.map(|p| p.at)) <= LARGER * doubled_area(&below);
        // Pieces as small as the bar are settled soon.
        let is_wide = piece.iter().any(|corner| corner.at.distance(center.at) > WIDE * bar);
        if !(is_small && is_wide && parts.cut_out(piece, to, center.slot, bar)) {
            parts.quarter(*piece, to);
        }
    }
    parts
}

fn doubled_area([a, b, c]: &[DVec3; 3]) -> f64 {
    (b - a).cross(c - a).length()
}

/// The points with `normal · x >= offset`.
#[derive(Clone, Copy)]
struct HalfSpace {
    normal: DVec3,
    offset: f64,
}

impl HalfSpace {
    fn flipped(self) -> Self {
        Self { normal: -self.normal, offset: -self.offset }
    }

    /// How far inside a point is.
    fn height(self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// What lies over and under a triangle, and a little beside it.
struct Prism([HalfSpace; 3]);

impl Prism {
    /// As wide as the height of the piece over the triangle allows, but for the corners. `None` where
    /// the piece is too high.
    fn new(triangle: &[DVec3; 3], piece: &[DVec3; 3], bar: f64) -> Option<Self> {
        let [a, b, c] = *triangle;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let heights = piece.map(|p| normal.dot(p - a).abs());
        let height = heights.into_iter().fold(0.0, f64::max);
        if height > bar {
            return None;
        }
        let beside = 0.5 * (bar * bar - height * height).sqrt();
        Some(Self([[a, b], [b, c], [c, a]].map(|[p, q]| {
            let normal = normal.cross(q - p).normalize_or_zero();
            HalfSpace { normal, offset: normal.dot(p) - beside }
        })))
    }
}

/// A convex polygon: a triangle cut by up to three planes. Places beyond `count` mean nothing.
#[derive(Clone, Copy)]
struct Polygon {
    places: [DVec3; 6],
    count: usize,
}

impl Polygon {
    fn new(corners: &[DVec3; 3]) -> Self {
        let [a, b, c] = *corners;
        Self { places: [a, b, c, c, c, c], count: 3 }
    }

    fn corners(&self) -> &[DVec3] {
        &self.places[..self.count]
    }

    fn doubled_area(&self) -> f64 {
        let fan = (2..self.count).map(|i| [self.places[0], self.places[i - 1], self.places[i]]);
        fan.map(|triangle| doubled_area(&triangle)).sum()
    }

    /// The part in a half-space.
    fn beyond(&self, plane: HalfSpace) -> Self {
        let mut part = Self { places: self.places, count: 0 };
        let mut push = |at: DVec3| {
            if let Some(place) = part.places.get_mut(part.count) {
                *place = at;
                part.count += 1;
            }
        };
        for (i, &p) in self.corners().iter().enumerate() {
            let q = self.places[(i + 1) % self.count];
            let [from, to] = [p, q].map(|at| plane.height(at));
            if from >= 0.0 {
                push(p);
            }
            if (from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0) {
                push(p + (q - p) * (from / (from - to)));
            }
        }
        part
    }
}

fn largest_coordinate(surface: &Surface) -> f64 {
    let bounds = surface.bounding_box();
    bounds.min.abs().max(bounds.max.abs()).max_element()
}
