//! Fitting: moves the vertices of a simplified mesh, and flips its edges, to bring it closer to the original.
//!
//! Each round
//!
//! 1. pairs samples of the original with the closest points of the mesh, and samples of the mesh
//!    with the closest points of the original;
//! 2. flips edges where that lowers the squared distance of the samples of the original;
//! 3. takes one Gauss-Newton step for the vertex positions `x`. Let `b` be the weights of a sample in its face, `p` its
//!    partner on the original, and `n` the normal there. The step minimises the sum of
//!    `(n·(Σ b x - p))² + pull |Σ b x - p|²` over all pairs, weighted by the [norm](crate::FitNorm).
//!
//! Boundary vertices move along the boundary of the original, and vertices on feature lines along these lines; corners
//! and fixed vertices stay. A vertex moves only as far as its faces keep their normals and, if intersections are
//! forbidden, do not intersect other faces. Limits on edges, angles and valences hold after each flip and each move. If
//! vertices have an importance, pairs weigh more where the original is more important.
//!
//! Points are spread evenly, ordered so that consecutive points are close in space, and processed in blocks. The
//! contribution of a face to the equations is summed in one place. Of each sample, only the position and the assigned
//! face are stored.

pub(crate) mod constraints;
mod element;
mod equations;
pub(crate) mod flips;
pub(crate) mod freedom;
mod lines;
pub(crate) mod moves;
mod pairs;
pub(crate) mod spread;
mod system;
mod targets;
mod walk;

use mesh_collapse::{NewIntersections, Phase};
use mesh_core::{EdgeId, FaceId, Handle, TriMesh, parallel};
use mesh_metric::Surface;

use crate::error::RefineError;
use crate::fit::constraints::FitConstraints;
use crate::fit::element::Weighting;
use crate::fit::equations::Equations;
use crate::fit::flips::flip_edges;
use crate::fit::freedom::{Freedom, freedoms};
use crate::fit::lines::Lines;
use crate::fit::moves::move_vertices;
use crate::fit::pairs::Pairs;
use crate::fit::system::System;
use crate::fit::targets::{Count, Targets};
use crate::norm::{FitNorm, Power};
use crate::observer::Observer;

pub(crate) use crate::fit::element::share_of_one;
pub(crate) use crate::fit::targets::FitTarget;

/// Options of [`fit`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FitOptions {
    /// Number of rounds. If there are several, the rounds of the first half usually use fewer samples than given here.
    /// If there are at least four, one is omitted when every triangle of the original has its own samples: the mesh is
    /// then nearly as fine as the original, and close to it from the start.
    pub rounds: usize,
    /// Samples of the original per face of the mesh.
    pub samples_per_face: usize,
    /// Samples of each face of the mesh. There are fewer if the face covers few triangles of the original, but at least
    /// twice the number per triangle.
    pub own_samples_per_face: usize,
    /// Largest number of samples per triangle of the original. If it would be exceeded, each triangle has exactly this
    /// number.
    pub samples_per_triangle: usize,
    /// The norm of the distances that the fit minimises, by flips as well.
    pub norm: FitNorm,
    /// Weight of the distance along the surface, relative to the distance along the normal. It holds vertices that
    /// nothing else holds. Other vertices are held along the surface by the variation of the normals around them, which
    /// decreases as the mesh becomes finer. So the pull is reduced on a mesh whose faces bend little from one to the
    /// next.
    pub pull: f64,
    /// Extra weight of the farthest pairs, and of vertices of the original that are about as far: a pair at the
    /// distance d has the weight 1 + tail (d / largest)^12. With 0 the mean square is minimised. Otherwise the largest
    /// distance falls at the expense of the mean.
    pub tail: f64,
    /// Whether edges are flipped.
    pub flips: bool,
    /// Whether faces must not intersect if they did not before.
    pub forbid_intersections: bool,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            rounds: 4,
            samples_per_face: 16,
            own_samples_per_face: 10,
            samples_per_triangle: 3,
            norm: FitNorm::L2,
            pull: 1e-4,
            tail: 0.0,
            flips: true,
            forbid_intersections: false,
            seed: 1,
        }
    }
}

