//! Certified bounds of the Hausdorff distance.
//!
//! The one-sided distance h(A, B) is the largest distance from a point of A to B. A point of A gives a lower bound. A
//! piece T of a triangle of A gives upper bounds:
//!
//! - The distance to one triangle t of B is a convex function, so on T it is largest at a corner: no point of T is
//!   farther from B than the farthest corner of T is from t.
//! - No point of T is farther from B than the centre of T, plus the radius of T about that centre.
//!
//! Pieces whose upper bound exceeds the lower bound of the whole by more than the tolerance are divided until
//! there are none (compare Tang, Lee, Kim 2009 and Kang, Kyung, Yoon, Kim 2018). Pieces much larger than the
//! triangle closest to their centre are cut into four. From other pieces, the part over that triangle is cut
//! out and finished. Otherwise, where two surfaces nearly coincide, pieces along every edge would have to
//! become as small as the distance between the surfaces.
//!
//! Distances to single triangles come from [`distance_bounds`](crate::distance_bounds) and hold for any shape
//! of the triangle. Two further errors are included:
//!
//! - The corners of parts are rounded. A point of a piece moves no farther than the corners of its part, so
//!   parts cover their piece up to that distance, and after several rounds up to the sum of these distances.
//!   The sum is added to upper bounds and subtracted from lower bounds.
//! - The search for the closest triangle uses uncertified distances. That does not affect an upper bound, since
//!   any triangle gives one. A point used for a lower bound is compared again with every triangle that may be
//!   that close.

use core::ops::Range;

use glam::DVec3;
use mesh_core::parallel;

use crate::bvh::Nearest;
use crate::compare::OneSided;
use crate::distance_bounds::{Rounding, upper_bound};
use crate::frame::Frame;
use crate::polygon_clipping::{Polygon, Prism, doubled_area};
use crate::surface::Surface;

/// Tolerance and limits of [`hausdorff_bounds`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CertifyOptions {
    /// Largest difference between the bounds, in model units.
    pub tolerance: f64,
    /// Largest number of pieces of triangles per direction, whole triangles included. At the limit the bounds
    /// hold, but differ by more than the tolerance.
    pub max_pieces: usize,
    /// Largest number of pieces per triangle of the surface; the larger of both limits applies.
    pub max_pieces_per_face: usize,
    /// Set this if only the question matters whether the distance is at most `limit`: the search ends as soon
    /// as a bound decides it.
    pub limit: Option<f64>,
}

impl Default for CertifyOptions {
    fn default() -> Self {
        Self { tolerance: 0.0, max_pieces: 20_000_000, max_pieces_per_face: 10, limit: None }
    }
}

impl CertifyOptions {
    /// Pieces with an upper bound up to this need not be divided.
    fn bar(&self, lower: f64, slack: f64) -> f64 {
        // Twice the slack, so that adding it cannot round above the limit.
        // No division helps below the rounding errors.
        (lower + self.tolerance.max(slack)).max(self.limit.map_or(0.0, |limit| limit - 2.0 * slack))
    }

    /// The options for surfaces in a frame.
    fn placed(&self, frame: Frame) -> Self {
        let limit = self.limit.map(|limit| frame.length(limit));
        Self { tolerance: frame.length(self.tolerance), limit, ..*self }
    }

    /// Largest number of pieces of a surface to process.
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
    /// Whether the bounds meet the tolerance, as far as rounding allows, or decide on which side of the limit the
    /// distance is.
    pub converged: bool,
    /// Number of pieces of triangles processed.
    pub pieces: usize,
}

impl CertifiedBounds {
    /// Trivial bounds.
    fn unknown(from: &Surface) -> Self {
        let at = Lower::nothing(from).at;
        Self { lower: 0.0, upper: f64::INFINITY, at, converged: false, pieces: 0 }
    }

    /// Raises the lower bound by the farthest sample of `from`, as far as its distance to `to` can be certified.
    /// A sampled maximum alone is rounded and proves nothing.
    #[must_use]
    pub fn raised_by(self, sample: &OneSided, from: &Surface, to: &Surface) -> Self {
        let at = sample.worst.from;
        let slack = Rounding::between(from.bounding_box(), to.bounding_box()).after(1);
        let lower = (to.bvh().lower_bound(at, sample.max) - slack).min(self.upper);
        if lower > self.lower { Self { lower, at, ..self } } else { self }
    }

