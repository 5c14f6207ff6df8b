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
//! divided, until there are none (compare Tang, Lee, Kim 2009 and Kang, Kyung, Yoon,
//! Kim 2018). Those that are much larger than the triangle below their centre are cut into four. Of
//! the others, what lies over that triangle is cut out and done with. Without that, where two
//! surfaces nearly coincide, pieces along every edge would have to become as small as the distance
//! that is to be proved.
//!
//! Distances to single triangles are those of [`distance_bounds`](crate::distance_bounds), which hold whatever the
//! shape of the triangle. Below their slack, which is relative to the size of the surfaces and to
//! their coordinates, the bounds do not go:
//!
//! - The corners of parts are rounded to coordinates. Moving each point of a piece with the corners
//!   of its part takes it no farther than its corners move, so that parts cover their piece up to
//!   that distance, and after some rounds up to the sum of these distances. It is added to each upper
//!   bound, and taken off each lower one.
//! - The search for the closest triangle orders triangles by distances that are not proved. For an
//!   upper bound that is no matter: any triangle gives one. A point that is to give a lower bound is
//!   compared once more with every triangle that may be that close.

use core::ops::Range;

use glam::DVec3;
use mesh_core::parallel;

use crate::bvh::Nearest;
use crate::distance_bounds::{Rounding, upper_bound};
use crate::polygon_clipping::{Polygon, Prism, doubled_area};
use crate::surface::Surface;

/// When to stop; see [`hausdorff_bounds`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CertifyOptions {
    /// How far apart the bounds may be, in model units.
    pub tolerance: f64,
    /// How many pieces of triangles may be looked at, for each direction, whole triangles included.
    /// At the limit the bounds hold, but are farther apart than the tolerance.
    pub max_pieces: usize,
    /// How many may be looked at for each triangle of the surface, where that is more.
    pub max_pieces_per_face: usize,
    /// When only it matters whether the distance is at most this: the search ends as soon as one
    /// of the bounds tells.
    pub limit: Option<f64>,
}

impl Default for CertifyOptions {
    fn default() -> Self {
        Self { tolerance: 0.0, max_pieces: 20_000_000, max_pieces_per_face: 10, limit: None }
    }
}

impl CertifyOptions {
    /// Pieces that are not farther away than this need no cutting.
    fn bar(&self, lower: f64, slack: f64) -> f64 {
        // Once more the slack, so that adding it does not round to more than the limit.
        (lower + self.tolerance).max(self.limit.map_or(0.0, |limit| limit - 2.0 * slack))
    }

    /// How many pieces of a surface may be looked at.
    fn budget(&self, triangles: usize) -> usize {
        self.max_pieces.max(self.max_pieces_per_face.saturating_mul(triangles))
    }
}

/// Bounds of a Hausdorff distance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

impl CertifiedBounds {
    /// Bounds that hold for any two surfaces.
    fn unknown(from: &Surface) -> Self {
        let at = Lower::nothing(from).at;
        Self { lower: 0.0, upper: f64::INFINITY, at, converged: false, pieces: 0 }
    }
}

/// Bounds of the Hausdorff distance of two surfaces: the larger of the two one-sided distances.
///
/// The bounds hold whatever is rounded on the way and whatever the shapes of the triangles. They allow
/// for it by 32 units in the last place of the largest extent, and 4 of this and the largest
/// coordinate for every time that a piece was divided, which adds up to some 1e-14 of these lengths;
/// only between needles, whose own directions are uncertain, the lower one may stay farther below.
#[must_use]
pub fn hausdorff_bounds(a: &Surface, b: &Surface, options: &CertifyOptions) -> CertifiedBounds {
    let unstopped = hausdorff_bounds_until(a, b, options, &mut || false);
    unstopped.unwrap_or(CertifiedBounds::unknown(a))
}