/// The largest number of samples per face: more give no information, and would take too much memory.
pub(crate) const MOST_SAMPLES_PER_FACE: usize = 100_000;

/// The largest number of samples in total, so that 32-bit numbers suffice for samples and vertices.
const MOST_SAMPLES: usize = 1 << 31;

impl FitOptions {
    /// Checks that the options are in range.
    pub fn check(&self) -> Result<(), RefineError> {
        let is_weight = |x: f64| x >= 0.0 && x.is_finite();
        let weight = "at least 0 and finite";
        RefineError::unless(is_weight(self.pull), "fit pull", self.pull, weight)?;
        RefineError::unless(is_weight(self.tail), "fit tail", self.tail, weight)?;
        for (name, samples) in [
            ("fit samples_per_face", self.samples_per_face),
            ("fit own_samples_per_face", self.own_samples_per_face),
        ] {
            let fits = samples <= MOST_SAMPLES_PER_FACE;
            RefineError::unless(fits, name, samples as f64, "at most 100000")?;
        }
        Ok(())
    }
}

/// Report of [`fit`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FitReport {
    /// The norm that was minimised.
    pub norm: FitNorm,
    /// Number of rounds.
    pub rounds: usize,
    /// Number of flipped edges.
    pub flips: usize,
    /// Root mean square distance of the pairs at the start of the first round.
    pub rms_before: f64,
    /// Root mean square distance of the pairs at the start of the last round.
    pub rms_last: f64,
}

/// Fits a mesh to the original it was made from.
///
/// # Errors
/// An option is out of range, or the mesh has no faces.
pub fn fit(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &FitConstraints,
    options: &FitOptions,
) -> Result<FitReport, RefineError> {
    options.check()?;
    fit_observed(mesh, original, constraints, options, &mut Observer::none())
}

