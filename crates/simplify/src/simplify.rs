//! Simplification from options to result: collapses, refinement, tolerance.

use core::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{TriMesh, UnitScale, VertexId, VertexMap};
use mesh_metric::Surface;

use mesh_collapse::{
    CollapseLog, Constraints, Cost, Level, Placement, Policies, Policy, Progress, Protected,
    Rejections, Run, Start, StopReason,
};
use mesh_refine::{
    AnnealReport, CollapseBack, Curve, FitConstraints, FitReport, MaxErrorReport, Observer,
    Pipeline, Refined, Steps, Texture, UnfoldReport, mean_distance,
};

use crate::cheaper::{cheaper, undoes_stages};
use crate::collapse::collapse_to_level;
use crate::dispatch::collapse_with;
use crate::error::SimplifyError;
use crate::memory::check_memory;
use crate::options::{Metric, Options, PlacementRule};
use crate::plan::Plan;
use crate::preset::Preset;
use crate::shortfall::Shortfall;
use crate::tolerance::level_search::LevelSearch;
use crate::tolerance::measure::{AchievedError, Measuring};

/// A simplified mesh, and a report of the run.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Simplified {
    /// The mesh, without gaps.
    pub mesh: TriMesh,
    /// For each vertex of the input, the vertex of the result that it was merged into; `None` where the input had a
    /// removed vertex.
    pub vertex_map: VertexMap<Option<VertexId>>,
    /// Number of collapses, before [`ToleranceOptions::decimate`](crate::ToleranceOptions::decimate).
    pub collapses: usize,
    /// Every collapse, before refinement and before [`ToleranceOptions::decimate`](crate::ToleranceOptions::decimate);
    /// empty unless [`Options::record`] is set.
    pub log: CollapseLog,
    /// Why it stopped.
    pub stop: StopReason,
    /// The target that was not reached because every remaining collapse was rejected, and the reasons.
    pub shortfall: Option<Shortfall>,
    /// Number of rejected edges, by reason; in blocks this includes collapses that a largest error has undone.
    pub rejections: Rejections,
    /// Largest cost of a collapse, in the unit of the cost.
    pub max_cost: f64,
    /// Distance from the input, if it was asked for.
    pub error: Option<AchievedError>,
    /// Largest distance of a boundary vertex of the input from the boundary of the result; `None` when one of them has
    /// no boundary.
    pub boundary_shift: Option<f64>,
    /// The cheaper preset whose result is this one, because it was closer to the input; `None` if it was made by the
    /// options as they are. See [`Preset`].
    pub preset_kept: Option<Preset>,
    /// Report of the fit; `None` when it was not asked for, or undone because it did not lower the error.
    pub fit: Option<FitReport>,
    /// Report of the annealing; `None` when it was not asked for, had nothing to do (see
    /// [`AnnealOptions::has_work`](crate::AnnealOptions::has_work)), or was undone because it did not lower the error
    /// or folded the texture.
    pub anneal: Option<AnnealReport>,
    /// Report of the reduction of the largest errors; `None` when it was not asked for, or undone because it folded the
    /// texture or raised the mean too much.
    pub max_error: Option<MaxErrorReport>,
    /// Faces that chains of steps of refinement turned over against the input, before and after they were turned back;
    /// `None` without refinement.
    pub unfold: Option<UnfoldReport>,
}

/// Simplifies a mesh.
///
/// ```
/// use mesh_core::TriMesh;
/// use simplify::{Options, Preset, simplify};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let soup = mesh_shapes::Sphere { radius: 1.0 }.icosphere(3)?;
/// # let mesh = TriMesh::from_soup(&soup)?;
/// let result = simplify(&mesh, &Options::preset(Preset::Default).to_faces(200))?;
/// assert_eq!(result.mesh.topology().face_count(), 200);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// An option makes no sense, a position is not finite, or there is too little memory.
pub fn simplify(mesh: &TriMesh, options: &Options) -> Result<Simplified, SimplifyError> {
    simplify_observed(mesh, options, &mut |_| ControlFlow::Continue(()))
}

