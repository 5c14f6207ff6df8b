//! Annealing of the layout, and exchange of faces between places with small and large errors.
//!
//! First the mesh is laid out again from coarse to fine, see [`multiresolution`](super::multiresolution). If the new
//! layout is better, several other layouts are tried. If none is better, the vertices and edges of the mesh itself are
//! annealed, see [`vertex_relocation`](super::vertex_relocation).
//!
//! Then rounds of exchange follow. Each round splits some random edges, with a probability that grows with the local
//! error; fits; collapses the cheapest edges until the number of faces is as before; and fits again. The result is kept
//! if it is closer to the original. The number of splits grows after a round that was kept and shrinks after one that
//! was not, so that about one round in five is kept.

use core::time::Duration;
use std::time::Instant;

use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::{EdgeId, Handle, TriMesh, VertexId, VertexMap};
use mesh_metric::{Surface, SurfaceError, sample_surface};

use crate::collapse_back::{CollapseBack, collapse_back};
use crate::density::Density;
use crate::error::RefineError;
use crate::fit::constraints::FitConstraints;
use crate::fit::{FitOptions, MOST_SAMPLES_PER_FACE, fit_observed};
use crate::multiresolution::{CoarseStarts, Multiresolution, counterparts, lay_out_nested};
use crate::norm::Power;
use crate::observer::Observer;
use crate::vertex_relocation::{Cooling, anneal_layout};
use mesh_collapse::{Boundary, Phase};

/// Options of [`anneal`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AnnealOptions {
    /// Number of sweeps of jumps, flips and smoothing; 0 for none.
    pub sweeps: usize,
    /// Length of the first jumps of vertices, relative to the mean length of their edges.
    pub jump: f64,
    /// Number of layouts to try on a smooth surface, at least 1. At each finer stage only the closest quarter of them
    /// continues, so that 16 layouts take two to four times as long as one.
    pub starts: usize,
    /// Time limit of annealing. The only option that makes results depend on the machine.
    pub time_limit: Option<Duration>,
    /// Largest number of rounds of exchange. They end earlier when even a single split no longer helps.
    pub rounds: usize,
    /// Ratio of faces of the original to faces of the mesh that is required for each round, so that the rounds take a
    /// small part of the time of the collapses; 0 for `rounds` rounds in any case.
    pub reduction_per_round: f64,
    /// Share of the edges that are split in the first round. Later rounds adapt it to the success rate.
    pub share: f64,
    /// Samples per face for the measurement of errors.
    pub samples_per_face: usize,
    /// Options of the fit after each change.
    pub fit: FitOptions,
}

impl Default for AnnealOptions {
    fn default() -> Self {
        let fit = FitOptions {
            rounds: 2,
            samples_per_face: 20,
            own_samples_per_face: 20,
            ..FitOptions::default()
        };
        Self {
            sweeps: 160,
            jump: 0.2,
            starts: 16,
            time_limit: None,
            rounds: 200,
            reduction_per_round: 0.0,
            share: 0.05,
            samples_per_face: 120,
            fit,
        }
    }
}

impl AnnealOptions {
    /// Checks that the options are in range.
    pub fn check(&self) -> Result<(), RefineError> {
        let is_length = self.jump >= 0.0 && self.jump.is_finite();
        RefineError::unless(is_length, "anneal jump", self.jump, "at least 0 and finite")?;
        RefineError::unless(self.starts > 0, "anneal starts", 0.0, "at least 1")?;
        let reduction = self.reduction_per_round;
        let is_ratio = reduction >= 0.0 && reduction.is_finite();
        let name = "anneal reduction_per_round";
        RefineError::unless(is_ratio, name, reduction, "at least 0 and finite")?;
        let is_part = (0.0..=1.0).contains(&self.share);
        RefineError::unless(is_part, "anneal share", self.share, "between 0 and 1")?;
        let samples = self.samples_per_face;
        let fits = (1..=MOST_SAMPLES_PER_FACE).contains(&samples);
        let name = "anneal samples_per_face";
        RefineError::unless(fits, name, samples as f64, "between 1 and 100000")?;
        self.fit.check()
    }

    /// Whether there is anything to do for a mesh with the options. If not, [`anneal`] only measures it.
    #[must_use]
    pub fn has_work(&self, mesh: &TriMesh, original: &Surface) -> bool {
        self.sweeps > 0 || self.rounds_for(mesh, original) > 0
    }

