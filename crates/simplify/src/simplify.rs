//! Simplification from options to result: collapses, finish, error limit.

use core::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_metric::Surface;

use crate::collapse::constraint::Marks;
use crate::collapse::level::Level;
use crate::collapse::log::CollapseLog;
use crate::collapse::refusal::Refusals;
use crate::collapse::run::{Phase, Progress};
use crate::collapse::stop::{Limits, StopReason};
use crate::error::SimplifyError;
use crate::finish::anneal::{AnnealOptions, AnnealReport};
use crate::finish::collapse_back::CollapseBack;
use crate::finish::curve::Curve;
use crate::finish::finishing::{Finished, Finishing, Steps};
use crate::finish::fit::constraints::FitConstraints;
use crate::finish::fit::{FitOptions, FitReport};
use crate::finish::observer::Observer;
use crate::finish::peaks::{PeakOptions, PeakReport};
use crate::finish::texture_fit::Texture;
use crate::limit::measure::{AchievedError, ErrorCheck, Measuring};
use crate::limit::search::Search;
use crate::named::collapse;
use crate::options::Options;

/// A simplified mesh and how it came about.
#[derive(Clone, Debug)]
pub struct Simplified {
    /// The mesh, without gaps.
    pub mesh: TriMesh,
    /// For each vertex of the original, the vertex of the result that it has become; `None` where
    /// the original had a removed vertex.
    pub vertex_map: VertexMap<Option<VertexId>>,
    /// Every collapse, before fitting and before [`Options::squeeze`].
    pub log: CollapseLog,
    /// Why it stopped.
    pub stop: StopReason,
    /// How often edges were refused, by reason.
    pub refusals: Refusals,
    /// The largest cost of a collapse, in the unit of the cost.
    pub max_cost: f64,
    /// The distance from the original, if it was asked for.
    pub error: Option<AchievedError>,
    /// The largest distance of a boundary vertex of the original to the boundary of the result;
    /// `None` when there is no boundary.
    pub boundary_shift: Option<f64>,
    /// What fitting did, if it was asked for.
    pub fit: Option<FitReport>,
    /// What annealing did, if it was asked for; `None` when it was undone because it folded the
    /// texture.
    pub anneal: Option<AnnealReport>,
    /// What was done about the largest errors; `None` as for `anneal`.
    pub peaks: Option<PeakReport>,
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
/// An option makes no sense, or a position is not finite.
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
    options.check()?;
    check_positions(mesh)?;
    let mut working = mesh.clone();
    let faces_before = mesh.topology().face_count();
    let target = options.limits.face_target(faces_before);
    let mut observer = Observer::new(faces_before, target, observe);
    let mut run = collapse(&mut working, options, &mut |now| observer.observe(now));
    let is_changed = !observer.is_stopped() && !run.log.is_empty();
    let wants_finish = is_changed && (options.fit.is_some() || options.peaks.is_some());
    let wants_error = options.max_error.is_some() || options.error != ErrorCheck::None;
    let has_faces = mesh.topology().face_count() > 0;
    let mut level = Level::at_end(working, &run);
    let mut error = None;
    let finished = if has_faces && (wants_finish || wants_error) {
        let original = Surface::new(mesh)?;
        let steps = if wants_finish { steps(options, target) } else { Steps::default() };
        let texture = texture(mesh, options);
        let finishing = Finishing::new(mesh, &original, &options.constraints, steps, texture);
        let measuring =
            Measuring { original: &original, check: options.error, limit: options.max_error };
        if let Some(limit) = options.max_error {
            let search = Search {
                mesh,
                marks: Marks::new(mesh, &options.constraints),
                log: &run.log,
                finishing: &finishing,
                measuring,
                limit,
                squeeze: squeeze(options, target),
            };
            let found = if observer.is_stopped() { None } else { search.run(&mut observer)? };
            if let Some(found) = found {
                if found.collapses < run.log.len() || !found.error.is_within(limit) {
                    run.truncate(found.collapses);
                    let faces = found.finished.mesh.topology().face_count();
                    run.stop = if faces <= target { StopReason::Faces } else { StopReason::Error };
                }
                (level, error) = (found.level, Some(found.error));
                found.finished
            } else {
                run.truncate(0);
                let marks = Marks::new(mesh, &options.constraints);
                level = Level::new(mesh, &marks, &run.log, 0)?;
                Finished::untouched(level.mesh.clone(), FitConstraints::default())
            }
        } else {
            let finished = finishing.finish(&level, &mut observer)?;
            if wants_error && !observer.stops(Phase::Measure, &finished.mesh) {
                error = Some(measuring.measure(&finished.mesh)?.0);
            }
            finished
        }
    } else {
        Finished::untouched(level.mesh.clone(), FitConstraints::default())
    };
    if observer.is_stopped() {
        run.stop = StopReason::Cancelled;
    }
    let follow = |&v: &Option<VertexId>| match &finished.vertex_map {
        Some(map) => v.and_then(|v| map.get(v).copied().flatten()),
        None => v,
    };
    Ok(Simplified {
        vertex_map: VertexMap::from_vec(level.became.as_slice().iter().map(follow).collect()),
        boundary_shift: boundary_shift(mesh, &finished.mesh),
        mesh: finished.mesh,
        log: run.log,
        stop: run.stop,
        refusals: run.refusals,
        max_cost: run.max_cost,
        error,
        fit: finished.fit,
        anneal: finished.anneal,
        peaks: finished.peaks,
    })
}

