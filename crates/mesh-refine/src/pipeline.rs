//! The sequence of fitting, annealing, reduction of the largest errors, and repair of faces that are turned over.

use std::sync::Arc;

use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_metric::Surface;

use crate::anneal::{AnnealOptions, AnnealReport, anneal_observed};
use crate::collapse_back::follow;
use crate::curve::Curve;
use crate::error::RefineError;
use crate::fit::constraints::FitConstraints;
use crate::fit::spread::area;
use crate::fit::{FitOptions, FitReport, fit_observed};
use crate::max_error::{MaxErrorOptions, MaxErrorReport, reduce_max_error_observed};
use crate::mean_distance::{Measured, measure};
use crate::observer::Observer;
use crate::texture_folds::{Texture, TextureCheck, fit_unfolded};
use crate::unfold::{UnfoldOptions, UnfoldReport, unfold};
use mesh_collapse::{Boundary, FaceLimits, Level, Protect, Protected};

/// A level and the refinement that it has had.
#[derive(Clone)]
pub struct Refined {
    /// The current mesh.
    pub mesh: TriMesh,
    /// For each vertex of the level, the vertex of the current mesh; `None` if they are the same.
    pub vertex_map: Option<VertexMap<Option<VertexId>>>,
    /// Report of the fit, if it ran.
    pub fit: Option<FitReport>,
    /// Report of the annealing, if it ran and was kept.
    pub anneal: Option<AnnealReport>,
    /// Report of the reduction of the largest error, if it ran and was kept.
    pub max_error: Option<MaxErrorReport>,
    /// Faces that were turned over, and those that still are, if it was looked for them.
    pub unfold: Option<UnfoldReport>,
    /// Constraints of the current mesh.
    pub constraints: FitConstraints,
}

impl Refined {
    /// A mesh without refinement.
    pub fn untouched(mesh: TriMesh, constraints: FitConstraints) -> Self {
        Self {
            mesh,
            vertex_map: None,
            fit: None,
            anneal: None,
            max_error: None,
            unfold: None,
            constraints,
        }
    }

    /// The number of faces that are folded in a texture.
    fn folds_in(&self, texture: Option<&TextureCheck<'_>>) -> usize {
        texture.map_or(0, |check| check.folded_after(&self.mesh, self.vertex_map.as_ref()))
    }

    /// The number of faces that are turned over.
    #[must_use]
    pub fn turned_over(&self) -> usize {
        self.unfold.map_or(0, |report| report.turned_after)
    }

    /// The vertex of the current mesh for each vertex of the original, from the vertex of the level.
    #[must_use]
    pub fn map_from_original(
        &self,
        mut level: VertexMap<Option<VertexId>>,
    ) -> VertexMap<Option<VertexId>> {
        if let Some(next) = &self.vertex_map {
            follow(&mut level, next);
        }
        level
    }

    /// Updates the vertex map for the next mesh.
    pub fn follow(&mut self, then: &VertexMap<Option<VertexId>>) {
        match &mut self.vertex_map {
            None => self.vertex_map = Some(then.clone()),
            Some(map) => follow(map, then),
        }
    }
}

/// The number of points at which the mean distance is measured that decides whether a stage stays.
const POINTS: usize = 8_000;

/// The largest distance, as a share of the diagonal of the original, of a mesh that lies on it, as flat parts of CAD
/// models do: less than the rounding of single precision. Only rounding is left to reduce there.
const EXACT: f64 = 1e-7;

/// The largest number of times that the largest errors are reduced.
const PASSES: usize = 3;

/// The stages of refinement.
#[derive(Clone, Copy, Debug, Default)]
pub struct Steps {
    /// How to fit; `None` to skip the fit.
    pub fit: Option<FitOptions>,
    /// How to anneal; `None` to skip annealing.
    pub anneal: Option<AnnealOptions>,
    /// How to reduce the largest error; `None` to skip that.
    pub max_error: Option<MaxErrorOptions>,
    /// How to turn back faces that are turned over; `None` to leave them.
    pub unfold: Option<UnfoldOptions>,
    /// Whether each stage is measured, and undone if the mean distance in both directions has risen; the reduction of
    /// the largest errors, if it has risen by more than its [`MaxErrorOptions::max_rise`]. Fit and annealing are also
    /// undone if they leave faces turned over. No stage runs if the mesh lies on the original, up to the rounding of
    /// single precision. On large meshes this takes time, and chance hardly matters there.
    pub undo: bool,
}

