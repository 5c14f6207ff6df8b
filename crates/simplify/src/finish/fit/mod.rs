//! Moving the vertices of a simplified mesh, and flipping its edges, to come closer to the
//! original.
//!
//! Each round
//!
//! 1. pairs samples of the original with the closest points of the mesh, and samples of the mesh
//!    with the closest points of the original;
//! 2. flips edges where that lowers the squared distance of the samples of the original;
//! 3. takes one Gauss-Newton step for the vertex positions `x`: with the weights `b` of a sample in
//!    its face, its partner `p` on the original and the normal `n` there, it minimises the sum of
//!    `(n·(Σ b x - p))² + pull |Σ b x - p|²` over all pairs.
//!
//! Boundary vertices slide along the boundary of the original, vertices on feature lines along
//! these; corners and fixed vertices stay. A vertex goes only as far as its faces keep their normals
//! and, if that is asked for, run into no others.

pub(crate) mod constraints;
mod flips;
mod freedom;
mod lines;
pub(crate) mod moves;
mod pairs;
mod system;

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_metric::{ClosestPoint, Surface, SurfaceSample, sample_surface, weights_of_closest};

use crate::collapse::intersection::Intersections;
use crate::collapse::run::Phase;
use crate::error::SimplifyError;
use crate::finish::fit::constraints::FitConstraints;
use crate::finish::fit::flips::flip_edges;
use crate::finish::fit::freedom::freedoms;
use crate::finish::fit::lines::Lines;
use crate::finish::fit::moves::move_vertices;
use crate::finish::fit::pairs::{Pairs, Target};
use crate::finish::fit::system::{System, Weighting};
use crate::finish::observer::Observer;

/// How to fit; see [`fit`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FitOptions {
    /// How many rounds.
    pub rounds: usize,
    /// Samples per face of the mesh, in each direction.
    pub samples_per_face: usize,
    /// How strongly samples are drawn to their partners along the surface, relative to across it.
    pub pull: f64,
    /// How much more than the others the farthest pairs count, and the vertices of the original
    /// that are about as far: the weight of a pair at the distance d is 1 + tail (d / largest)^12.
    /// With 0 the mean square is minimised; otherwise the largest distance becomes smaller at the
    /// expense of the mean.
    pub tail: f64,
    /// Whether edges are flipped.
    pub flips: bool,
    /// Whether faces must not come to cross that did not before.
    pub forbid_intersections: bool,
    /// Where the random numbers start.
    pub seed: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            rounds: 2,
            samples_per_face: 30,
            pull: 4e-4,
            tail: 0.0,
            flips: true,
            forbid_intersections: false,
            seed: 1,
        }
    }
}

/// The most samples per face: more than ever tell anything, and few enough for memory.
pub(crate) const MOST_SAMPLES_PER_FACE: usize = 100_000;

/// The most samples in all; together with the vertices, 32-bit numbers do for them.
const MOST_SAMPLES: usize = 1 << 31;

impl FitOptions {
    /// Whether the options make sense.
    pub(crate) fn check(&self) -> Result<(), SimplifyError> {
        let is_weight = |x: f64| x >= 0.0 && x.is_finite();
        let weight = "at least 0 and finite";
        SimplifyError::unless(is_weight(self.pull), "fit pull", self.pull, weight)?;
        SimplifyError::unless(is_weight(self.tail), "fit tail", self.tail, weight)?;
        let samples = self.samples_per_face;
        let fits = samples <= MOST_SAMPLES_PER_FACE;
        let name = "fit samples_per_face";
        SimplifyError::unless(fits, name, samples as f64, "at most 100000")
    }
}

/// What a fit did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FitReport {
    /// How many rounds were made.
    pub rounds: usize,
    /// How many edges were flipped.
    pub flips: usize,
    /// Root mean square distance of the pairs at the start of the first round.
    pub rms_before: f64,
    /// Root mean square distance of the pairs at the start of the last round.
    pub rms_last: f64,
}

/// Fits a mesh to the original it was made from.
///
/// # Errors
/// An option makes no sense, or the mesh has no faces.
pub fn fit(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &FitConstraints,
    options: &FitOptions,
) -> Result<FitReport, SimplifyError> {
    options.check()?;
    fit_observed(mesh, original, constraints, options, &mut Observer::none())
}

