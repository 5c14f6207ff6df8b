//! Distances between two surfaces from samples in both directions, as in Metro (Cignoni, Rocchini, Scopigno
//! 1998).

use core::ops::Range;

use glam::DVec3;
use mesh_core::{TriMesh, VertexMap, parallel};

use crate::bvh::Nearest;
use crate::frame::Frame;
use crate::sampling::{AreaSampler, area_of, first_beyond, running_totals};
use crate::signed_distance::{SignRule, SignedDistance};
use crate::surface::Surface;

/// How to sample; see [`compare`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CompareOptions {
    /// Samples per direction, uniform by area. Mean and root mean square use these alone.
    pub samples: usize,
    /// Whether vertices are measured as well, for the maximum only.
    pub vertices: bool,
    /// Whether edges are sampled as well, for the maximum only: long thin triangles have long edges and little
    /// area. Same density as on faces, but at most four times as many points.
    pub edges: bool,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self { samples: 1_000_000, vertices: true, edges: true, seed: 1 }
    }
}

impl CompareOptions {
    /// The options for points, which have no area and no edges.
    #[must_use]
    pub fn for_points() -> Self {
        Self { samples: 0, vertices: true, edges: false, ..Self::default() }
    }
}

/// Largest number of points on edges per sample on faces. Edges of similar lengths need at most 3.5.
const MOST_ON_EDGES: usize = 4;

/// The distances between two surfaces; made by [`compare`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Comparison {
    /// Distances from the first surface to the second.
    pub forward: OneSided,
    /// Distances from the second surface to the first.
    pub backward: OneSided,
}

/// The distances from the points of one surface to another surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OneSided {
    /// The mean over the area.
    pub mean: f64,
    /// The root of the mean square over the area.
    pub rms: f64,
    /// The largest distance of a sample: a lower bound of the one-sided Hausdorff distance.
    pub max: f64,
    /// The location of the largest distance.
    pub worst: Worst,
    /// Number of measured points, including points on edges and vertices.
    pub samples: usize,
}

/// The two ends of the largest distance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Worst {
    /// The sample.
    pub from: DVec3,
    /// The point of the other surface that is closest to it.
    pub to: DVec3,
}

impl Comparison {
    /// The larger of the two maxima: a lower bound of the Hausdorff distance.
    #[must_use]
    pub fn hausdorff(&self) -> f64 {
        self.forward.max.max(self.backward.max)
    }

    /// The average of the two mean distances.
    #[must_use]
    pub fn mean(&self) -> f64 {
        0.5 * (self.forward.mean + self.backward.mean)
    }

    /// The root of the average of the two mean squares.
    #[must_use]
    pub fn rms(&self) -> f64 {
        let of = |f: f64, b: f64| (0.5 * (f.powi(2) + b.powi(2))).sqrt();
        let (forward, backward) = (self.forward.rms, self.backward.rms);
        // A power of two changes no digit; squares of such lengths overflow or vanish.
        let factor = match forward.max(backward) {
            large if large > 1e140 => f64::from(-900).exp2(),
            small if small < 1e-140 => f64::from(900).exp2(),
            _ => 1.0,
        };
        of(forward * factor, backward * factor) / factor
    }
}

/// Measures the distances between two surfaces from samples on both.
///
/// For a surface without area, the mean is taken over its vertices and edge points.
#[must_use]
pub fn compare(a: &Surface, b: &Surface, options: &CompareOptions) -> Comparison {
    let unstopped = compare_until(a, b, options, &|| false);
    unstopped.unwrap_or(Comparison { forward: OneSided::UNKNOWN, backward: OneSided::UNKNOWN })
}

impl OneSided {
    const UNKNOWN: Self = Self {
        mean: f64::NAN,
        rms: f64::NAN,
        max: f64::NAN,
        worst: Worst { from: DVec3::NAN, to: DVec3::NAN },
        samples: 0,
    };