    /// The largest number of rounds of exchange.
    fn rounds_for(&self, mesh: &TriMesh, original: &Surface) -> usize {
        if self.reduction_per_round == 0.0 {
            return self.rounds;
        }
        let faces = mesh.topology().face_count().max(1);
        let reduction = original.triangle_count() as f64 / faces as f64;
        self.rounds.min((reduction / self.reduction_per_round) as usize)
    }
}

/// The smallest number of rounds of the final fit of a layout.
const SETTLE: usize = 6;

/// Factors on the share of split edges after a round that was kept, and after a round that was not. The share is stable
/// if one round in five is kept, which is best for such searches (Rechenberg 1973).
const MORE: f64 = 1.3;
const LESS: f64 = 0.9365;
/// The upper limit of the share, unless the options ask for a larger one.
const LARGEST_SHARE: f64 = 0.1;
/// If the share is less than this number of edges, the search ends: several rounds with one edge have failed before.
const LEAST_EDGES: f64 = 0.3;

/// Report of [`anneal`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AnnealReport {
    /// Number of layouts made from coarse to fine; more than one if the first one was better than the input.
    pub layouts: usize,
    /// Number of sweeps of all layouts.
    pub sweeps: usize,
    /// Whether the new layout was better, and kept.
    pub is_layout_kept: bool,
    /// Number of rounds of exchange.
    pub rounds: usize,
    /// Number of rounds that were kept.
    pub kept: usize,
    /// The root mean square distance of the original from the mesh at the start.
    pub rms_before: f64,
    /// That distance at the end.
    pub rms_after: f64,
    /// For each vertex of the input mesh, the vertex of the result that it corresponds to.
    pub vertex_map: VertexMap<Option<VertexId>>,
}

/// Anneals a mesh without gaps towards the original that it was made from. The number of faces does not rise, and
/// `constraints` follow the mesh. The boundary stays.
///
/// # Errors
/// An option is out of range, or the mesh has no faces.
pub fn anneal(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &mut FitConstraints,
    options: &AnnealOptions,
) -> Result<AnnealReport, RefineError> {
    options.check()?;
    anneal_observed(mesh, original, constraints, options, &mut Observer::none())
}

/// [`anneal`] with an observer. If it stops the run, there are fewer rounds.
pub(crate) fn anneal_observed(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &mut FitConstraints,
    options: &AnnealOptions,
    observer: &mut Observer<'_>,
) -> Result<AnnealReport, RefineError> {
    let faces = mesh.topology().face_count();
    let samples = sample_surface(
        original,
        options.samples_per_face.saturating_mul(faces).min(u32::MAX as usize),
        options.fit.seed,
    );
    let importance = constraints.original_importance.as_deref();
    let points = Points {
        places: samples.iter().map(|sample| sample.position).collect(),
        importance: importance
            .map(|of| samples.iter().map(|sample| of[sample.triangle as usize]).collect()),
    };
    let power = options.fit.norm.last_power();
    let mut state = State::new(mesh.clone(), constraints.clone(), &points, power)?;
    let rms_before = state.rms();
    let schedule = Cooling {
        sweeps: options.sweeps,
        jump: options.jump,
        seed: options.fit.seed,
        forbid_intersections: options.fit.forbid_intersections,
        deadline: options.time_limit.and_then(|limit| Instant::now().checked_add(limit)),
        is_smooth: false,
    };
    let search = LevelSearch { original, points: &points, options, most_faces: faces, schedule };
    let laid_out = search.lay_out(&mut state, observer)?;
    let (rounds, kept) = search.trade(&mut state, observer)?;
    let rms_after = state.rms();
    (*mesh, *constraints) = (state.mesh, state.constraints);
    let LaidOut { layouts, sweeps, is_kept: is_layout_kept } = laid_out;
    Ok(AnnealReport {
        layouts,
        sweeps,
        is_layout_kept,
        rounds,
        kept,
        rms_before,
        rms_after,
        vertex_map: state.map,
    })
}

/// Input of the search for a better layout.
struct LevelSearch<'a> {
    original: &'a Surface,
    points: &'a Points,
    options: &'a AnnealOptions,
    most_faces: usize,
    schedule: Cooling,
}

/// Report of [`LevelSearch::lay_out`].
#[derive(Default)]
struct LaidOut {
    layouts: usize,
    sweeps: usize,
    is_kept: bool,
}