    /// The bounds of surfaces in a frame, for the original surfaces.
    fn restored(self, frame: Frame) -> Self {
        let [lower, upper] = [self.lower, self.upper].map(|length| frame.original_length(length));
        Self { lower, upper, at: frame.original_point(self.at), ..self }
    }
}

/// Bounds of the Hausdorff distance of two surfaces: the larger of the two one-sided distances.
///
/// The bounds include all rounding errors, for triangles of any shape. The allowance is 32 units in the last
/// place of the largest extent, plus 4 of the extent and the largest coordinate per division of a piece: about
/// 1e-14 of these lengths. Between long thin triangles, whose directions are uncertain, the lower bound may be
/// less tight.
#[must_use]
pub fn hausdorff_bounds(a: &Surface, b: &Surface, options: &CertifyOptions) -> CertifiedBounds {
    let unstopped = hausdorff_bounds_until(a, b, options, &mut || false);
    unstopped.unwrap_or(CertifiedBounds::unknown(a))
}

/// As [`hausdorff_bounds`], but `None` as soon as `stops` returns true. It is called about every ten thousand
/// pieces.
#[must_use]
pub fn hausdorff_bounds_until(
    a: &Surface,
    b: &Surface,
    options: &CertifyOptions,
    stops: &mut dyn FnMut() -> bool,
) -> Option<CertifiedBounds> {
    let Some(frame) = Frame::of(a.bounding_box(), b.bounding_box()) else {
        return bounds_in_range(a, b, options, stops);
    };
    let (Some(a), Some(b)) = (a.placed(frame), b.placed(frame)) else {
        return Some(CertifiedBounds::unknown(a));
    };
    let bounds = bounds_in_range(&a, &b, &options.placed(frame), stops)?;
    Some(bounds.restored(frame))
}