    /// The distances between surfaces in a frame, for the original surfaces.
    fn restored(self, frame: Frame) -> Self {
        let Worst { from, to } = self.worst;
        Self {
            mean: frame.original_length(self.mean),
            rms: frame.original_length(self.rms),
            max: frame.original_length(self.max),
            worst: Worst { from: frame.original_point(from), to: frame.original_point(to) },
            ..self
        }
    }
}

/// As [`compare`], but `None` as soon as `stops` returns true. Any thread calls it about every thousand points;
/// once true, it must stay true.
#[must_use]
pub fn compare_until(
    a: &Surface,
    b: &Surface,
    options: &CompareOptions,
    stops: &(dyn Fn() -> bool + Sync),
) -> Option<Comparison> {
    if let Some(frame) = Frame::of(a.bounding_box(), b.bounding_box())
        && let (Some(a), Some(b)) = (a.placed(frame), b.placed(frame))
    {
        let Comparison { forward, backward } = compare_until(&a, &b, options, stops)?;
        let [forward, backward] = [forward, backward].map(|side| side.restored(frame));
        return Some(Comparison { forward, backward });
    }
    let forward = one_sided(a, b, options, stops);
    if stops() {
        return None;
    }
    let backward = one_sided(b, a, options, stops);
    (!stops()).then_some(Comparison { forward, backward })
}

/// Measures the distances from one surface to another one, in this direction only. For a surface
/// [of points](Surface::of_points), mean and root mean square are over the points; [`CompareOptions::for_points`] has
/// the options for it.
#[must_use]
pub fn compare_one_way(from: &Surface, to: &Surface, options: &CompareOptions) -> OneSided {
    compare_one_way_until(from, to, options, &|| false).unwrap_or(OneSided::UNKNOWN)
}

/// As [`compare_one_way`], but `None` as soon as `stops` returns true; see [`compare_until`].
#[must_use]
pub fn compare_one_way_until(
    from: &Surface,
    to: &Surface,
    options: &CompareOptions,
    stops: &(dyn Fn() -> bool + Sync),
) -> Option<OneSided> {
    if let Some(frame) = Frame::of(from.bounding_box(), to.bounding_box())
        && let (Some(from), Some(to)) = (from.placed(frame), to.placed(frame))
    {
        let found = compare_one_way_until(&from, &to, options, stops)?;
        return Some(found.restored(frame));
    }
    let found = one_sided(from, to, options, stops);
    (!stops()).then_some(found)
}

/// The signed distances from the points of one surface to another surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SignedSide {
    /// How the sign was decided.
    pub rule: SignRule,
    /// The mean over the area, with signs.
    pub mean: f64,
    /// The smallest distance: the deepest point inside if it is negative.
    pub min: f64,
    /// The largest distance.
    pub max: f64,
    /// The part of the area with a negative distance.
    pub inside: f64,
}

/// Measures signed distances from one surface to another one, at the points that [`compare`] uses. `None` as soon as
/// `stops` returns true.
#[must_use]
pub fn compare_signed_until(
    from: &Surface,
    to: &SignedDistance<'_>,
    options: &CompareOptions,
    stops: &(dyn Fn() -> bool + Sync),
) -> Option<SignedSide> {
    let points = Points::new(from, options);
    let measure = |count: usize, points: &(dyn Fn(Range<usize>) -> Vec<DVec3> + Sync)| {
        let blocks = parallel::per_block(count, |range| match stops() {
            true => SignedTally::NONE,
            false => {
                to.distances(&points(range)).into_iter().fold(SignedTally::NONE, SignedTally::with)
            }
        });
        blocks.into_iter().fold(SignedTally::NONE, SignedTally::join)
    };
    let on_faces = measure(points.sampler.count(), &|range| points.on_faces(range));
    let mut all = on_faces.join(measure(points.vertices.len(), &|range| points.at_vertices(range)));
    if let Some(edges) = &points.on_edges {
        all = all.join(measure(edges.count(), &|range| edges.points(range)));
    }
    let averaged = if on_faces.count > 0 { on_faces } else { all };
    let count = averaged.count.max(1) as f64;
    let found = SignedSide {
        rule: to.rule(),
        mean: averaged.sum / count,
        min: all.min,
        max: all.max,
        inside: averaged.inside as f64 / count,
    };
    (!stops() && all.count > 0).then_some(found)
}