impl LevelSearch<'_> {
    /// Tries other layouts, and takes the closest one.
    fn lay_out(
        &self,
        state: &mut State,
        observer: &mut Observer<'_>,
    ) -> Result<LaidOut, RefineError> {
        let &Self { original, points, options, ref schedule, .. } = self;
        let mut done = LaidOut::default();
        if options.sweeps == 0 || observer.is_stopped() {
            return Ok(done);
        }
        let (fit, power) = (&options.fit, state.power);
        let settle = FitOptions { rounds: fit.rounds.max(SETTLE), ..*fit };
        let (mesh, constraints) = (state.mesh.clone(), state.constraints.clone());
        let density = &Density::new(&mesh, original, power)?;
        // The other layouts are tried only if the first one is better, which means that the surface is smooth.
        for starts in [0..1, 1..options.starts] {
            if starts.is_empty() || (starts.start > 0 && !done.is_kept) {
                break;
            }
            let count = starts.len();
            let beginnings =
                CoarseStarts { starts, schedule, density, fit, points: &points.places, power };
            let nested = lay_out_nested(&mesh, original, &constraints, &beginnings, observer)?;
            let Some(Multiresolution { mesh: mut next, constraints, sweeps }) = nested else {
                break;
            };
            done.layouts += count;
            done.sweeps += sweeps;
            fit_observed(&mut next, original, &constraints, &settle, observer)?;
            let map = counterparts(&mesh, &next)?;
            let next = State { map, ..State::new(next, constraints, points, power)? };
            if next.sum < state.sum {
                done.is_kept = true;
                *state = next;
            }
        }
        if !done.is_kept {
            let mut next = mesh;
            let with = (schedule, &mut density.clone());
            done.sweeps += anneal_layout(&mut next, original, &constraints, with, observer);
            fit_observed(&mut next, original, &constraints, &settle, observer)?;
            let next = State::new(next, constraints, points, power)?;
            done.is_kept = next.sum < state.sum;
            if done.is_kept {
                *state = next;
            }
        }
        Ok(done)
    }

    /// Exchanges faces. Returns the number of rounds, and the number of rounds that were kept.
    fn trade(
        &self,
        state: &mut State,
        observer: &mut Observer<'_>,
    ) -> Result<(usize, usize), RefineError> {
        let &Self { original, points, options, most_faces, .. } = self;
        let mut share = options.share;
        let mut random = SplitMix64::new(options.fit.seed);
        let most_rounds = options.rounds_for(&state.mesh, original);
        let (mut rounds, mut kept) = (0, 0);
        while rounds < most_rounds {
            let is_in_vain = share * (state.mesh.topology().edge_count() as f64) < LEAST_EDGES;
            if is_in_vain || self.schedule.is_over() || observer.stops(Phase::Anneal, &state.mesh) {
                break;
            }
            let seed = options.fit.seed.wrapping_add(rounds as u64);
            let fit = FitOptions { seed, ..options.fit };
            let edges = state.edges_to_cut(share, &mut random);
            let next = state.step(original, points, &edges, &fit, observer)?;
            rounds += 1;
            if next.topology_faces() <= most_faces && next.sum < state.sum {
                *state = next;
                kept += 1;
                share = (MORE * share).min(LARGEST_SHARE.max(options.share));
            } else {
                // Smaller changes are more likely to succeed.
                share *= LESS;
            }
        }
        Ok((rounds, kept))
    }
}

/// Points of the original, at which meshes are compared.
struct Points {
    places: Vec<DVec3>,
    /// The factor on the power of the distance of each; `None` for 1.
    importance: Option<Vec<f64>>,
}

/// A mesh and its error.
struct State {
    mesh: TriMesh,
    constraints: FitConstraints,
    map: VertexMap<Option<VertexId>>,
    power: Power,
    /// The sums of the powers of the sample distances: for each face, over the samples closest to it, and in total.
    of_face: Vec<f64>,
    sum: f64,
    /// The sum of the squared distances of all samples.
    squares: f64,
    samples: usize,
}