/// [`fit`] with an observer. If it stops the run, there are fewer rounds.
pub(crate) fn fit_observed(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &FitConstraints,
    options: &FitOptions,
    observer: &mut Observer<'_>,
) -> Result<FitReport, RefineError> {
    let faces: Vec<FaceId> = mesh.topology().faces().collect();
    let schedule = Cooling::new(options, faces.len(), original.triangle_count());
    let mut report = FitReport { norm: options.norm, ..FitReport::default() };
    let lines = Lines::new(mesh, original, constraints);
    let mut found = options.forbid_intersections.then(|| NewIntersections::new(mesh));
    let mut surface = Surface::new(mesh)?;
    let (mut kept, mut near): (Option<Pairs<'_>>, Option<Vec<_>>) = (None, None);
    for round in 0..schedule.rounds {
        if observer.stops(Phase::Fit, mesh) {
            break;
        }
        let counts = schedule.counts(round);
        if round > 0 {
            surface.follow(mesh)?;
        }
        let mut paired = match kept.take() {
            Some(mut paired) => {
                paired.follow(mesh, &surface);
                paired
            }
            None => {
                let targets = Targets::new(original, counts.targets, options.seed);
                let targets = targets.weighted(constraints.original_importance.as_deref());
                match near.take() {
                    Some(near) => Pairs::following(mesh, &surface, targets, &near),
                    None => Pairs::new(mesh, &surface, targets),
                }
            }
        };
        if round == 0 && paired.largest() <= nothing_to_gain(original) {
            report.rms_before = paired.mean(Power::SQUARE).sqrt();
            report.rms_last = report.rms_before;
            break;
        }
        let density = share_of_one(1) * faces.len() as f64 / paired.target_count().max(1) as f64;
        let power = options.norm.power(round);
        if options.tail > 0.0 {
            paired.push_far(&surface, original);
        }
        if options.flips {
            report.flips += flip_edges(mesh, &mut paired, constraints, power, found.as_mut());
        }
        let typical = if power == Power::SQUARE { 0.0 } else { paired.mean(power) };
        let largest = paired.largest();
        paired.forget_distances();
        let freedoms = freedoms(mesh, constraints);
        let mut system = System::new(mesh, &freedoms);
        lines.add_to(&mut system, mesh);
        let equations = Equations {
            mesh,
            original,
            faces: &faces,
            order: surface.in_space(),
            samples: counts.own,
            seed: options.seed.wrapping_add(round as u64 + 1),
            importance: constraints.original_importance.as_deref(),
        };
        let FitOptions { tail, .. } = *options;
        let pull = options.pull * (bend(mesh) / USUAL_BEND).clamp(LEAST_PULL, 1.0);
        let weighting = Weighting { pull, tail, largest, power, typical };
        let tally = equations.add_to(&mut system, weighting, |face, act| {
            paired.for_each_of(face, density, act);
        });
        report.rms_last = tally.rms();
        if round == 0 {
            report.rms_before = tally.rms();
        }
        let is_last = round + 1 == schedule.rounds;
        if is_last {
            drop(paired);
        } else if counts.targets == schedule.counts(round + 1).targets {
            kept = Some(paired);
        } else {
            near = Some(paired.faces_by_place(mesh, original.triangle_count()));
            drop(paired);
        }
        let mut moved = system.solve(mesh, &freedoms, constraints, ROUGHLY);
        let part = power.part_of_step();
        if part < 1.0 {
            moved.iter_mut().for_each(|(_, displacement)| *displacement *= part);
        }
        move_vertices(mesh, &moved, &freedoms, constraints, found.as_mut());
        report.rounds += 1;
    }
    Ok(report)
}

/// The squared distance below which a mesh is at the original, up to the rounding of coordinates in single precision. On
/// the flat parts of such a mesh the equations leave positions free, so that a step could only lead away.
fn nothing_to_gain(original: &Surface) -> f64 {
    let distance = f64::from(f32::EPSILON) * original.bounding_box().diagonal();
    distance * distance
}

/// Fits in which only a few vertices of a mesh move, and whose pairs are given.
pub(crate) struct LocalFit<'a> {
    original: &'a Surface,
    faces: Vec<FaceId>,
    lines: Lines,
}

impl<'a> LocalFit<'a> {
    /// A local fit for a mesh that keeps its connectivity.
    pub(crate) fn new(mesh: &TriMesh, original: &'a Surface, constraints: &FitConstraints) -> Self {
        let lines = Lines::new(mesh, original, constraints);
        Self { original, faces: mesh.topology().faces().collect(), lines }
    }

    /// Takes one step. `order` lists the indices of the faces so that consecutive faces are close in space,
    /// `targets_of` returns the targets of a face, and `largest` is the largest distance of all pairs.
    pub(crate) fn step(
        &self,
        mesh: &mut TriMesh,
        constraints: &FitConstraints,
        options: &FitOptions,
        (order, largest): (&[u32], f64),
        targets_of: impl Fn(FaceId, &mut dyn FnMut(&FitTarget)) + Sync,
    ) {
        let freedoms = freedoms(mesh, constraints);
        let moves = |&index: &u32| {
            let corners = mesh.topology().face_vertices(self.faces[index as usize]);
            corners.into_iter().any(|v| freedoms[v.index()] != Freedom::Fixed)
        };
        let order: Vec<u32> = order.iter().copied().filter(moves).collect();
        let mut system = System::new(mesh, &freedoms);
        self.lines.add_to(&mut system, mesh);
        let equations = Equations {
            mesh,
            original: self.original,
            faces: &self.faces,
            order: &order,
            samples: options.own_samples_per_face,
            seed: options.seed.wrapping_add(1),
            importance: None,
        };
        let FitOptions { pull, tail, .. } = *options;
        let largest = largest * largest;
        let (power, typical) = (Power::SQUARE, 0.0);
        let weighting = Weighting { pull, tail, largest, power, typical };
        equations.add_to(&mut system, weighting, targets_of);
        let moved = system.solve(mesh, &freedoms, constraints, CLOSELY);
        let mut found = options.forbid_intersections.then(|| NewIntersections::new(mesh));
        move_vertices(mesh, &moved, &freedoms, constraints, found.as_mut());
    }
}