/// Simplifies a mesh; `observe` sees the progress of all phases and may stop the run.
///
/// A mesh larger than 1e12 or smaller than 1e-12 is scaled by a power of two before, and the result is scaled back. So
/// the result for a mesh of any size is that for a mesh of size 1, scaled.
///
/// A stopped run returns the best mesh so far, and [`Simplified::stop`] is [`StopReason::Cancelled`]. That mesh is
/// valid: it has the collapses so far, and refinement up to that point. Its distance from the input is not measured.
/// With an error limit, it is the coarsest level measured to be within the limit, or the input if there is none.
///
/// # Errors
/// An option is out of range, options exclude each other, a position is not finite, the size of the mesh leaves too few
/// digits, or there is too little memory.
pub fn simplify_observed(
    mesh: &TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    check(mesh, options)?;
    if options.cost.metric == Metric::Custom || options.placement == PlacementRule::Custom {
        return Err(SimplifyError::Conflict {
            option: "a custom cost or placement",
            with: "a run without policies",
            cure: "call simplify_with, or name a metric and a placement",
        });
    }
    let Some(scale) = UnitScale::of(mesh)? else { return closest(mesh, options, observe) };
    let found = closest(&scale.mesh(mesh)?, &options.scaled(scale), observe)?;
    Ok(found.restored(scale, options))
}

/// The factor of a mean beside that of a cheaper preset from which the result of the cheaper one is kept. Below it,
/// lower largest errors count more.
const MORE: f64 = 1.01;

/// The numbers of points at which means are compared: for quick presets and for others.
const FEW_POINTS: usize = 8_000;
const MANY_POINTS: usize = 40_000;

/// Simplifies a mesh by the options, and also by those of the cheaper presets where that takes little time. The result
/// of a cheaper one stays if its mean distance is smaller by more than a percent. After a stop by the observer it is
/// that of the options themselves.
fn closest(
    mesh: &TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    let faces = mesh.topology().face_count();
    let mut found = of_one_plan(mesh, options, observe)?;
    let Some((preset, options)) = cheaper(options, faces) else { return Ok(found) };
    let has_faces = |result: &Simplified| result.mesh.topology().face_count() > 0;
    if found.stop == StopReason::Cancelled || found.collapses == 0 || !has_faces(&found) {
        return Ok(found);
    }
    let mut other = closest(mesh, &options, observe)?;
    if other.stop == StopReason::Cancelled {
        found.stop = StopReason::Cancelled;
        return Ok(found);
    }
    let most = found.mesh.topology().face_count().max(options.target.face_target(faces));
    if has_faces(&other) && other.mesh.topology().face_count() <= most {
        let original = Surface::new(mesh)?;
        let points = if preset == Preset::Fast { FEW_POINTS } else { MANY_POINTS };
        let mean = |of: &Simplified| mean_distance(&original, &of.mesh, points);
        let [own, others] = [mean(&found)?, mean(&other)?];
        if own > MORE * others {
            other.preset_kept = other.preset_kept.or(Some(preset));
            return Ok(other);
        }
    }
    Ok(found)
}

/// Simplifies a mesh whose products of lengths neither overflow nor vanish, by one set of options.
fn of_one_plan(
    mesh: &TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    let plan = Plan::of(options, mesh);
    check_memory(&plan, mesh, options)?;
    let mut observer = observer(mesh, options, observe);
    let see = &mut |now: &_| observer.observe(now);
    let (level, run) = collapse_to_level(mesh, plan, options, see);
    let constraints = Constraints::default();
    AfterCollapses { mesh, constraints: &constraints, options }.result(level, run, observer)
}

/// Simplifies a mesh with custom cost, placement, cost modifiers and constraints. The options must be
/// [`Options::custom`]. Their protection, target, attributes, refinement and tolerance apply as in [`simplify()`];
/// custom constraints are also obeyed by the refinement. The mesh is not scaled, because policies know its size:
/// products of several lengths must be in the range of numbers.
///
/// # Errors
/// As [`simplify()`]; the options name a cost or a placement.
pub fn simplify_with(
    mesh: &TriMesh,
    mut policies: Policies<impl Cost, impl Placement>,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    check(mesh, options)?;
    if options.cost.metric != Metric::Custom || options.placement != PlacementRule::Custom {
        return Err(SimplifyError::Conflict {
            option: "a cost or placement by name",
            with: "policies of one's own",
            cure: "call Options::custom, so that the policies decide",
        });
    }
    let constraints = core::mem::take(&mut policies.constraints);
    let mut followers = constraints.clone();
    followers.prepare(mesh);
    let mut working = mesh.clone();
    let mut observer = observer(mesh, options, observe);
    let see = &mut |now: &_| observer.observe(now);
    let run = collapse_with(&mut working, policies, Start::followed_by(followers), options, see);
    let level = Level::at_end(working, &run);
    AfterCollapses { mesh, constraints: &constraints, options }.result(level, run, observer)
}

