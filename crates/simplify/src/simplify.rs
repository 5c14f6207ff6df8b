//! Simplification from options to result: collapses, finish, error limit.

use core::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_metric::Surface;

use crate::dispatch::collapse_with;
use crate::error::SimplifyError;
use crate::memory::check_memory;
use crate::options::Options;
use crate::plan::collapse_to_level;
use crate::tolerance::level_search::LevelSearch;
use crate::tolerance::measure::{AchievedError, Measuring};
use mesh_collapse::{
    CollapseLog, Constraints, Cost, Level, Placement, Policies, Policy, Progress, Protected,
    Rejections, Run, Start, StopReason,
};
use mesh_refine::{
    AnnealOptions, AnnealReport, CollapseBack, Curve, FitConstraints, FitOptions, FitReport,
    MaxErrorOptions, MaxErrorReport, Observer, Pipeline, Refined, Steps, Texture,
};

/// A simplified mesh and how it came about.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Simplified {
    /// The mesh, without gaps.
    pub mesh: TriMesh,
    /// For each vertex of the original, the vertex of the result that it has become; `None` where
    /// the original had a removed vertex.
    pub vertex_map: VertexMap<Option<VertexId>>,
    /// The number of collapses, before [`LimitOptions::squeeze`](crate::LimitOptions::squeeze).
    pub collapses: usize,
    /// Every collapse, before fitting and before [`LimitOptions::squeeze`](crate::LimitOptions::squeeze);
    /// empty unless [`CollapseOptions::record`](crate::CollapseOptions::record) is set.
    pub log: CollapseLog,
    /// Why it stopped.
    pub stop: StopReason,
    /// How often edges were refused, by reason; in regions also by collapses that a largest error has taken back.
    pub rejections: Rejections,
    /// The largest cost of a collapse, in the unit of the cost.
    pub max_cost: f64,
    /// The distance from the original, if it was asked for.
    pub error: Option<AchievedError>,
    /// The largest distance of a boundary vertex of the original to the boundary of the result;
    /// `None` when there is no boundary.
    pub boundary_shift: Option<f64>,
    /// What fitting did, if it was asked for.
    pub fit: Option<FitReport>,
    /// What annealing did, if it was asked for; `None` when there was nothing to do, see
    /// [`AnnealOptions::has_work`], or when it was undone because it folded the texture.
    pub anneal: Option<AnnealReport>,
    /// What was done about the largest errors; `None` when not asked for or undone as well.
    pub max_error: Option<MaxErrorReport>,
}

/// Simplifies a mesh.
///
/// ```
/// use mesh_core::TriMesh;
/// use simplify::{Options, Preset, simplify};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let soup = mesh_core::shapes::Sphere { radius: 1.0 }.icosphere(3)?;
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

/// Simplifies a mesh, showing its progress and asking whether to go on, in all phases.
///
/// When it was told to stop, the result is the best that there is by then, whole, and
/// [`Simplified::stop`] is [`StopReason::Cancelled`]: the collapses so far, not finished, or finished
/// as far as that has come; its distance from the original is not known. With a largest error it is
/// the coarsest level that was measured to be within it by then, and when none was, the original.
///
/// # Errors
/// An option makes no sense, or a position is not finite.
pub fn simplify_observed(
    mesh: &TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    check(mesh, options)?;
    check_memory(mesh, options)?;
    let mut observer = observer(mesh, options, observe);
    let see = &mut |now: &_| observer.observe(now);
    let (level, run) = collapse_to_level(mesh, options, see);
    finish(mesh, level, run, &Constraints::default(), options, observer)
}

/// Simplifies a mesh with a cost, a placement, surcharges and guards of one's own: these, not those
/// that `options.collapse` names. Attributes, limits, and what comes after the collapses are as the
/// options say; there, only the guards are asked.
///
/// # Errors
/// As [`simplify()`].
pub fn simplify_with(
    mesh: &TriMesh,
    mut policies: Policies<impl Cost, impl Placement>,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    check(mesh, options)?;
    let constraints = core::mem::take(&mut policies.constraints);
    let mut followers = constraints.clone();
    followers.prepare(mesh);
    let mut working = mesh.clone();
    let mut observer = observer(mesh, options, observe);
    let see = &mut |now: &_| observer.observe(now);
    let run = collapse_with(&mut working, policies, Start::followed_by(followers), options, see);
    finish(mesh, Level::at_end(working, &run), run, &constraints, options, observer)
}

fn observer<'a>(
    mesh: &TriMesh,
    options: &Options,
    observe: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Observer<'a> {
    let faces_before = mesh.topology().face_count();
    Observer::new(faces_before, options.collapse.limits.face_target(faces_before), observe)
}