/// The tolerance of the solver in fits of the whole mesh. More rounds follow, so more digits would have no effect.
const ROUGHLY: f64 = 1e-2;
/// The tolerance in local fits around the largest errors. They are small, and every digit counts.
const CLOSELY: f64 = 1e-4;

/// How much neighbouring faces differ in their normals: the mean of sin²(θ / 2) over the angles θ between the normals
/// of the two faces of each edge, weighted by area. On a smooth surface it is about the mean square of the angle
/// between a face and the surface.
fn bend(mesh: &TriMesh) -> f64 {
    let topology = mesh.topology();
    let at = |index: usize| {
        let edge = EdgeId::from_index(index);
        let faces = topology.contains_edge(edge).then(|| topology.edge_faces(edge));
        let Some([Some(left), Some(right)]) = faces else { return [0.0; 2] };
        let (left, right) = (mesh.face_cross(left), mesh.face_cross(right));
        let area = left.length() + right.length();
        let cosine = left.normalize_or_zero().dot(right.normalize_or_zero());
        [0.5 * (1.0 - cosine) * area, area]
    };
    let add = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a + c, b + d];
    let [bent, all] = parallel::fold(topology.edge_capacity(), [0.0; 2], at, add);
    if all > 0.0 { bent / all } else { 0.0 }
}

/// The bend at which a mesh gets the whole pull: the bend of a sphere of 500 faces.
const USUAL_BEND: f64 = 0.005;
/// The smallest factor on the pull, so that vertices on flat parts are held.
const LEAST_PULL: f64 = 0.01;

/// If a face covers this many triangles of the original, its own samples are as informative as the samples of one
/// triangle: they fall on the same triangles as its targets, and would repeat them.
const FEW: usize = 6;
/// The smallest number of own samples of a face, relative to the samples per triangle.
const FEWEST_OWN: usize = 2;
/// The number of own samples of a face that is enough for the first round.
const ROUGH_OWN: usize = 3;

/// With at least this many rounds, one can be omitted on a mesh that is close to the original.
const MANY_ROUNDS: usize = 4;

/// The number of points of both surfaces in a round.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Counts {
    /// Points of the original.
    targets: Count,
    /// Points of each face of the mesh.
    own: usize,
}

/// The number of rounds, and the number of points in each.
struct Cooling {
    rounds: usize,
    /// Counts of the first of several rounds.
    rough: Counts,
    /// Counts of the other rounds in the first half.
    middle: Counts,
    /// Counts of the remaining rounds.
    fine: Counts,
}

