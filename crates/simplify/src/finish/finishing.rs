//! What comes after the collapses: fitting, annealing, peaks, and the search for a coarse mesh within
//! an error.

use core::ops::ControlFlow;
use std::sync::Arc;

use glam::DVec3;
use mesh_core::{EdgeMap, Remap, RemapOf, TriMesh, VertexId, VertexMap};
use mesh_metric::{
    CertifyOptions, CompareOptions, Comparison, Surface, compare, hausdorff_bounds, sample_surface,
};

use crate::collapse::constraint::Boundary;
use crate::collapse::driver::Run;
use crate::collapse::stop::Limits;
use crate::finish::anneal::{AnnealOptions, AnnealReport, anneal};
use crate::finish::collapse_back::CollapseBack;
use crate::finish::curve::Curve;
use crate::finish::fit::constraints::FitConstraints;
use crate::finish::fit::{FitOptions, FitReport, fit};
use crate::finish::peaks::{PeakOptions, PeakReport, cut_peaks};
use crate::finish::texture_fit::{TextureCheck, fit_unfolded};
use crate::limit::squeeze::squeeze;
use crate::options::{ErrorCheck, Options};
use crate::simplify::{AchievedError, SimplifyError, collapse};

/// A mesh after some collapses, without gaps.
pub(crate) struct Level {
    pub(crate) mesh: TriMesh,
    /// From the handles of the original.
    pub(crate) remap: Remap,
    fixed: Option<VertexMap<bool>>,
    features: Option<EdgeMap<bool>>,
    /// For each vertex of the original, the one that it has become.
    became: VertexMap<Option<VertexId>>,
}

impl Level {
    /// The mesh after the first `collapses` of a run.
    pub(crate) fn new(mut mesh: TriMesh, run: &Run, collapses: usize) -> Self {
        let became = run.log.representatives(&mesh, collapses);
        let remap = mesh.compact();
        let fixed = run.locked.as_ref().map(|map| map.compact(&remap));
        let features = run.features.as_ref().map(|map| map.compact(&remap));
        let became = became.as_slice().iter().map(|&v| remap.new_handle(v));
        let became = VertexMap::from_vec(became.collect());
        Self { mesh, remap, fixed, features, became }
    }
}

/// A level and what was done with it since.
pub(crate) struct Finished {
    pub(crate) mesh: TriMesh,
    /// For each vertex of the level, the one that it has become; `None` when they are the same.
    pub(crate) vertex_map: Option<VertexMap<Option<VertexId>>>,
    pub(crate) error: Option<AchievedError>,
    pub(crate) fit: Option<FitReport>,
    pub(crate) anneal: Option<AnnealReport>,
    pub(crate) peaks: Option<PeakReport>,
    /// What holds for the mesh as it is now.
    constraints: FitConstraints,
}

impl Finished {
    pub(crate) fn untouched(mesh: TriMesh) -> Self {
        let constraints = FitConstraints::default();
        Self {
            mesh,
            vertex_map: None,
            error: None,
            fit: None,
            anneal: None,
            peaks: None,
            constraints,
        }
    }

    /// Goes on to the next mesh, unless more faces turn over in the texture there.
    fn take_unfolded(
        &mut self,
        next: TriMesh,
        then: &VertexMap<Option<VertexId>>,
        texture: Option<&TextureCheck<'_>>,
    ) -> bool {
        let before = self.vertex_map.clone();
        let folds = texture.map_or(0, |check| check.folded_after(&self.mesh, before.as_ref()));
        self.follow(then);
        let then = self.vertex_map.as_ref();
        if texture.is_some_and(|check| check.folded_after(&next, then) > folds) {
            self.vertex_map = before;
            return false;
        }
        self.mesh = next;
        true
    }

    fn follow(&mut self, then: &VertexMap<Option<VertexId>>) {
        match &mut self.vertex_map {
            None => self.vertex_map = Some(then.clone()),
            Some(map) => map.as_mut_slice().iter_mut().for_each(|new| {
                *new = new.and_then(|v| then.get(v).copied().flatten());
            }),
        }
    }
}

/// What [`Finishing::search`] found.
pub(crate) enum Found {
    /// All collapses may stay.
    All(Finished),
    /// So many of them may stay.
    Fewer(usize, Finished),
}