/// [`hausdorff_bounds_until`] for coordinates whose fourth powers neither overflow nor underflow.
fn bounds_in_range(
    a: &Surface,
    b: &Surface,
    options: &CertifyOptions,
    stops: &mut dyn FnMut() -> bool,
) -> Option<CertifiedBounds> {
    let of_b = corners(b, a, stops)?;
    // A lower bound of one direction serves the other: pieces below it need not be divided.
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

/// Bounds of the one-sided Hausdorff distance: the largest distance from a point of `from` to `to`.
///
/// The bounds include rounding errors, see [`hausdorff_bounds`].
#[must_use]
pub fn one_sided_bounds(from: &Surface, to: &Surface, options: &CertifyOptions) -> CertifiedBounds {
    let Some(frame) = Frame::of(from.bounding_box(), to.bounding_box()) else {
        return one_sided_in_range(from, to, options);
    };
    match (from.placed(frame), to.placed(frame)) {
        (Some(from), Some(to)) => {
            one_sided_in_range(&from, &to, &options.placed(frame)).restored(frame)
        }
        _ => CertifiedBounds::unknown(from),
    }
}

fn one_sided_in_range(from: &Surface, to: &Surface, options: &CertifyOptions) -> CertifiedBounds {
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

/// A point with a lower bound of its distance to the other surface.
#[derive(Clone, Copy)]
struct Lower {
    distance: f64,
    /// Error of the distance.
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

    /// Raises the bound to the distance of the farthest corner that can be certified, trying a few.
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

    /// Raises the bound by the vertices of triangles.
    fn raise_by_vertices(&mut self, from: &Surface, to: &Surface, corners: &[Corner]) {
        let slack = Rounding::between(from.bounding_box(), to.bounding_box()).after(0);
        let used = from.triangles().as_flattened().iter().map(|&v| &corners[v as usize]);
        self.raise(&used, to, slack);
    }
}

/// Number of points tried for a lower bound.
const TRIES: usize = 4;

/// A corner of a piece and its closest triangle.
#[derive(Clone, Copy)]
struct Corner {
    at: DVec3,
    distance: f64,
    slot: u32,
    /// Certified upper bound of the distance to that triangle.
    upper_bound: f64,
}

impl Corner {
    fn new(at: DVec3, to: &Surface, hint: u32) -> Self {
        let Nearest { squared, slot, .. } = to.nearest(at, hint);
        let upper_bound = upper_bound(at, &to.bvh().triangle(slot));
        Self { at, distance: squared.sqrt(), slot, upper_bound }
    }
}

type Piece = [Corner; 3];

/// Number of pieces between calls of `stops`.
const AT_ONCE: usize = 1 << 16;

/// The results of `make` for ranges of consecutive indices; `None` if stopped.
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

/// All vertices of a surface, used or not.
fn corners(from: &Surface, to: &Surface, stops: &mut dyn FnMut() -> bool) -> Option<Vec<Corner>> {
    let blocks = in_turns(from.positions().len(), stops, |vertices| {
        let mut hint = 0;
        let corner = |v: usize| {
            let corner = Corner::new(from.positions()[v], to, hint);
            hint = corner.slot;
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

/// Bounds of one direction, starting with a lower bound.
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

/// Number of pieces divided together, depth first, which bounds the memory.
const TOGETHER: usize = 1 << 13;

/// The state of the search in one direction.
struct Search<'a> {
    to: &'a Surface,
    options: &'a CertifyOptions,
    rounding: Rounding,
    lower: Lower,
    /// Upper bound for all finished pieces.
    settled: f64,
    /// Pieces still to be divided, the smallest last.
    open: Vec<Open>,
}

/// Pieces with their centres.
struct Open {
    pieces: Vec<(Piece, Corner)>,
    /// Upper bound for these pieces.
    upper: f64,
    /// Number of divisions that led to them.
    rounds: usize,
}

impl Search<'_> {
    /// Whether the distance certainly exceeds the limit.
    fn is_beyond(&self) -> bool {
        self.options.limit.is_some_and(|limit| self.lower.proved() > limit)
    }

    /// Bounds pieces and keeps the unfinished ones.
    fn look_at(&mut self, pieces: &[Piece], rounds: usize) {
        let Self { to, options, .. } = *self;
        let slack = self.rounding.after(rounds);
        self.lower.raise(&pieces.as_flattened().iter(), to, slack);
        let bar = options.bar(self.lower.distance, slack);
        // Even with the rounding allowance, this does not raise the upper bound of the whole.
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

/// An upper bound for each piece, and its centre if it was needed.
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

/// Upper bound of the distance from the corners of a piece to one triangle of the other surface.
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

/// The parts of divided pieces.
#[derive(Default)]
struct Parts {
    pieces: Vec<Piece>,
    /// Upper bound for the regions that were cut out.
    settled: f64,
}

impl Parts {
    /// Adds the four quarters of a piece.
    fn quarter(&mut self, [a, b, c]: Piece, to: &Surface) {
        let middle = |p: Corner, q: Corner| Corner::new(p.at + 0.5 * (q.at - p.at), to, p.slot);
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        self.pieces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }

    /// Adds the parts outside the prism over a triangle, if the part inside is close enough to the triangle.
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

    /// Adds a polygon as a fan of triangles.
    fn add(&mut self, polygon: &Polygon, of: &Piece, to: &Surface, hint: u32) {
        let corner = |&at: &DVec3| {
            let known = of.iter().find(|corner| corner.at == at);
            known.copied().unwrap_or_else(|| Corner::new(at, to, hint))
        };
        let mut corners = polygon.corners().iter().map(corner);
        let (Some(first), Some(mut last)) = (corners.next(), corners.next()) else { return };
        for corner in corners {
            self.pieces.push([first, last, corner]);
            last = corner;
        }
    }
}

/// Pieces larger than their closest triangle by this factor are cut into four.
const LARGER: f64 = 8.0;
/// Pieces whose corners are all nearer to the centre than this multiple of the threshold are cut into four.
const WIDE: f64 = 2.0;
/// Smallest part of a piece that is worth cutting out.
const LEAST: f64 = 0.1;

/// Divides pieces, given with their centres.
fn divide(pieces: &[(Piece, Corner)], to: &Surface, bar: f64) -> Parts {
    let mut parts = Parts::default();
    for (piece, center) in pieces {
        let below = to.bvh().triangle(center.slot);
        let is_small = doubled_area(&piece.map(|p| p.at)) <= LARGER * doubled_area(&below);
        // Pieces as small as the threshold finish soon.
        let is_wide = piece.iter().any(|corner| corner.at.distance(center.at) > WIDE * bar);
        if !(is_small && is_wide && parts.cut_out(piece, to, center.slot, bar)) {
            parts.quarter(*piece, to);
        }
    }
    parts
}