/// The same, until the observer says to stop: then with fewer rounds.
pub(crate) fn fit_observed(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &FitConstraints,
    options: &FitOptions,
    observer: &mut Observer<'_>,
) -> Result<FitReport, SimplifyError> {
    let count = options.samples_per_face.saturating_mul(mesh.topology().face_count());
    let count = count.min(MOST_SAMPLES);
    let targets: Vec<Target> = sample_surface(original, count, options.seed)
        .iter()
        .map(|sample| Target::of_sample(original, sample))
        .collect();
    let points: Vec<DVec3> = targets.iter().map(|target| target.point).collect();
    let rough_targets: Vec<Target> = targets.iter().step_by(2).copied().collect();
    let rough_points: Vec<DVec3> = rough_targets.iter().map(|target| target.point).collect();
    let mut report = FitReport::default();
    let lines = Lines::new(mesh, original, constraints, count);
    let mut found = options.forbid_intersections.then(|| Intersections::new(mesh));
    for round in 0..options.rounds {
        if observer.stops(Phase::Fit, mesh) {
            break;
        }
        let surface = Surface::new(mesh)?;
        let mut paired = Pairs::new(mesh);
        // The first of several rounds is a rough one.
        let part = if round + 1 < options.rounds && round == 0 { 2 } else { 1 };
        let (targets, points, count) = match part {
            1 => (&targets, &points, count),
            _ => (&rough_targets, &rough_points, count / 2),
        };
        for (target, closest) in targets.iter().zip(surface.closest_points(points)) {
            paired.push(&closest, *target);
        }
        if options.tail > 0.0 {
            paired.push_far(&surface, original);
        }
        if options.flips {
            report.flips += flip_edges(mesh, &mut paired, constraints, found.as_mut());
        }
        let freedoms = freedoms(mesh, constraints);
        let mut system = System::new(mesh);
        lines.add_to(&mut system, mesh);
        let mut tally = Tally::default();
        let FitOptions { pull, tail, .. } = *options;
        let weighting = Weighting { pull, tail, largest: paired.largest() };
        paired.for_each(mesh, |face, target| {
            let weights = weights_of_closest(target.point, &mesh.triangle(face));
            tally.add(system.add(mesh, face, weights, target, weighting));
        });
        let seed = options.seed.wrapping_add(round as u64 + 1);
        let samples = if options.flips {
            // The faces are others now.
            sample_surface(&Surface::new(mesh)?, count, seed)
        } else {
            sample_surface(&surface, count, seed)
        };
        add_own_samples(mesh, original, &samples, weighting, &mut system, &mut tally);
        report.rms_last = tally.rms();
        if round == 0 {
            report.rms_before = tally.rms();
        }
        let moved = system.solve(mesh, &freedoms, constraints);
        move_vertices(mesh, &moved, &freedoms, constraints, found.as_mut());
        report.rounds += 1;
    }
    Ok(report)
}

fn add_own_samples(
    mesh: &TriMesh,
    original: &Surface,
    samples: &[SurfaceSample],
    weighting: Weighting,
    system: &mut System,
    tally: &mut Tally,
) {
    let faces: Vec<FaceId> = mesh.topology().faces().collect();
    let points: Vec<DVec3> = samples.iter().map(|sample| sample.position).collect();
    let closest = original.closest_points(&points);
    let largest =
        closest.iter().map(|c| c.offset.length_squared()).fold(weighting.largest, f64::max);
    let weighting = Weighting { largest, ..weighting };
    for (sample, closest) in samples.iter().zip(closest) {
        let ClosestPoint { point, triangle, .. } = closest;
        let target = Target::on_triangle(original, triangle, point);
        let face = faces[sample.triangle as usize];
        tally.add(system.add(mesh, face, DVec3::from(sample.weights), target, weighting));
    }
}

#[derive(Default)]
struct Tally {
    squares: f64,
    count: usize,
}

impl Tally {
    fn add(&mut self, squared: f64) {
        self.squares += squared;
        self.count += 1;
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }
}