/// How levels of a mesh are finished.
pub(crate) struct Finishing<'a> {
    mesh: &'a TriMesh,
    original: &'a Surface,
    options: &'a Options,
    curves: [Option<Arc<Curve>>; 2],
    fit: Option<FitOptions>,
    anneal: Option<AnnealOptions>,
    peaks: Option<PeakOptions>,
}

/// The pieces of triangles to look at before a distance counts as above the limit.
const MAX_PIECES: usize = 4_000_000;

/// Levels whose numbers of faces are closer than this ratio are not told apart by the search.
const RESOLUTION: f64 = 1.03;

/// How far below the limit the attempts to collapse a level further aim, relative to it. The points
/// that one has missed count in the next; after the last one the level is left as it is.
const SLACKS: [f64; 8] = [0.01, 0.02, 0.03, 0.04, 0.05, 0.1, 0.2, 0.3];

impl<'a> Finishing<'a> {
    /// `with_changes` is whether anything is to be done at all, besides measuring.
    pub(crate) fn new(
        mesh: &'a TriMesh,
        original: &'a Surface,
        options: &'a Options,
        with_changes: bool,
    ) -> Self {
        let boundary = match options.constraints.boundary {
            Boundary::Lock => None,
            Boundary::Quadrics | Boundary::Free => Curve::boundary(mesh),
        };
        let features = options.constraints.features.as_ref().and_then(|features| {
            Curve::of_edges(mesh, |e| features.get(e).is_some_and(|&feature| feature))
        });
        let forbids = options.forbid_intersections;
        let guarded = |fit: FitOptions| FitOptions {
            forbid_intersections: fit.forbid_intersections || forbids,
            ..fit
        };
        let fit = options.fit.filter(|_| with_changes).map(guarded);
        let anneal = options.anneal.filter(|_| fit.is_some());
        let peaks = options.peaks.filter(|_| with_changes);
        let target = options.limits.face_target(mesh.topology().face_count());
        Self {
            mesh,
            original,
            options,
            curves: [boundary, features].map(|curve| curve.map(Arc::new)),
            fit,
            anneal: anneal.map(|anneal| AnnealOptions { fit: guarded(anneal.fit), ..anneal }),
            peaks: peaks.map(|peaks| PeakOptions {
                min_faces: peaks.min_faces.max(target.saturating_sub(1)),
                forbid_intersections: peaks.forbid_intersections || forbids,
                min_component_vertices: options.min_component_vertices,
                fit: guarded(peaks.fit),
                ..peaks
            }),
        }
    }

    /// Fits, anneals, takes down peaks, and measures, as far as the options want it.
    pub(crate) fn finish(&self, level: &Level) -> Result<Finished, SimplifyError> {
        let mut constraints = self.constraints(level);
        let unchanged = constraints.clone();
        let texture = self.texture_check(level);
        let mut done = Finished::untouched(level.mesh.clone());
        if let Some(options) = &self.fit {
            done.fit = Some(match &texture {
                Some(check) => {
                    fit_unfolded(&mut done.mesh, self.original, &constraints, options, check)?
                }
                None => fit(&mut done.mesh, self.original, &constraints, options)?,
            });
        }
        if let Some(options) = &self.anneal {
            let mut next = done.mesh.clone();
            let report = anneal(&mut next, self.original, &mut constraints, options)?;
            if done.take_unfolded(next, &report.vertex_map, texture.as_ref()) {
                done.anneal = Some(report);
            } else {
                constraints.clone_from(&unchanged);
            }
        }
        if let Some(options) = &self.peaks {
            let mut next = done.mesh.clone();
            let report = cut_peaks(&mut next, self.original, &mut constraints, options)?;
            if done.take_unfolded(next, &report.vertex_map, texture.as_ref()) {
                done.peaks = Some(report);
            }
        }
        done.constraints = constraints;
        if self.options.max_error.is_some() || self.options.error != ErrorCheck::None {
            done.error = Some(self.measure(&done.mesh)?.0);
        }
        Ok(done)
    }

    /// A level as it is, measured.
    fn measured(&self, level: &Level) -> Result<Finished, SimplifyError> {
        let mut done = Finished::untouched(level.mesh.clone());
        done.constraints = self.constraints(level);
        done.error = Some(self.measure(&done.mesh)?.0);
        Ok(done)
    }