/// Statistics of a set of signed distances.
#[derive(Clone, Copy)]
struct SignedTally {
    count: usize,
    inside: usize,
    sum: f64,
    min: f64,
    max: f64,
}

impl SignedTally {
    const NONE: Self =
        Self { count: 0, inside: 0, sum: 0.0, min: f64::INFINITY, max: f64::NEG_INFINITY };

    fn with(self, distance: f64) -> Self {
        let inside = usize::from(distance < 0.0);
        self.join(Self { count: 1, inside, sum: distance, min: distance, max: distance })
    }

    fn join(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            inside: self.inside + other.inside,
            sum: self.sum + other.sum,
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }
}

/// The most parts of a side of a face in [`face_distances`].
const MOST_PARTS: usize = 200;

/// For each triangle of a surface, the largest distance of its points from another surface that was met: at its
/// corners, and at the points of a grid on it, so that about `points` points are on all faces together. Each side has
/// at least two parts, and at most 200.
#[must_use]
pub fn face_distances(from: &Surface, to: &Surface, points: usize) -> Vec<f64> {
    if let Some(frame) = Frame::of(from.bounding_box(), to.bounding_box())
        && let (Some(from), Some(to)) = (from.placed(frame), to.placed(frame))
    {
        let found = face_distances(&from, &to, points);
        return found.into_iter().map(|distance| frame.original_length(distance)).collect();
    }
    let areas = parallel::collect(from.triangle_count(), |t| area_of(from.triangle(t)));
    let total: f64 = areas.iter().sum();
    // A grid of n parts on each side has n² / 2 points.
    let spacing = 2.0 * points as f64 / total;
    let blocks = parallel::per_block(from.triangle_count(), |range| {
        let largest = |t: usize| {
            let parts = (areas[t] * spacing).sqrt().ceil();
            let parts = if parts.is_finite() { parts as usize } else { 0 };
            let on_face = grid(from.triangle(t), parts.clamp(2, MOST_PARTS));
            to.distances(&on_face).into_iter().fold(0.0, f64::max)
        };
        range.map(largest).collect::<Vec<f64>>()
    });
    blocks.into_iter().flatten().collect()
}

/// The points of a triangle whose barycentric coordinates are multiples of one part.
fn grid([a, b, c]: [DVec3; 3], parts: usize) -> Vec<DVec3> {
    let share = |count: usize| count as f64 / parts as f64;
    let rows = (0..=parts).flat_map(|i| (0..=parts - i).map(move |j| (i, j)));
    rows.map(|(i, j)| a * share(parts - i - j) + b * share(i) + c * share(j)).collect()
}

/// The distance of every vertex of a mesh to a surface, for example to colour a mesh by its error.
#[must_use]
pub fn vertex_distances(mesh: &TriMesh, to: &Surface) -> VertexMap<f64> {
    VertexMap::from_vec(to.distances(mesh.positions()))
}

/// The result is meaningless if it was stopped.
fn one_sided(
    from: &Surface,
    to: &Surface,
    options: &CompareOptions,
    stops: &(dyn Fn() -> bool + Sync),
) -> OneSided {
    let points = Points::new(from, options);
    let on_faces = measure(to, points.sampler.count(), stops, |range| points.on_faces(range));
    let mut all = on_faces;
    all = all.join(measure(to, points.vertices.len(), stops, |range| points.at_vertices(range)));
    if let Some(edges) = &points.on_edges {
        all = all.join(measure(to, edges.count(), stops, |range| edges.points(range)));
    }
    let averaged = if on_faces.count > 0 { on_faces } else { all };
    let count = averaged.count.max(1) as f64;
    OneSided {
        mean: averaged.sum / count,
        rms: (averaged.squares / count).sqrt(),
        max: all.largest.max(0.0).sqrt(),
        worst: Worst { from: all.at, to: all.at + all.offset },
        samples: all.count,
    }
}