/// As [`hausdorff_bounds`], until `stops` says so, which is asked every some ten thousand pieces;
/// `None` then.
#[must_use]
pub fn hausdorff_bounds_until(
    a: &Surface,
    b: &Surface,
    options: &CertifyOptions,
    stops: &mut dyn FnMut() -> bool,
) -> Option<CertifiedBounds> {
    let of_b = corners(b, a, stops)?;
    // A lower bound of one direction serves the other, where pieces below it need no cutting.
    let mut from_b = Lower::nothing(b);
    from_b.raise_by_vertices(b, a, &of_b);
    let forward = refine(a, b, &corners(a, b, stops)?, options, from_b, stops)?;
    let backward = refine(b, a, &of_b, options, forward.lower, stops)?;
    Some(CertifiedBounds {
        lower: backward.lower.proved(),
        upper: forward.upper.max(backward.upper),
        at: backward.lower.at,
        converged: forward.converged && backward.converged,
        pieces: forward.pieces + backward.pieces,
    })
}

/// Bounds of the one-sided Hausdorff distance: the largest distance to `to` of any point of
/// `from`.
///
/// The bounds allow for rounding, as those of [`hausdorff_bounds`] do.
#[must_use]
pub fn one_sided_bounds(from: &Surface, to: &Surface, options: &CertifyOptions) -> CertifiedBounds {
    let stops = &mut || false;
    let start = Lower::nothing(from);
    let known = corners(from, to, stops);
    let Some(refined) = known.and_then(|known| refine(from, to, &known, options, start, stops))
    else {
        return CertifiedBounds::unknown(from);
    };
    CertifiedBounds {
        lower: refined.lower.proved(),
        upper: refined.upper,
        at: refined.lower.at,
        converged: refined.converged,
        pieces: refined.pieces,
    }
}

/// A point, and how far it is from the other surface at least.
#[derive(Clone, Copy)]
struct Lower {
    distance: f64,
    /// What the distance may be off by.
    slack: f64,
    at: DVec3,
}

impl Lower {
    fn nothing(from: &Surface) -> Self {
        Self { distance: 0.0, slack: 0.0, at: from.triangle(0)[0] }
    }

    fn proved(self) -> f64 {
        (self.distance - self.slack).max(0.0)
    }

    /// Takes the farthest of some points if it can be proved to be farther away, or else, a few times,
    /// the next one.
    fn raise<'a>(
        &mut self,
        corners: &(impl Iterator<Item = &'a Corner> + Clone),
        to: &Surface,
        slack: f64,
    ) {
        let mut below = f64::INFINITY;
        for _ in 0..TRIES {
            let untried = corners.clone().filter(|corner| corner.distance < below);
            let farther = |best: Option<&'a Corner>, corner: &'a Corner| match best {
                Some(best) if best.distance >= corner.distance => Some(best),
                _ => Some(corner),
            };
            let Some(corner) = untried.fold(None, farther) else { return };
            if corner.distance <= self.distance {
                return;
            }
            let distance = to.bvh().lower_bound(corner.at, corner.distance);
            if distance > self.distance {
                *self = Self { distance, slack, at: corner.at };
            }
            if distance >= (1.0 - 1e-12) * corner.distance {
                return;
            }
            below = corner.distance;
        }
    }

    /// Takes the farthest of the vertices that belong to triangles.
    fn raise_by_vertices(&mut self, from: &Surface, to: &Surface, corners: &[Corner]) {
        let slack = Rounding::between(from.bounding_box(), to.bounding_box()).after(0);
        let used = from.triangles().as_flattened().iter().map(|&v| &corners[v as usize]);
        self.raise(&used, to, slack);
    }
}

/// How many points are tried for a lower bound.
const TRIES: usize = 4;

/// A corner of a piece, and what is closest to it.
#[derive(Clone, Copy)]
struct Corner {
    at: DVec3,
    distance: f64,
    slot: u32,
    /// How far it is at most from that triangle.
    upper_bound: f64,
}