    fn constraints(&self, level: &Level) -> FitConstraints {
        let [boundary_curve, feature_curve] = self.curves.clone();
        let (fixed, features) = (level.fixed.clone(), level.features.clone());
        FitConstraints { fixed, features, boundary_curve, feature_curve }
    }

    /// Whether a mesh within the limit is collapsed further. What is left of other limits would not
    /// be known, and attributes would be passed over.
    fn squeezes(&self) -> bool {
        let Options { limits, attributes, attribute_weight, .. } = self.options;
        let is_bare = attributes.is_none() || *attribute_weight == 0.0;
        let Limits { vertices, cost, collapses, time, .. } = *limits;
        let is_free = (vertices, cost, collapses, time) == (None, None, None, None);
        self.options.squeeze && is_free && is_bare
    }

    /// Collapses a mesh further that is within the limit.
    fn squeeze(&self, mut done: Finished, limit: f64) -> Result<Finished, SimplifyError> {
        let to = CollapseBack {
            faces: self.options.limits.face_target(self.mesh.topology().face_count()),
            locked: &[],
            boundary: self.options.constraints.boundary,
            forbid_intersections: self.options.forbid_intersections,
            min_component_vertices: self.options.min_component_vertices,
        };
        let mut missed = Vec::new();
        for (slack, seed) in SLACKS.into_iter().zip(0..) {
            let (mut next, mut constraints) = (done.mesh.clone(), done.constraints.clone());
            let aim = limit - slack * limit;
            let map = squeeze(&mut next, self.original, &mut constraints, aim, &missed, &to)?;
            let (error, at) = self.measure(&next)?;
            if error.is_within(limit) {
                done.follow(&map);
                (done.mesh, done.constraints, done.error) = (next, constraints, Some(error));
                break;
            }
            missed.push(at);
            missed.extend(self.beyond(aim, &next, seed)?);
        }
        Ok(done)
    }

    /// Samples of the original that are farther from a mesh than `limit`.
    fn beyond(&self, limit: f64, mesh: &TriMesh, seed: u64) -> Result<Vec<DVec3>, SimplifyError> {
        let samples = sample_surface(self.original, 200_000, seed);
        let samples: Vec<DVec3> = samples.iter().map(|sample| sample.position).collect();
        let distances = Surface::new(mesh)?.distances(&samples);
        let far = samples.into_iter().zip(distances).filter(|&(_, distance)| distance > limit);
        Ok(far.map(|(sample, _)| sample).collect())
    }

    /// What keeps a level from folding the texture, if there is one that counts.
    fn texture_check<'b>(&'b self, level: &'b Level) -> Option<TextureCheck<'b>> {
        let attributes = self.options.attributes.as_ref().filter(|a| a.has_texture())?;
        let seams = self.options.constraints.features.as_ref()?;
        let check = TextureCheck { original: self.mesh, attributes, seams, became: &level.became };
        (self.options.attribute_weight > 0.0).then_some(check)
    }

    /// The distance, and a point of one surface that is farthest from the other or nearly so.
    fn measure(&self, mesh: &TriMesh) -> Result<(AchievedError, DVec3), SimplifyError> {
        let surface = Surface::new(mesh)?;
        if self.options.error == ErrorCheck::Certified {
            let size = self.original.bounding_box().diagonal();
            let limit = self.options.max_error;
            let tolerance = limit.map_or(1e-4 * size, |limit| 0.01 * limit);
            // Where the distance is so close to the limit that more pieces were needed to tell, it
            // counts as above.
            let certify = match limit {
                None => CertifyOptions { tolerance, ..CertifyOptions::default() },
                Some(_) => CertifyOptions { tolerance, limit, max_pieces: MAX_PIECES },
            };
            let bounds = hausdorff_bounds(self.original, &surface, &certify);
            let error = AchievedError { lower: bounds.lower, upper: Some(bounds.upper) };
            Ok((error, bounds.at))
        } else {
            let samples = CompareOptions { samples: 200_000, ..CompareOptions::default() };
            let Comparison { forward, backward } = compare(self.original, &surface, &samples);
            let worse = if backward.max > forward.max { backward } else { forward };
            Ok((AchievedError { lower: worse.max, upper: None }, worse.worst.from))
        }
    }