impl Cooling {
    /// The counts for this many faces of the mesh and triangles of the original.
    fn new(options: &FitOptions, faces: usize, triangles: usize) -> Self {
        let FitOptions { rounds, samples_per_face, samples_per_triangle, .. } = *options;
        let wanted = samples_per_face.saturating_mul(faces).min(MOST_SAMPLES);
        let least = samples_per_triangle.saturating_mul(FEWEST_OWN);
        let in_proportion = samples_per_triangle.saturating_mul(triangles) / (FEW * faces.max(1));
        let most = MOST_SAMPLES / faces.max(1);
        let own = options.own_samples_per_face.min(least.max(in_proportion)).min(most);
        // If the original has few triangles, each has the same number of points. They form a quadrature rule, and
        // no triangle is missed.
        let is_each = wanted >= samples_per_triangle.saturating_mul(triangles);
        let targets =
            if is_each { Count::OnEach(samples_per_triangle) } else { Count::About(wanted) };
        let fine = Counts { targets, own };
        // Half of the points or fewer suffice until the vertices are near their final positions, unless few points
        // represent many triangles. The number of own points of a face is even: with three, errors are 0.9 % larger
        // than with four, and with two 0.5 %.
        let (rough_own, middle_own) = (own.min(ROUGH_OWN), own.min(2 * own.div_ceil(4)));
        let (rough, middle) = match targets {
            Count::OnEach(count) => (
                Counts { targets: Count::OnEach(count.min(1)), own: rough_own },
                Counts { targets: Count::OnEach(count.div_ceil(2)), own: middle_own },
            ),
            Count::About(count) if count > triangles => (
                Counts { targets: Count::About(count / 2), own: rough_own },
                Counts { targets: Count::About(count / 2), own: middle_own },
            ),
            Count::About(_) => (fine, fine),
        };
        let left_out = usize::from(is_each && rounds >= MANY_ROUNDS);
        Self { rounds: rounds - left_out, rough, middle, fine }
    }

    fn counts(&self, round: usize) -> Counts {
        match round {
            // At least one round is a fine one.
            _ if round + 1 == self.rounds => self.fine,
            0 => self.rough,
            _ if round <= self.rounds / 2 => self.middle,
            _ => self.fine,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Cooling, Count, Counts, FitOptions, bend};
    use mesh_core::TriMesh;
    use mesh_shapes::Sphere;

    #[test]
    fn there_are_as_many_points_as_there_is_to_know() {
        let of = |rounds, faces, triangles| {
            let options = FitOptions { rounds, ..FitOptions::default() };
            let schedule = Cooling::new(&options, faces, triangles);
            let counts = (0..schedule.rounds).map(|round| schedule.counts(round));
            counts.map(|Counts { targets, own }| (targets, own)).collect::<Vec<_>>()
        };
        // Three triangles per face, then six, twenty, and many.
        let (each, about) = (Count::OnEach, Count::About);
        assert_eq!(of(4, 1000, 3000), [(each(1), 3), (each(2), 4), (each(3), 6)]);
        let [rough, middle, fine] = [(8_000, 3), (8_000, 4), (16_000, 6)];
        let expected = [rough, middle, middle, fine].map(|(count, own)| (about(count), own));
        assert_eq!(of(4, 1000, 6_000), expected);
        assert_eq!(of(4, 1000, 20_000), [(about(16_000), 10); 4]);
        assert_eq!(of(4, 1000, 500_000), [(about(16_000), 10); 4]);
        // A single round is a fine one, and so is the last of several.
        assert_eq!(of(0, 1000, 3000), []);
        assert_eq!(of(1, 1000, 3000), [(each(3), 6)]);
        assert_eq!(of(2, 1000, 3000), [(each(1), 3), (each(3), 6)]);
        assert_eq!(of(3, 1000, 3000), of(4, 1000, 3000));
        assert_eq!(of(9, 1000, 3000).iter().filter(|&&counts| counts == (each(3), 6)).count(), 3);
    }

    #[test]
    fn the_bend_of_a_fine_sphere_is_the_mean_square_of_the_angle_to_it() {
        let bend_of = |level| {
            let soup = Sphere { radius: 3.0 }.icosphere(level).unwrap();
            bend(&TriMesh::from_soup(&soup).unwrap())
        };
        // For an equilateral triangle with the squared side s², the expected value is s² / 12.
        let expected = |faces: f64| 4.0 * core::f64::consts::PI / faces * 4.0 / 3_f64.sqrt() / 12.0;
        assert!((bend_of(3) / expected(1280.0) - 1.0).abs() < 0.05);
        assert!((bend_of(3) / bend_of(4) / 4.0 - 1.0).abs() < 0.02);
    }
}