/// What comes after the collapses, which have left `level`; the guards are as they were before.
fn finish(
    mesh: &TriMesh,
    level: Level,
    mut run: Run,
    constraints: &Constraints,
    options: &Options,
    mut observer: Observer<'_>,
) -> Result<Simplified, SimplifyError> {
    let Options { collapse, refine, limit, .. } = options;
    let is_changed = !observer.is_stopped() && run.collapses > 0;
    let wants_finish = is_changed && (refine.fit.is_some() || refine.max_error.is_some());
    let has_faces = mesh.topology().face_count() > 0;
    let target = collapse.limits.face_target(mesh.topology().face_count());
    let mut error = None;
    let untouched = |level: Level| {
        (Refined::untouched(level.mesh, FitConstraints::default()), level.vertex_map)
    };
    let (finished, vertex_map) = if has_faces && (wants_finish || limit.check.is_some()) {
        let original = Surface::new(mesh)?;
        let steps = if wants_finish { steps(options, target) } else { Steps::default() };
        let texture = texture(mesh, options);
        let finishing = Pipeline::new(mesh, &original, &collapse.protect, steps, texture);
        let measuring = limit.check.map(|check| Measuring {
            original: &original,
            check,
            limit: limit.distance,
        });
        if let (Some(limit), Some(measuring)) = (limit.distance, measuring) {
            let mut constraints = constraints.clone();
            constraints.prepare(mesh);
            let snapshots = core::mem::take(&mut run.snapshots);
            let search = LevelSearch {
                mesh,
                protected: Protected::new(mesh, &collapse.protect, constraints),
                log: &run.log,
                finishing: &finishing,
                measuring,
                limit,
                decimate: decimate(options, target),
            };
            // The search makes levels of its own.
            drop(level);
            let found =
                if observer.is_stopped() { None } else { search.run(snapshots, &mut observer)? };
            if let Some(found) = found {
                if found.collapses < run.log.len() || !found.error.is_within(limit) {
                    run.truncate(found.collapses);
                    let faces = found.finished.mesh.topology().face_count();
                    run.stop = if faces <= target { StopReason::Faces } else { StopReason::Error };
                }
                error = Some(found.error);
                (found.finished, found.vertex_map)
            } else {
                run.truncate(0);
                let protected = Protected::new(mesh, &collapse.protect, Constraints::default());
                untouched(Level::new(mesh, &protected, &run.log, 0)?)
            }
        } else {
            let (finished, vertex_map) = finishing.finish(level, &mut observer)?;
            if let Some(measuring) = measuring {
                error = measuring.measure(&finished.mesh, &mut observer)?;
            }
            (finished, vertex_map)
        }
    } else {
        untouched(level)
    };
    if observer.is_stopped() {
        run.stop = StopReason::Cancelled;
    }
    let follow = |&v: &Option<VertexId>| match &finished.vertex_map {
        Some(map) => v.and_then(|v| map.get(v).copied().flatten()),
        None => v,
    };
    Ok(Simplified {
        vertex_map: VertexMap::from_vec(vertex_map.as_slice().iter().map(follow).collect()),
        boundary_shift: boundary_shift(mesh, &finished.mesh),
        mesh: finished.mesh,
        collapses: run.collapses,
        log: if collapse.record { run.log } else { CollapseLog::default() },
        stop: run.stop,
        rejections: run.rejections,
        max_cost: run.max_cost,
        error,
        fit: finished.fit,
        anneal: finished.anneal,
        max_error: finished.max_error,
    })
}

fn check(mesh: &TriMesh, options: &Options) -> Result<(), SimplifyError> {
    options.check()?;
    let mut used = mesh.topology().vertices().map(|v| (v, mesh.position(v)));
    match used.find(|(_, position)| !position.is_finite()) {
        Some((vertex, position)) => Err(SimplifyError::NotFinite { vertex, position }),
        None => Ok(()),
    }
}

/// What the options do with a level; at least `target` faces are left, or one fewer.
fn steps(options: &Options, target: usize) -> Steps {
    let Options { collapse, refine, .. } = options;
    let forbids = collapse.forbid_intersections;
    let guarded = |fit: FitOptions| FitOptions {
        forbid_intersections: fit.forbid_intersections || forbids,
        ..fit
    };
    Steps {
        fit: refine.fit.map(guarded),
        anneal: refine.anneal.map(|anneal| AnnealOptions { fit: guarded(anneal.fit), ..anneal }),
        max_error: refine.max_error.map(|max_error| MaxErrorOptions {
            min_faces: max_error.min_faces.max(target.saturating_sub(1)),
            forbid_intersections: max_error.forbid_intersections || forbids,
            min_component_vertices: collapse.min_component_vertices,
            fit: guarded(max_error.fit),
            ..max_error
        }),
    }
}

/// The texture that must not fold over, if there is one that counts.
fn texture<'a>(mesh: &'a TriMesh, options: &'a Options) -> Option<Texture<'a>> {
    let attributes = options.attributes.counting().filter(|corners| corners.has_texture())?;
    let seams = options.collapse.protect.features.as_ref()?;
    Some(Texture { original: mesh, attributes, seams })
}

/// Whether and how a mesh within the limit is collapsed further.
fn decimate(options: &Options, target: usize) -> Option<CollapseBack<'static>> {
    let Options { collapse, limit, .. } = options;
    limit.decimate.then_some(CollapseBack {
        faces: target,
        locked: &[],
        boundary: collapse.protect.boundary,
        forbid_intersections: collapse.forbid_intersections,
        min_component_vertices: collapse.min_component_vertices,
        first: None,
    })
}

/// The largest distance of a boundary vertex of one mesh to the boundary of another.
fn boundary_shift(from: &TriMesh, to: &TriMesh) -> Option<f64> {
    let boundary = Curve::boundary(to)?;
    let topology = from.topology();
    let vertices = topology.vertices().filter(|&v| topology.is_boundary_vertex(v));
    let points: Vec<DVec3> = vertices.map(|v| from.position(v)).collect();
    boundary.farthest(&points)
}