/// The points of a surface that are compared with another one.
struct Points<'a> {
    surface: &'a Surface,
    sampler: AreaSampler<'a>,
    vertices: Vec<u32>,
    on_edges: Option<EdgePoints<'a>>,
}

impl<'a> Points<'a> {
    fn new(surface: &'a Surface, options: &CompareOptions) -> Self {
        let sampler = AreaSampler::new(surface, options.samples, options.seed);
        let vertices = if options.vertices { surface.used_vertices() } else { Vec::new() };
        let on_edges = options.edges.then(|| {
            let spacing = (sampler.area() / options.samples.max(1) as f64).sqrt();
            let most = MOST_ON_EDGES.saturating_mul(options.samples);
            EdgePoints::new(surface, spacing, options.samples, most)
        });
        Self { surface, sampler, vertices, on_edges }
    }

    fn on_faces(&self, indices: Range<usize>) -> Vec<DVec3> {
        self.sampler.samples(indices).map(|sample| sample.position).collect()
    }

    fn at_vertices(&self, indices: Range<usize>) -> Vec<DVec3> {
        self.vertices[indices].iter().map(|&v| self.surface.positions()[v as usize]).collect()
    }
}

/// [`Comparison::hausdorff`] of [`compare`], in about half the time.
#[must_use]
pub fn sampled_hausdorff(a: &Surface, b: &Surface, options: &CompareOptions) -> f64 {
    if let Some(frame) = Frame::of(a.bounding_box(), b.bounding_box())
        && let (Some(a), Some(b)) = (a.placed(frame), b.placed(frame))
    {
        return frame.original_length(sampled_hausdorff(&a, &b, options));
    }
    let largest = |from: &Surface, to: &Surface, known: f64| {
        let points = Points::new(from, options);
        // Vertices first: they usually have the largest distances, which speeds up the rest.
        let known = farthest(to, points.vertices.len(), known, |range| points.at_vertices(range));
        let known = farthest(to, points.sampler.count(), known, |range| points.on_faces(range));
        match &points.on_edges {
            Some(edges) => farthest(to, edges.count(), known, |range| edges.points(range)),
            None => known,
        }
    };
    largest(b, a, largest(a, b, 0.0)).sqrt()
}

/// The maximum of `known` and the squared distances of points.
fn farthest(
    to: &Surface,
    count: usize,
    known: f64,
    points: impl Fn(Range<usize>) -> Vec<DVec3> + Sync,
) -> f64 {
    let blocks = parallel::per_block(count, |indices| to.bvh().farthest(&points(indices), known));
    blocks.into_iter().fold(known, f64::max)
}

/// Statistics of a set of samples.
#[derive(Clone, Copy)]
struct Tally {
    count: usize,
    sum: f64,
    squares: f64,
    /// The largest squared distance.
    largest: f64,
    at: DVec3,
    offset: DVec3,
}

impl Tally {
    const NONE: Self = Self {
        count: 0,
        sum: 0.0,
        squares: 0.0,
        largest: -1.0,
        at: DVec3::ZERO,
        offset: DVec3::ZERO,
    };

    fn join(self, other: Self) -> Self {
        let worse = if other.largest > self.largest { other } else { self };
        Self {
            count: self.count + other.count,
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
            ..worse
        }
    }
}

fn measure(
    to: &Surface,
    count: usize,
    stops: &(dyn Fn() -> bool + Sync),
    points: impl Fn(Range<usize>) -> Vec<DVec3> + Sync,
) -> Tally {
    let blocks = parallel::per_block(count, |indices| {
        if stops() {
            return Tally::NONE;
        }
        let points = points(indices);
        let nearest = to.nearest_to_each(&points);
        points.iter().zip(nearest).fold(Tally::NONE, |tally, (&at, nearest)| {
            let Nearest { offset, squared, .. } = nearest;
            tally.join(Tally {
                count: 1,
                sum: squared.sqrt(),
                squares: squared,
                largest: squared,
                at,
                offset,
            })
        })
    });
    blocks.into_iter().fold(Tally::NONE, Tally::join)
}