impl State {
    fn new(
        mesh: TriMesh,
        constraints: FitConstraints,
        points: &Points,
        power: Power,
    ) -> Result<Self, SurfaceError> {
        let identity = (0..mesh.topology().vertex_capacity()).map(VertexId::from_index).map(Some);
        let map = VertexMap::from_vec(identity.collect());
        let state = Self {
            mesh,
            constraints,
            map,
            power,
            of_face: Vec::new(),
            sum: 0.0,
            squares: 0.0,
            samples: points.places.len(),
        };
        state.measured(points)
    }

    fn measured(mut self, points: &Points) -> Result<Self, SurfaceError> {
        self.of_face = vec![0.0; self.mesh.topology().face_capacity()];
        let closest = Surface::new(&self.mesh)?.closest_points(&points.places);
        for (index, closest) in closest.into_iter().enumerate() {
            let squared = closest.offset.length_squared();
            let importance = points.importance.as_ref().map_or(1.0, |all| all[index]);
            self.of_face[closest.face.index()] += importance * self.power.of(squared);
            self.squares += squared;
        }
        self.sum = self.of_face.iter().sum();
        Ok(self)
    }

    fn rms(&self) -> f64 {
        (self.squares / self.samples.max(1) as f64).sqrt()
    }

    fn topology_faces(&self) -> usize {
        self.mesh.topology().face_count()
    }

    /// The next state after some edges are split, whether it is better or not.
    fn step(
        &self,
        original: &Surface,
        points: &Points,
        cut: &[EdgeId],
        options: &FitOptions,
        observer: &mut Observer<'_>,
    ) -> Result<Self, RefineError> {
        let mut mesh = self.mesh.clone();
        for &edge in cut {
            let [a, b] = mesh.segment(edge);
            let middle = a + 0.5 * (b - a);
            if self.constraints.limits.allow_edge_split(&mesh, edge, middle)
                && let Ok(split) = mesh.topology().check_split_edge(edge)
            {
                mesh.split_edge(split, middle);
            }
        }
        let once = FitOptions { rounds: 1, ..*options };
        fit_observed(&mut mesh, original, &self.constraints, &once, observer)?;
        let to = CollapseBack {
            faces: self.topology_faces(),
            locked: &[],
            boundary: Boundary::Lock,
            forbid_intersections: options.forbid_intersections,
            // No component gets smaller than it was before the splits.
            min_component_vertices: None,
            first: None,
        };
        let back = collapse_back(&mut mesh, &self.constraints, &to, Phase::Anneal, observer);
        let vertex_map = |v: VertexId| back.vertex_map.get(v).copied().flatten();
        let map = self.map.as_slice().iter().map(|v| v.and_then(vertex_map));
        let map = VertexMap::from_vec(map.collect());
        let constraints = back.constraints;
        fit_observed(&mut mesh, original, &constraints, options, observer)?;
        let (of_face, sum, squares) = (Vec::new(), 0.0, 0.0);
        let (power, samples) = (self.power, points.places.len());
        Self { mesh, constraints, map, power, of_face, sum, squares, samples }
            .measured(points)
            .map_err(RefineError::from)
    }

    /// Random edges to split, in the given share, with probabilities proportional to the errors of their faces. No two
    /// of them belong to the same face.
    fn edges_to_cut(&self, share: f64, random: &mut SplitMix64) -> Vec<EdgeId> {
        let topology = self.mesh.topology();
        let error = |e: EdgeId| {
            let faces = topology.edge_faces(e).into_iter().flatten();
            faces.map(|f| self.of_face[f.index()]).sum::<f64>()
        };
        let may_be_cut =
            |&e: &EdgeId| !topology.is_boundary_edge(e) && !self.constraints.is_held(e);
        let candidates = topology.edges().filter(may_be_cut);
        // Weighted sampling: each edge waits for a random time with an exponential distribution whose rate is its
        // error, and the first edges are taken (Efraimidis and Spirakis 2006).
        let mut waiting: Vec<(f64, EdgeId)> =
            candidates.map(|e| (-random.uniform().ln() / error(e), e)).collect();
        waiting.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        let count = ((share * topology.edge_count() as f64) as usize).max(1);
        let mut used = vec![false; topology.face_capacity()];
        let mut chosen = Vec::with_capacity(count);
        for (_, e) in waiting {
            let faces = topology.edge_faces(e);
            if faces.iter().flatten().any(|f| used[f.index()]) {
                continue;
            }
            faces.iter().flatten().for_each(|f| used[f.index()] = true);
            chosen.push(e);
            if chosen.len() == count {
                break;
            }
        }
        chosen
    }
}