/// The refinement of levels of a mesh.
pub struct Pipeline<'a> {
    original: &'a Surface,
    /// The boundary and the feature lines of the original.
    curves: [Option<Arc<Curve>>; 2],
    limits: FaceLimits,
    /// The factor on the squared distances at each triangle of the original.
    importance: Option<Arc<[f64]>>,
    steps: Steps,
    texture: Option<Texture<'a>>,
}

impl<'a> Pipeline<'a> {
    /// For a mesh and its surface. With a texture, no step may fold more faces over in it.
    pub fn new(
        mesh: &TriMesh,
        original: &'a Surface,
        protect: &Protect,
        steps: Steps,
        texture: Option<Texture<'a>>,
    ) -> Self {
        let boundary = match protect.boundary {
            Boundary::Lock => None,
            _ => Curve::boundary(mesh),
        };
        let features = protect.features.as_ref().and_then(|features| {
            Curve::of_edges(mesh, |e| features.get(e).is_some_and(|&feature| feature))
        });
        let curves = [boundary, features].map(|curve| curve.map(Arc::new));
        let limits = protect.limits;
        let importance = protect.importance.as_ref().and_then(|map| importance_of(original, map));
        Self { original, curves, limits, importance, steps, texture }
    }

    /// A level without refinement, and the vertex of the level for each vertex of the original.
    pub fn leave(&self, level: Level) -> (Refined, VertexMap<Option<VertexId>>) {
        let constraints = self.constraints(level.protected);
        (Refined::untouched(level.mesh, constraints), level.vertex_map)
    }

    /// Fits, anneals, reduces the largest errors and turns back faces that are turned over, if these stages are enabled
    /// and the observer does not stop them. Also returns the vertex of the level for each vertex of the original.
    pub fn finish(
        &self,
        level: Level,
        observer: &mut Observer<'_>,
    ) -> Result<(Refined, VertexMap<Option<VertexId>>), RefineError> {
        let Level { mesh, protected, vertex_map } = level;
        let texture = self.texture.as_ref().map(|texture| texture.check(&vertex_map));
        let mut done = Refined::untouched(mesh, self.constraints(protected));
        let start = self.measured(&done.mesh)?;
        if start.is_some_and(|start| start.max <= EXACT * self.original.bounding_box().diagonal()) {
            self.unfold(&mut done, &vertex_map);
            return Ok((done, vertex_map));
        }
        let mut mean = start.map(|start| start.mean);
        let level = mean.is_some().then(|| done.clone());
        if let Some(options) = &self.steps.fit {
            let Refined { mesh, constraints, .. } = &mut done;
            done.fit = Some(match &texture {
                Some(check) => {
                    fit_unfolded(mesh, self.original, constraints, options, check, observer)?
                }
                None => fit_observed(mesh, self.original, constraints, options, observer)?,
            });
            let after = self.mean_of(&done.mesh)?;
            match &level {
                Some(level) if after > mean => done = level.clone(),
                _ => mean = after,
            }
        }
        if let Some(options) = &self.steps.anneal
            && options.has_work(&done.mesh, self.original)
            && !observer.is_stopped()
        {
            let before = done.clone();
            let Refined { mesh, constraints, .. } = &mut done;
            let report = anneal_observed(mesh, self.original, constraints, options, observer)?;
            done.follow(&report.vertex_map);
            let after = self.mean_of(&done.mesh)?;
            if after <= mean && done.folds_in(texture.as_ref()) <= before.folds_in(texture.as_ref())
            {
                (done.anneal, mean) = (Some(report), after);
            } else {
                done = before;
            }
        }
        self.unfold(&mut done, &vertex_map);
        if let Some(mut level) = level.filter(|_| done.turned_over() > 0) {
            self.unfold(&mut level, &vertex_map);
            if level.turned_over() < done.turned_over() {
                mean = self.mean_of(&level.mesh)?;
                done = level;
            }
        }
        self.reduce_max_error(&mut done, &vertex_map, mean, observer)?;
        Ok((done, vertex_map))
    }