    /// The coarsest level whose finished mesh is within the limit. Errors do not grow strictly with
    /// the number of collapses, so that a coarser one may exist. Where the level is collapsed further
    /// anyway, the first one that is found will do, and it is not finished.
    pub(crate) fn search(&self, run: &Run, limit: f64) -> Result<Found, SimplifyError> {
        let total = run.log.len();
        let mut collapses = self.guess(run, limit)?;
        let (mut good, mut bad): (Option<(usize, Finished)>, Option<usize>) = (None, None);
        loop {
            let level = self.level(run, collapses);
            let goes_on = self.squeezes() && collapses < total;
            let finished = if goes_on { self.measured(&level)? } else { self.finish(&level)? };
            if finished.error.is_some_and(|error| error.is_within(limit)) {
                if collapses == total {
                    return Ok(Found::All(finished));
                }
                good = Some((collapses, finished));
            } else if collapses == 0 {
                // Not even the original is measured to be within the limit of itself.
                return Ok(Found::Fewer(0, finished));
            } else {
                bad = Some(collapses);
            }
            let next = match (&good, bad) {
                (Some(_), _) if self.squeezes() => None,
                (Some((good, _)), Some(bad)) => self.between(*good, bad),
                (Some((good, _)), None) => Some(self.scaled(*good, 0.8).min(total)),
                (None, _) => Some(self.scaled(collapses, 1.3)),
            };
            match (next, good.take_if(|_| next.is_none())) {
                (Some(next), _) => collapses = next,
                (None, Some((collapses, mut finished))) => {
                    if self.squeezes() {
                        finished = self.squeeze(finished, limit)?;
                    }
                    return Ok(Found::Fewer(collapses, finished));
                }
                (None, None) => collapses = 0,
            }
        }
    }

    /// The number of collapses that leaves `factor` times as many vertices, at least one more or
    /// less.
    fn scaled(&self, collapses: usize, factor: f64) -> usize {
        let vertices = self.mesh.topology().vertex_count();
        let left = ((vertices - collapses) as f64 * factor) as usize;
        let changed = vertices - left.min(vertices);
        if factor < 1.0 { changed.max(collapses + 1) } else { changed.min(collapses - 1) }
    }

    /// A number of collapses between two; `None` when they are close enough.
    fn between(&self, good: usize, bad: usize) -> Option<usize> {
        let vertices = self.mesh.topology().vertex_count();
        let [more, fewer] = [good, bad].map(|collapses| (vertices - collapses).max(1) as f64);
        if bad <= good + 1 || more < RESOLUTION * fewer {
            return None;
        }
        let middle = vertices - (more * fewer).sqrt() as usize;
        Some(middle.clamp(good + 1, bad - 1))
    }

    /// How many collapses there may be before the vertices of the original are farther from the
    /// level, as it is before it is finished, than the limit.
    fn guess(&self, run: &Run, limit: f64) -> Result<usize, SimplifyError> {
        let is_within = |collapses: usize| -> Result<bool, SimplifyError> {
            let surface = Surface::new(&self.level(run, collapses).mesh)?;
            let distances = surface.distances(self.original.positions());
            Ok(distances.into_iter().all(|distance| distance <= limit))
        };
        let (mut good, mut bad) = (0, run.log.len());
        if is_within(bad)? {
            return Ok(bad);
        }
        while let Some(middle) = self.between(good, bad) {
            *(if is_within(middle)? { &mut good } else { &mut bad }) = middle;
        }
        Ok(good)
    }

    fn level(&self, run: &Run, collapses: usize) -> Level {
        // Locks and features are those of the end of a run; without any, the log will do.
        if run.locked.is_none()
            && run.features.is_none()
            && let Ok(mesh) = run.log.replay(self.mesh, collapses)
        {
            return Level::new(mesh, run, collapses);
        }
        let mut mesh = self.mesh.clone();
        let limits = Limits { collapses: Some(collapses), time: None, ..self.options.limits };
        let run = collapse(&mut mesh, self.options, &limits, &mut |_| ControlFlow::Continue(()));
        Level::new(mesh, &run, run.log.len())
    }
}