/// Points inside the edges of a surface, equally spaced on each edge and at most `spacing` apart; shorter edges
/// have none. At most `limit` points per edge. If there are more than `most` points in all, the spacing is
/// multiplied and the limit divided by an integer until there are not.
#[must_use]
pub fn edge_points(surface: &Surface, spacing: f64, limit: usize, most: usize) -> Vec<DVec3> {
    let points = EdgePoints::new(surface, spacing, limit, most);
    points.points(0..points.count())
}

/// The points of [`edge_points`] on a single edge, from its end with the lower number to the other one.
pub fn points_of_edge(
    ends: [DVec3; 2],
    spacing: f64,
    limit: usize,
) -> impl Iterator<Item = DVec3> + use<> {
    let count = points_within(ends, spacing, limit);
    (0..count).map(move |i| point_within(ends, i, count))
}

fn ends_of(surface: &Surface, [a, b]: [u32; 2]) -> [DVec3; 2] {
    [surface.positions()[a as usize], surface.positions()[b as usize]]
}

/// The number of points inside an edge.
fn points_within([p, q]: [DVec3; 2], spacing: f64, limit: usize) -> usize {
    let squared = p.distance_squared(q);
    // Most edges are short; this saves the root and the quotient.
    if squared < SHORT * spacing * spacing {
        return 0;
    }
    ((squared.sqrt() / spacing) as usize).min(limit)
}

/// Slightly below 1, to be safe against rounding.
const SHORT: f64 = 0.999;

fn point_within([p, q]: [DVec3; 2], index: usize, count: usize) -> DVec3 {
    p + (q - p) * ((index + 1) as f64 / (count + 1) as f64)
}

/// Points inside the edges, equally spaced on each.
struct EdgePoints<'a> {
    surface: &'a Surface,
    edges: Vec<[u32; 2]>,
    /// The number of points up to and including each edge.
    ends: Vec<usize>,
}

impl<'a> EdgePoints<'a> {
    /// See [`edge_points`].
    fn new(surface: &'a Surface, spacing: f64, limit: usize, most: usize) -> Self {
        let count = |&edge: &[u32; 2]| points_within(ends_of(surface, edge), spacing, limit);
        let sides = |t: usize| {
            let [a, b, c] = surface.triangles()[t];
            [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)])
        };
        let mut edges: Vec<[u32; 2]> = parallel::concat_blocks(surface.triangle_count(), |range| {
            let mut edges: Vec<_> = range.flat_map(sides).filter(|side| count(side) > 0).collect();
            // The two faces at an edge are usually close together in the list.
            edges.sort_unstable();
            edges.dedup();
            edges.shrink_to_fit();
            edges
        });
        parallel::sort_by(&mut edges, Ord::cmp);
        edges.dedup();
        let mut points = Self { surface, edges, ends: Vec::new() };
        points.space(spacing, limit);
        let times = points.count().div_ceil(most.max(1));
        if times > 1 {
            points.space(spacing * times as f64, limit / times);
        }
        points
    }

    /// Sets the number of points on each edge.
    fn space(&mut self, spacing: f64, limit: usize) {
        let Self { surface, edges, .. } = self;
        let count = |i: usize| points_within(ends_of(surface, edges[i]), spacing, limit);
        self.ends = running_totals(parallel::collect(edges.len(), count));
    }

    fn count(&self) -> usize {
        self.ends.last().copied().unwrap_or(0)
    }

    fn points(&self, indices: Range<usize>) -> Vec<DVec3> {
        let mut edge = 0;
        let point = |index: usize| {
            edge = first_beyond(&self.ends, index, edge);
            let start = if edge == 0 { 0 } else { self.ends[edge - 1] };
            let ends = ends_of(self.surface, self.edges[edge]);
            point_within(ends, index - start, self.ends[edge] - start)
        };
        indices.map(point).collect()
    }
}