    /// Reduces the largest errors and turns back the faces that are turned over then. A face that is turned back may be
    /// farther from the original, so both are repeated. A reduction is undone if more faces are folded in the texture, or
    /// if the mean distance has risen too much. If more faces stay turned over, it is tried again with half of the
    /// rounds.
    fn reduce_max_error(
        &self,
        done: &mut Refined,
        vertex_map: &VertexMap<Option<VertexId>>,
        mean: Option<f64>,
        observer: &mut Observer<'_>,
    ) -> Result<(), RefineError> {
        let Some(mut options) = self.steps.max_error else { return Ok(()) };
        let texture = self.texture.as_ref().map(|texture| texture.check(vertex_map));
        let most = mean.map(|mean| options.max_rise * mean);
        for _ in 0..PASSES {
            if observer.is_stopped() {
                break;
            }
            let before = done.clone();
            let rounds = self.reduce_once(done, &options, observer)?;
            if self.mean_of(&done.mesh)? > most
                || done.folds_in(texture.as_ref()) > before.folds_in(texture.as_ref())
            {
                *done = before;
                break;
            }
            self.unfold(done, vertex_map);
            if done.turned_over() > before.turned_over() {
                *done = before;
                options.rounds = rounds / 2;
                continue;
            }
            if done.unfold == before.unfold {
                break;
            }
        }
        Ok(())
    }

    /// Reduces the largest errors, and returns the number of rounds.
    fn reduce_once(
        &self,
        done: &mut Refined,
        options: &MaxErrorOptions,
        observer: &mut Observer<'_>,
    ) -> Result<usize, RefineError> {
        let Refined { mesh, constraints, .. } = done;
        let report =
            reduce_max_error_observed(mesh, self.original, constraints, options, observer)?;
        done.follow(&report.vertex_map);
        let rounds = report.rounds;
        done.max_error = Some(match done.max_error.take() {
            Some(earlier) => earlier.then(&report),
            None => report,
        });
        Ok(rounds)
    }

    /// Turns back the faces that are turned over, if this stage is enabled and no more faces are folded in the texture
    /// then. `vertex_map` has the vertex of the level for each vertex of the original.
    pub fn unfold(&self, done: &mut Refined, vertex_map: &VertexMap<Option<VertexId>>) {
        let Some(options) = &self.steps.unfold else { return };
        let report = if let Some(texture) = &self.texture {
            let check = texture.check(vertex_map);
            let mut next = done.mesh.clone();
            let mut report = unfold(&mut next, self.original, &done.constraints, options);
            let folds = |mesh: &TriMesh| check.folded_after(mesh, done.vertex_map.as_ref());
            if report.has_helped() && folds(&next) <= folds(&done.mesh) {
                done.mesh = next;
            } else {
                report.turned_after = report.turned_before;
            }
            report
        } else {
            unfold(&mut done.mesh, self.original, &done.constraints, options)
        };
        done.unfold = Some(done.unfold.unwrap_or_default().then(report));
    }

    /// Distances of a mesh from the original, if stages are undone that raise their mean.
    fn measured(&self, mesh: &TriMesh) -> Result<Option<Measured>, RefineError> {
        self.steps.undo.then(|| measure(self.original, mesh, POINTS)).transpose()
    }

    fn mean_of(&self, mesh: &TriMesh) -> Result<Option<f64>, RefineError> {
        Ok(self.measured(mesh)?.map(|measured| measured.mean))
    }

    fn constraints(
        &self,
        Protected { locked, features, kept, importance, constraints }: Protected,
    ) -> FitConstraints {
        let [boundary_curve, feature_curve] = self.curves.clone();
        FitConstraints {
            fixed: locked,
            features,
            kept,
            limits: self.limits,
            importance,
            original_importance: self.importance.clone(),
            boundary_curve,
            feature_curve,
            constraints,
        }
    }
}

/// The smallest factor on squared distances, relative to their mean, so that all vertices are held by something.
const LEAST_IMPORTANCE: f64 = 1e-3;

/// The factor on the squared distances at each triangle: the mean importance of its corners, relative to the mean over
/// the surface. `None` if nothing is important.
fn importance_of(original: &Surface, importance: &VertexMap<f64>) -> Option<Arc<[f64]>> {
    let of_vertex = |v: u32| importance.get(VertexId::new(v)).copied().unwrap_or(1.0);
    let of_triangle = |t: &[u32; 3]| t.map(of_vertex).iter().sum::<f64>() / 3.0;
    let of_all: Vec<f64> = original.triangles().iter().map(of_triangle).collect();
    let areas = (0..of_all.len()).map(|t| area(&original.triangle(t)));
    let sums =
        areas.zip(&of_all).fold([0.0; 2], |sum, (area, w)| [sum[0] + area, sum[1] + area * w]);
    let mean = sums[1] / sums[0];
    let factors = of_all.iter().map(|w| (w / mean).max(LEAST_IMPORTANCE));
    (mean > 0.0 && mean.is_finite()).then(|| factors.collect())
}