fn observer<'a>(
    mesh: &TriMesh,
    options: &Options,
    observe: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Observer<'a> {
    let faces_before = mesh.topology().face_count();
    Observer::new(faces_before, options.target.face_target(faces_before), observe)
}

/// A refined mesh, and what the vertices of the input are in the level that it was made from.
type RefinedLevel = (Refined, VertexMap<Option<VertexId>>);

/// What follows the collapses.
struct AfterCollapses<'a> {
    /// The input.
    mesh: &'a TriMesh,
    /// Custom constraints, as they were before the run.
    constraints: &'a Constraints,
    options: &'a Options,
}

impl AfterCollapses<'_> {
    /// The result of a run that has left `level`.
    fn result(
        &self,
        level: Level,
        mut run: Run,
        mut observer: Observer<'_>,
    ) -> Result<Simplified, SimplifyError> {
        let Self { mesh, options, .. } = *self;
        let is_changed = !observer.is_stopped() && run.collapses > 0;
        let is_refined = is_changed && (options.refine.is_any() || self.may_fold());
        let has_faces = mesh.topology().face_count() > 0;
        let mut error = None;
        let (refined, vertex_map) =
            if has_faces && (is_refined || options.tolerance.check.is_some()) {
                let steps = if is_refined { self.steps() } else { Steps::default() };
                self.refined(level, &mut run, steps, &mut error, &mut observer)?
            } else {
                untouched(level)
            };
        if observer.is_stopped() {
            run.stop = StopReason::Cancelled;
        }
        let follow = |&v: &Option<VertexId>| match &refined.vertex_map {
            Some(map) => v.and_then(|v| map.get(v).copied().flatten()),
            None => v,
        };
        Ok(Simplified {
            vertex_map: VertexMap::from_vec(vertex_map.as_slice().iter().map(follow).collect()),
            boundary_shift: boundary_shift(mesh, &refined.mesh),
            mesh: refined.mesh,
            collapses: run.collapses,
            log: if options.record { run.log } else { CollapseLog::default() },
            stop: run.stop,
            shortfall: Shortfall::of(
                &options.target,
                mesh.topology().face_count(),
                run.stop,
                &run.rejections,
            ),
            rejections: run.rejections,
            max_cost: run.max_cost,
            error,
            fit: refined.fit,
            anneal: refined.anneal,
            max_error: refined.max_error,
            preset_kept: None,
            unfold: refined.unfold,
        })
    }

    /// The level refined and measured, or with an error limit the coarsest level within it.
    fn refined(
        &self,
        level: Level,
        run: &mut Run,
        steps: Steps,
        error: &mut Option<AchievedError>,
        observer: &mut Observer<'_>,
    ) -> Result<RefinedLevel, SimplifyError> {
        let original = Surface::new(self.mesh)?;
        let tolerance = self.options.tolerance;
        let protect = &self.options.protect;
        let pipeline = Pipeline::new(self.mesh, &original, protect, steps, self.texture());
        let measuring = tolerance.check.map(|check| Measuring {
            original: &original,
            check,
            limit: tolerance.distance,
        });
        if let (Some(limit), Some(measuring)) = (tolerance.distance, measuring) {
            // The search makes levels of its own.
            drop(level);
            return self.within(limit, run, &pipeline, measuring, error, observer);
        }
        let (refined, vertex_map) = pipeline.finish(level, observer)?;
        if let Some(measuring) = measuring {
            *error = measuring.measure(&refined.mesh, observer)?;
        }
        Ok((refined, vertex_map))
    }

    /// The coarsest level within a distance; the input when the observer stops the search before there is one.
    fn within(
        &self,
        limit: f64,
        run: &mut Run,
        pipeline: &Pipeline<'_>,
        measuring: Measuring<'_>,
        error: &mut Option<AchievedError>,
        observer: &mut Observer<'_>,
    ) -> Result<RefinedLevel, SimplifyError> {
        let Self { mesh, options, .. } = *self;
        let mut constraints = self.constraints.clone();
        constraints.prepare(mesh);
        let snapshots = core::mem::take(&mut run.snapshots);
        let search = LevelSearch {
            mesh,
            protected: Protected::new(mesh, &options.protect, constraints),
            log: &run.log,
            pipeline,
            measuring,
            limit,
            decimate: self.decimation(),
        };
        let found = if observer.is_stopped() { None } else { search.run(snapshots, observer)? };
        let Some(found) = found else {
            run.truncate(0);
            let protected = Protected::new(mesh, &options.protect, Constraints::default());
            return Ok(untouched(Level::new(mesh, &protected, &run.log, 0)?));
        };
        if found.collapses < run.log.len() || !found.error.is_within(limit) {
            run.truncate(found.collapses);
            let faces = found.refined.mesh.topology().face_count();
            run.stop =
                if faces <= self.face_target() { StopReason::Faces } else { StopReason::Error };
        }
        *error = Some(found.error);
        Ok((found.refined, found.vertex_map))
    }

    fn face_target(&self) -> usize {
        self.options.target.face_target(self.mesh.topology().face_count())
    }

    /// Whether the collapses avoid folds but may make some by a chain of turns: the butterfly point leaves the surface.
    fn may_fold(&self) -> bool {
        self.options.placement == PlacementRule::Butterfly
            && self.options.protect.min_cosine.is_some()
    }

    /// The stages of the refinement; at least the wanted faces are left, or one fewer.
    fn steps(&self) -> Steps {
        let steps =
            self.options.refine.steps(&self.options.protect, self.face_target().saturating_sub(1));
        Steps { undo: undoes_stages(self.options, self.mesh.topology().face_count()), ..steps }
    }

    /// The texture that must not fold over, if there is one that counts.
    fn texture(&self) -> Option<Texture<'_>> {
        let attributes = self.options.attributes.counting()?;
        let seams = self.options.protect.features.as_ref()?;
        let texture = Texture { original: self.mesh, attributes, seams };
        attributes.has_texture().then_some(texture)
    }

    /// Whether and how a mesh within the tolerance is collapsed further.
    fn decimation(&self) -> Option<CollapseBack<'static>> {
        let Options { protect, tolerance, .. } = self.options;
        tolerance.decimate.then_some(CollapseBack {
            faces: self.face_target(),
            locked: &[],
            boundary: protect.boundary,
            forbid_intersections: protect.forbid_intersections,
            min_component_vertices: protect.min_component_vertices,
            first: None,
        })
    }
}

