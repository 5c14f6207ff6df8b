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
//! cut into four, round by round, until there are none (compare Tang, Lee, Kim 2009 and Kang,
//! Kyung, Yoon, Kim 2018).

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
        (lower + self.tolerance).max(self.limit.map_or(0.0, |limit| limit - slack))
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
        for (piece, (upper, _)) in pieces.iter().zip(bounds) {
            if upper > bar {
                open.push(*piece);
                highest_open = highest_open.max(upper);
            } else {
                settled = settled.max(upper);
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
        pieces = in_blocks(open.len(), |range| quarter(&open[range], to)).concat();
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
    let triangle = to.bvh().triangle(slot);
    let squared = piece.iter().map(|c| closest_on_triangle(c.at, &triangle).length_squared());
    squared.fold(0.0, f64::max).sqrt()
}

/// The four halves-by-halves of each piece.
fn quarter(pieces: &[Piece], to: &Surface) -> Vec<Piece> {
    let mut parts = Vec::with_capacity(4 * pieces.len());
    for &[a, b, c] in pieces {
        let middle = |p: Corner, q: Corner| Corner::new(p.at + 0.5 * (q.at - p.at), to, p.slot);
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        parts.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    parts
}

fn largest_coordinate(surface: &Surface) -> f64 {
    let bounds = surface.bounding_box();
    bounds.min.abs().max(bounds.max.abs()).max_element()
}
