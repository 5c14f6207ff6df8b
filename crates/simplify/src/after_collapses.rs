//! What follows the collapses: refinement, tolerance, report.

use glam::DVec3;
use mesh_collapse::{CollapseLog, Constraints, Level, Policy, Protected, Run, StopReason};
use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_metric::Surface;
use mesh_refine::{
    CollapseBack, Curve, FitConstraints, Observer, Pipeline, Refined, Steps, Texture,
};

use crate::error::SimplifyError;
use crate::folds::original_at_folds;
use crate::options::Options;
use crate::shortfall::Shortfall;
use crate::simplified::Simplified;
use crate::tolerance::level_search::LevelSearch;
use crate::tolerance::measure::{AchievedError, Measuring};

/// The largest number of faces of an input on which every preset is tried, and every stage of refinement measured.
pub(crate) const SMALL: usize = 5_000;

/// The factors on the number of faces at which levels are tried where faces stay turned over.
const MORE_FACES: [f64; 4] = [1.02, 1.05, 1.1, 1.2];

/// A refined mesh, and what the vertices of the input are in the level that it was made from.
type RefinedLevel = (Refined, VertexMap<Option<VertexId>>);

/// What follows the collapses.
pub(crate) struct AfterCollapses<'a> {
    /// The input.
    pub(crate) mesh: &'a TriMesh,
    /// Custom constraints, as they were before the run.
    pub(crate) constraints: &'a Constraints,
    pub(crate) options: &'a Options,
}

impl AfterCollapses<'_> {
    /// The result of a run that has left `level`.
    pub(crate) fn result(
        &self,
        level: Level,
        mut run: Run,
        mut observer: Observer<'_>,
    ) -> Result<Simplified, SimplifyError> {
        let Self { mesh, options, .. } = *self;
        let is_changed = !observer.is_stopped() && run.collapses > 0;
        let has_faces = mesh.topology().face_count() > 0;
        let mut error = None;
        let (refined, vertex_map) = if has_faces && options.tolerance.check.is_some() {
            let steps = if is_changed { self.steps() } else { Steps::default() };
            self.measured(level, &mut run, steps, &mut error, &mut observer)?
        } else if has_faces && is_changed {
            let made = self.refined(level, &mut observer)?;
            self.without_folds(made, &mut run, &mut observer)?
        } else {
            untouched(level)
        };
        if observer.is_stopped() {
            run.stop = StopReason::Cancelled;
        }
        Ok(Simplified {
            vertex_map: refined.map_from_original(vertex_map),
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

    /// The level refined, or where nothing is refined, its faces that are turned over turned back.
    fn refined(
        &self,
        level: Level,
        observer: &mut Observer<'_>,
    ) -> Result<RefinedLevel, SimplifyError> {
        let Self { mesh, options, .. } = *self;
        let original = if options.refine.is_any() {
            Some(Surface::new(mesh)?)
        } else if options.refine.unfold && options.protect.min_cosine.is_some() {
            original_at_folds(mesh, &level)
        } else {
            None
        };
        let Some(original) = original else { return Ok(untouched(level)) };
        let (protect, steps) = (&options.protect, self.steps());
        let pipeline = Pipeline::new(mesh, &original, protect, steps, self.texture());
        Ok(pipeline.finish(level, observer)?)
    }

    /// If faces of a level stay turned over, a level with a few more faces where none does, if there is one.
    fn without_folds(
        &self,
        made: RefinedLevel,
        run: &mut Run,
        observer: &mut Observer<'_>,
    ) -> Result<RefinedLevel, SimplifyError> {
        let Self { mesh, options, .. } = *self;
        if made.0.turned_over() == 0 {
            return Ok(made);
        }
        let mut constraints = self.constraints.clone();
        constraints.prepare(mesh);
        let protected = Protected::new(mesh, &options.protect, constraints);
        let faces = made.0.mesh.topology().face_count() as f64;
        for more in MORE_FACES {
            let collapses = run.log.count_for_faces((faces * more).ceil() as usize);
            if collapses >= run.log.len() || observer.is_stopped() {
                continue;
            }
            let level = Level::new(mesh, &protected, &run.log, collapses)?;
            let finer = self.refined(level, observer)?;
            if finer.0.turned_over() == 0 {
                run.truncate(collapses);
                run.stop = StopReason::NothingLeft;
                return Ok(finer);
            }
        }
        Ok(made)
    }

    /// The level refined and measured, or with an error limit the coarsest level within it.
    fn measured(
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
        let made = pipeline.finish(level, observer)?;
        let (refined, vertex_map) = self.without_folds(made, run, observer)?;
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

    /// The stages of the refinement; at least the wanted faces are left, or one fewer.
    fn steps(&self) -> Steps {
        let steps =
            self.options.refine.steps(&self.options.protect, self.face_target().saturating_sub(1));
        if self.options.attributes.poses.is_some() {
            // These stages would move faces to where the errors are in one pose.
            return Steps { anneal: None, max_error: None, ..steps };
        }
        // Stages that raise the mean distance are undone.
        let is_small = self.mesh.topology().face_count() <= SMALL;
        Steps { undo: is_small && self.options.counts_mean(), ..steps }
    }

    /// The texture that must not fold over, if there is one that counts.
    pub(crate) fn texture(&self) -> Option<Texture<'_>> {
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

/// A level that is not refined.
pub(crate) fn untouched(level: Level) -> RefinedLevel {
    (Refined::untouched(level.mesh, FitConstraints::default()), level.vertex_map)
}

/// The largest distance of a boundary vertex of one mesh to the boundary of another.
fn boundary_shift(from: &TriMesh, to: &TriMesh) -> Option<f64> {
    let boundary = Curve::boundary(to)?;
    let topology = from.topology();
    let vertices = topology.vertices().filter(|&v| topology.is_boundary_vertex(v));
    let points: Vec<DVec3> = vertices.map(|v| from.position(v)).collect();
    boundary.farthest(&points)
}