fn untouched(level: Level) -> RefinedLevel {
    (Refined::untouched(level.mesh, FitConstraints::default()), level.vertex_map)
}

fn check(mesh: &TriMesh, options: &Options) -> Result<(), SimplifyError> {
    options.check()?;
    let mut used = mesh.topology().vertices().map(|v| (v, mesh.position(v)));
    if let Some((vertex, position)) = used.find(|(_, position)| !position.is_finite()) {
        return Err(SimplifyError::NotFinite { vertex, position });
    }
    let importance = options.protect.importance.as_ref();
    let mut known = importance.into_iter().flat_map(|map| map.live(mesh.topology()));
    match known.find(|(_, importance)| !(**importance >= 0.0 && importance.is_finite())) {
        Some((vertex, &importance)) => Err(SimplifyError::Importance { vertex, importance }),
        None => Ok(()),
    }
}

/// The largest distance of a boundary vertex of one mesh to the boundary of another.
fn boundary_shift(from: &TriMesh, to: &TriMesh) -> Option<f64> {
    let boundary = Curve::boundary(to)?;
    let topology = from.topology();
    let vertices = topology.vertices().filter(|&v| topology.is_boundary_vertex(v));
    let points: Vec<DVec3> = vertices.map(|v| from.position(v)).collect();
    boundary.farthest(&points)
}
