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
//!    `(n·(Σ b x - p))² + pull |Σ b x - p|²` over all pairs, which count as the
//!    [norm](crate::FitNorm) wants.
//!
//! Boundary vertices slide along the boundary of the original, vertices on feature lines along
//! these; corners and fixed vertices stay. A vertex goes only as far as its faces keep their normals
//! and, if that is asked for, run into no others.

//!
//! Points are spread evenly, in an order in which neighbours are close to each other, and pass through
//! in blocks: what a face adds to the equations is summed up in one place, and nothing is kept of a
//! sample but where it is and which face it draws.

pub(crate) mod constraints;
mod element;
mod equations;
mod flips;
mod freedom;
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

/// How to fit; see [`fit`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FitOptions {
    /// How many rounds. The first of several, and those up to the half, are as a rule by fewer samples than is
    /// said here. Of four and more, one is left out where every triangle of the original has its samples: there
    /// the mesh is nearly as fine as that, and near its place from the beginning.
    pub rounds: usize,
    /// Samples of the original per face of the mesh.
    pub samples_per_face: usize,
    /// Samples of each face of the mesh; fewer where it has few triangles of the original to tell of, but at
    /// least twice as many as a triangle has.
    pub own_samples_per_face: usize,
    /// The most samples of the original per triangle of it: where there would be more, each triangle has so
    /// many.
    pub samples_per_triangle: usize,
    /// What is made small. Where edges are flipped, they are flipped for the same.
    pub norm: FitNorm,
    /// How strongly samples are drawn to their partners along the surface, relative to across it. It
    /// holds vertices where nothing else does. What draws others along the surface are the normals,
    /// which differ the less around a vertex the finer the mesh is: so on a mesh whose faces bend little
    /// from one to the next, the pull is less in the same measure.
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

/// The most samples per face: more than ever tell anything, and few enough for memory.
pub(crate) const MOST_SAMPLES_PER_FACE: usize = 100_000;

/// The most samples in all; together with the vertices, 32-bit numbers do for them.
const MOST_SAMPLES: usize = 1 << 31;

impl FitOptions {
    /// Whether the options make sense.
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

/// What a fit did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FitReport {
    /// What was made small.
    pub norm: FitNorm,
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
) -> Result<FitReport, RefineError> {
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
                match near.take() {
                    Some(near) => Pairs::following(mesh, &surface, targets, &near),
                    None => Pairs::new(mesh, &surface, targets),
                }
            }
        };
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

/// Fits in which a few vertices of a mesh move; their pairs are known.
pub(crate) struct LocalFit<'a> {
    original: &'a Surface,
    faces: Vec<FaceId>,
    lines: Lines,
}

impl<'a> LocalFit<'a> {
    /// For a mesh that keeps its connectivity.
    pub(crate) fn new(mesh: &TriMesh, original: &'a Surface, constraints: &FitConstraints) -> Self {
        let lines = Lines::new(mesh, original, constraints);
        Self { original, faces: mesh.topology().faces().collect(), lines }
    }

    /// Takes one step. `order` are the indices of the faces, neighbours in space close to each other;
    /// `targets_of` says what a face draws, and `largest` is the largest distance of all pairs.
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

/// Steps of the whole mesh are cut short and rounds follow: more digits make no difference.
const ROUGHLY: f64 = 1e-2;
/// Those around the largest errors are few, and count to the end.
const CLOSELY: f64 = 1e-4;

/// How much the normals of the faces differ at the edges: the mean of sin²(θ / 2) over the angles θ
/// between the two normals, by the areas of the faces. On a smooth surface that is about the mean square
/// of the angle between a face and the surface.
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

/// The bend of a mesh that takes the whole pull: that of a sphere of 500 faces.
const USUAL_BEND: f64 = 0.005;
/// The least part of the pull, so that vertices on flat ground are held.
const LEAST_PULL: f64 = 0.01;

/// Of so many triangles of the original the points of a face tell as much as those of one: the others lie on
/// the same triangles as its targets, where they say the same.
const FEW: usize = 6;
/// So many times the samples per triangle a face has nevertheless.
const FEWEST_OWN: usize = 2;
/// Points of a face that are enough for the first round.
const ROUGH_OWN: usize = 3;

/// Of so many rounds, one is not worth its time on a mesh that is near its place.
const MANY_ROUNDS: usize = 4;

/// How many points there are of both surfaces in a round.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Counts {
    /// Of the original.
    targets: Count,
    /// Of each face of the mesh.
    own: usize,
}

/// How many rounds there are, and with how many points.
struct Cooling {
    rounds: usize,
    /// Of the first of several rounds.
    rough: Counts,
    /// Of the others in the first half.
    middle: Counts,
    /// Of the rest.
    fine: Counts,
}

impl Cooling {
    /// For so many faces of the mesh and triangles of the original.
    fn new(options: &FitOptions, faces: usize, triangles: usize) -> Self {
        let FitOptions { rounds, samples_per_face, samples_per_triangle, .. } = *options;
        let wanted = samples_per_face.saturating_mul(faces).min(MOST_SAMPLES);
        let least = samples_per_triangle.saturating_mul(FEWEST_OWN);
        let in_proportion = samples_per_triangle.saturating_mul(triangles) / (FEW * faces.max(1));
        let most = MOST_SAMPLES / faces.max(1);
        let own = options.own_samples_per_face.min(least.max(in_proportion)).min(most);
        // As many of each triangle where these are few: then they are the points of a quadrature, and no
        // triangle goes unseen.
        let is_each = wanted >= samples_per_triangle.saturating_mul(triangles);
        let targets =
            if is_each { Count::OnEach(samples_per_triangle) } else { Count::About(wanted) };
        let fine = Counts { targets, own };
        // Until the vertices are near their places, half of the points and less say as well where these are, unless
        // few have to speak for many triangles. An even number of a face's own points: with three, errors are .9 %
        // larger than with four, and with two .5 %.
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
            // There is a fine one in any case.
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
        // Three triangles a face, six, twenty, and many.
        let (each, about) = (Count::OnEach, Count::About);
        assert_eq!(of(4, 1000, 3000), [(each(1), 3), (each(2), 4), (each(3), 6)]);
        let [rough, middle, fine] = [(8_000, 3), (8_000, 4), (16_000, 6)];
        let expected = [rough, middle, middle, fine].map(|(count, own)| (about(count), own));
        assert_eq!(of(4, 1000, 6_000), expected);
        assert_eq!(of(4, 1000, 20_000), [(about(16_000), 10); 4]);
        assert_eq!(of(4, 1000, 500_000), [(about(16_000), 10); 4]);
        // One round is a fine one, and the last one always is.
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
        // Of an equilateral triangle with the squared side s²: s² / 12.
        let expected = |faces: f64| 4.0 * core::f64::consts::PI / faces * 4.0 / 3_f64.sqrt() / 12.0;
        assert!((bend_of(3) / expected(1280.0) - 1.0).abs() < 0.05);
        assert!((bend_of(3) / bend_of(4) / 4.0 - 1.0).abs() < 0.02);
    }
}