impl Corner {
    fn new(at: DVec3, to: &Surface, guess: u32) -> Self {
        let Nearest { squared, slot, .. } = to.nearest(at, guess);
        let upper_bound = upper_bound(at, &to.bvh().triangle(slot));
        Self { at, distance: squared.sqrt(), slot, upper_bound }
    }
}

type Piece = [Corner; 3];

/// Pieces between which it is asked whether to stop.
const AT_ONCE: usize = 1 << 16;

/// What `make` gives for ranges of consecutive indices, until it is said to stop.
fn in_turns<T: Send>(
    count: usize,
    stops: &mut dyn FnMut() -> bool,
    make: impl Fn(Range<usize>) -> T + Sync,
) -> Option<Vec<T>> {
    let mut all = Vec::new();
    for start in (0..count).step_by(AT_ONCE) {
        if stops() {
            return None;
        }
        let some = AT_ONCE.min(count - start);
        all.extend(parallel::per_block(some, |range| make(start + range.start..start + range.end)));
    }
    Some(all)
}

/// The vertices of a surface, those that belong to no triangle included.
fn corners(from: &Surface, to: &Surface, stops: &mut dyn FnMut() -> bool) -> Option<Vec<Corner>> {
    let blocks = in_turns(from.positions().len(), stops, |vertices| {
        let mut guess = 0;
        let corner = |v: usize| {
            let corner = Corner::new(from.positions()[v], to, guess);
            guess = corner.slot;
            corner
        };
        vertices.map(corner).collect::<Vec<_>>()
    });
    Some(blocks?.concat())
}

/// Bounds of one direction.
struct Refined {
    lower: Lower,
    upper: f64,
    converged: bool,
    pieces: usize,
}

/// Bounds of the direction from a surface whose vertices these are, with a lower bound to start with.
fn refine(
    from: &Surface,
    to: &Surface,
    corners: &[Corner],
    options: &CertifyOptions,
    start: Lower,
    stops: &mut dyn FnMut() -> bool,
) -> Option<Refined> {
    let rounding = Rounding::between(from.bounding_box(), to.bounding_box());
    let budget = options.budget(from.triangle_count());
    let whole = |t: &[u32; 3]| t.map(|v| corners[v as usize]);
    let mut search =
        Search { to, options, rounding, lower: start, settled: start.proved(), open: Vec::new() };
    search.lower.raise_by_vertices(from, to, corners);
    let mut looked_at = from.triangle_count();
    let mut is_exhausted = false;
    for triangles in from.triangles().chunks(TOGETHER) {
        search.look_at(&triangles.iter().map(whole).collect::<Vec<_>>(), 0);
        while let Some(open) = search.open.pop() {
            if stops() {
                return None;
            }
            is_exhausted |= looked_at + 4 * open.pieces.len() > budget;
            if is_exhausted || search.is_beyond() {
                search.settled = search.settled.max(open.upper);
            } else {
                let parts = search.divide(&open);
                looked_at += parts.len();
                search.look_at(&parts, open.rounds + 1);
            }
        }
    }
    let converged = !is_exhausted || search.is_beyond();
    let Search { lower, settled, .. } = search;
    Some(Refined { lower, upper: settled.max(lower.proved()), converged, pieces: looked_at })
}

/// How many pieces are divided together: they are done with before others are, so that there are never many.
const TOGETHER: usize = 1 << 13;

/// What is known of one direction.
struct Search<'a> {
    to: &'a Surface,
    options: &'a CertifyOptions,
    rounding: Rounding,
    lower: Lower,
    /// No point of what is done with is farther away than this.
    settled: f64,
    /// What has yet to be divided, the smallest last.
    open: Vec<Open>,
}

/// Pieces, each with its centre.
struct Open {
    pieces: Vec<(Piece, Corner)>,
    /// No point of them is farther away than this.
    upper: f64,
    /// How often there was a division until they were there.
    rounds: usize,
}