fn check_positions(mesh: &TriMesh) -> Result<(), SimplifyError> {
    let mut used = mesh.topology().vertices().map(|v| (v, mesh.position(v)));
    match used.find(|(_, position)| !position.is_finite()) {
        Some((vertex, position)) => Err(SimplifyError::NotFinite { vertex, position }),
        None => Ok(()),
    }
}

/// What the options do with a level; at least `target` faces are left, or one fewer.
fn steps(options: &Options, target: usize) -> Steps {
    let forbids = options.forbid_intersections;
    let guarded = |fit: FitOptions| FitOptions {
        forbid_intersections: fit.forbid_intersections || forbids,
        ..fit
    };
    let anneal = options.anneal.filter(|_| options.fit.is_some());
    Steps {
        fit: options.fit.map(guarded),
        anneal: anneal.map(|anneal| AnnealOptions { fit: guarded(anneal.fit), ..anneal }),
        peaks: options.peaks.map(|peaks| PeakOptions {
            min_faces: peaks.min_faces.max(target.saturating_sub(1)),
            forbid_intersections: peaks.forbid_intersections || forbids,
            min_component_vertices: options.min_component_vertices,
            fit: guarded(peaks.fit),
            ..peaks
        }),
    }
}

/// The texture that must not fold over, if there is one that counts.
fn texture<'a>(mesh: &'a TriMesh, options: &'a Options) -> Option<Texture<'a>> {
    let attributes = options.attributes.as_ref().filter(|a| a.has_texture())?;
    let seams = options.constraints.features.as_ref()?;
    (options.attribute_weight > 0.0).then_some(Texture { original: mesh, attributes, seams })
}

/// Whether and how a mesh within the limit is collapsed further. What is left of other limits would
/// not be known, and attributes would be passed over.
fn squeeze(options: &Options, target: usize) -> Option<CollapseBack<'static>> {
    let Options { limits, attributes, attribute_weight, .. } = options;
    let is_bare = attributes.is_none() || *attribute_weight == 0.0;
    let Limits { vertices, cost, collapses, time, .. } = *limits;
    let is_free = (vertices, cost, collapses, time) == (None, None, None, None);
    (options.squeeze && is_free && is_bare).then_some(CollapseBack {
        faces: target,
        locked: &[],
        boundary: options.constraints.boundary,
        forbid_intersections: options.forbid_intersections,
        min_component_vertices: options.min_component_vertices,
    })
}

/// The largest distance of a boundary vertex of one mesh to the boundary of another.
fn boundary_shift(from: &TriMesh, to: &TriMesh) -> Option<f64> {
    let topology = from.topology();
    let vertices = topology.vertices().filter(|&v| topology.is_boundary_vertex(v));
    let points: Vec<DVec3> = vertices.map(|v| from.position(v)).collect();
    Curve::boundary(to)?.farthest(&points)
}