impl Search<'_> {
    /// Whether the distance is beyond the limit that alone matters.
    fn is_beyond(&self) -> bool {
        self.options.limit.is_some_and(|limit| self.lower.proved() > limit)
    }

    /// Bounds pieces, and keeps those that are not done with.
    fn look_at(&mut self, pieces: &[Piece], rounds: usize) {
        let Self { to, options, .. } = *self;
        let slack = self.rounding.after(rounds);
        self.lower.raise(&pieces.as_flattened().iter(), to, slack);
        let bar = options.bar(self.lower.distance, slack);
        // With what is added for rounding, this does not raise the upper bound of the whole.
        let least = (self.lower.proved() - slack).min(bar);
        let bounds = parallel::concat_blocks(pieces.len(), |range| {
            bound_pieces(&pieces[range], to, bar, least)
        });
        self.lower.raise(&bounds.iter().filter_map(|(_, center)| center.as_ref()), to, slack);
        let bar = options.bar(self.lower.distance, slack);
        let (mut open, mut highest) = (Vec::new(), 0.0_f64);
        for (piece, (upper, center)) in pieces.iter().zip(bounds) {
            match center {
                Some(center) if upper > bar => {
                    open.push((*piece, center));
                    highest = highest.max(upper + slack);
                }
                _ => self.settled = self.settled.max(upper + slack),
            }
        }
        self.open.extend(open.chunks(TOGETHER).map(|some| Open {
            pieces: some.to_vec(),
            upper: highest,
            rounds,
        }));
    }

    fn divide(&mut self, open: &Open) -> Vec<Piece> {
        let bar = self.options.bar(self.lower.distance, self.rounding.after(open.rounds));
        let pieces = &open.pieces;
        let parts = parallel::per_block(pieces.len(), |range| divide(&pieces[range], self.to, bar));
        let slack = self.rounding.after(open.rounds + 1);
        self.settled = parts.iter().map(|parts| parts.settled + slack).fold(self.settled, f64::max);
        parts.into_iter().flat_map(|parts| parts.pieces).collect()
    }
}

/// An upper bound for each piece, and its centre where that had to be asked for.
///
/// Bounds below `least` need not be the best ones.
fn bound_pieces(
    pieces: &[Piece],
    to: &Surface,
    bar: f64,
    least: f64,
) -> Vec<(f64, Option<Corner>)> {
    let bound = |piece: &Piece| {
        let mut upper = f64::INFINITY;
        for corner in piece {
            upper = upper.min(farthest_corner(piece, to, corner.slot));
            if upper <= least {
                return (upper, None);
            }
        }
        if upper <= bar {
            return (upper, None);
        }
        let [a, b, c] = piece.map(|corner| corner.at);
        let middle = a + ((b - a) + (c - a)) / 3.0;
        let center = Corner::new(middle, to, piece[0].slot);
        let radius = [a, b, c].map(|p| p.distance(middle)).into_iter().fold(0.0, f64::max);
        let through_center = farthest_corner(piece, to, center.slot);
        (upper.min(through_center).min(center.upper_bound + radius), Some(center))
    };
    pieces.iter().map(bound).collect()
}

/// How far the farthest corner of the piece is at most from one triangle of the other surface.
fn farthest_corner(piece: &Piece, to: &Surface, slot: u32) -> f64 {
    let triangle = to.bvh().triangle(slot);
    let most = |corner: &Corner| match corner.slot == slot {
        true => corner.upper_bound,
        false => upper_bound(corner.at, &triangle),
    };
    piece.iter().map(most).fold(0.0, f64::max)
}

fn farthest(points: &[DVec3], triangle: &[DVec3; 3]) -> f64 {
    points.iter().map(|&p| upper_bound(p, triangle)).fold(0.0, f64::max)
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
        for polygon in outside.iter().filter(|polygon| polygon.corners().len() > 2) {
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
