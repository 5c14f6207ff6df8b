//! Search for the coarsest level of a run that is within a distance of the original after refinement.

use mesh_collapse::{CollapseLog, Level, Phase, Protected, Snapshot};
use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_refine::{CollapseBack, Observer, Pipeline, Refined};

use crate::error::SimplifyError;
use crate::tolerance::bisection::{between, scaled};
use crate::tolerance::decimate::decimate_to_tolerance;
use crate::tolerance::level_estimate::LevelEstimate;
use crate::tolerance::measure::{AchievedError, Measuring};

/// Input of the search.
pub(crate) struct LevelSearch<'a> {
    pub(crate) mesh: &'a TriMesh,
    /// The locked vertices and feature edges of the mesh.
    pub(crate) protected: Protected,
    /// The run on the mesh.
    pub(crate) log: &'a CollapseLog,
    pub(crate) pipeline: &'a Pipeline<'a>,
    pub(crate) measuring: Measuring<'a>,
    pub(crate) limit: f64,
    /// If set, a level within the limit is collapsed further as described here, instead of being refined.
    pub(crate) decimate: Option<CollapseBack<'a>>,
}

/// Result of the search: a level, the vertex of the level for each vertex of the original, the finished mesh, and its
/// distance from the original.
pub(crate) struct Found {
    pub(crate) collapses: usize,
    pub(crate) vertex_map: VertexMap<Option<VertexId>>,
    pub(crate) refined: Refined,
    pub(crate) error: AchievedError,
}

impl LevelSearch<'_> {
    /// The coarsest level whose refined mesh is within the limit. If none is measured to be within the limit, the
    /// result is the original with its measured distance. Errors need not grow with the number of collapses, so a
    /// coarser level within the limit may exist. If levels are collapsed further, the search ends at the first level
    /// within the limit, and this level is not refined.
    ///
    /// `snapshots` are meshes that the run has saved on the way, if any.
    ///
    /// When the observer stops the search, the result is the coarsest level measured to be within the limit so far;
    /// `None` if there is none.
    pub(crate) fn run(
        &self,
        snapshots: Vec<Snapshot>,
        observer: &mut Observer<'_>,
    ) -> Result<Option<Found>, SimplifyError> {
        let total = self.log.len();
        let estimate = LevelEstimate {
            mesh: self.mesh,
            protected: &self.protected,
            log: self.log,
            original: self.measuring.original,
            limit: self.limit,
            // A level that is not refined stays as it is.
            both_ways: self.decimate.is_some(),
        };
        let (level, mut collapses) = estimate.level(snapshots, observer)?;
        let (vertices, mut estimated) = (used_vertices(self.mesh), Some(level));
        let (mut good, mut bad): (Option<Found>, Option<usize>) = (None, None);
        loop {
            let level = estimated.take().map_or_else(|| self.level(collapses), Ok)?;
            let Some(found) = self.attempt(level, collapses, observer)? else { return Ok(good) };
            let is_within = found.error.is_within(self.limit);
            if collapses == if is_within { total } else { 0 }
                || (is_within && self.decimate.is_some())
            {
                return Ok(Some(found));
            } else if is_within {
                good = Some(found);
            } else {
                bad = Some(collapses);
            }
            collapses = match (good.as_ref().map(|good| good.collapses), bad) {
                (Some(good), None) => scaled(vertices, good, 0.8).min(total),
                // Large steps do no harm here: decimation removes the surplus faces.
                (None, _) => {
                    scaled(vertices, collapses, if self.decimate.is_some() { 1.7 } else { 1.3 })
                }
                (Some(more), Some(fewer)) => match between(vertices, more, fewer) {
                    Some(middle) => middle,
                    None => return Ok(good),
                },
            };
        }
    }

    /// Collapses a level further, or refines it, and measures the result; `None` when the observer stops before that.
    fn attempt(
        &self,
        level: Level,
        collapses: usize,
        observer: &mut Observer<'_>,
    ) -> Result<Option<Found>, SimplifyError> {
        if observer.stops(Phase::Search, self.mesh) {
            return Ok(None);
        }
        let (refined, vertex_map, error) = match &self.decimate {
            Some(to) if collapses < self.log.len() => {
                let (mut level, vertex_map) = self.pipeline.leave(level);
                let error = decimate_to_tolerance(
                    &mut level,
                    self.mesh,
                    &self.measuring,
                    self.limit,
                    to,
                    observer,
                )?;
                let error = self.unfolded(&mut level, &vertex_map, error)?;
                (level, vertex_map, error)
            }
            _ => {
                let (refined, vertex_map) = self.pipeline.finish(level, observer)?;
                let error = self.measuring.measure(&refined.mesh, observer)?;
                (refined, vertex_map, error)
            }
        };
        Ok(error.map(|error| Found { collapses, vertex_map, refined, error }))
    }

    /// Turns back the faces that decimation has turned over, unless the mesh is beyond the limit then. Returns its
    /// distance.
    fn unfolded(
        &self,
        level: &mut Refined,
        vertex_map: &VertexMap<Option<VertexId>>,
        error: Option<AchievedError>,
    ) -> Result<Option<AchievedError>, SimplifyError> {
        let before = level.mesh.clone();
        self.pipeline.unfold(level, vertex_map);
        let Some(report) = level.unfold.as_mut().filter(|report| report.has_helped()) else {
            return Ok(error);
        };
        let after = self.measuring.measure(&level.mesh, &mut Observer::none())?;
        if after.is_some_and(|after| after.is_within(self.limit)) {
            return Ok(after);
        }
        report.turned_after = report.turned_before;
        level.mesh = before;
        Ok(error)
    }

    fn level(&self, collapses: usize) -> Result<Level, SimplifyError> {
        Ok(Level::new(self.mesh, &self.protected, self.log, collapses)?)
    }
}

/// The number of vertices that have faces.
fn used_vertices(mesh: &TriMesh) -> usize {
    let topology = mesh.topology();
    topology.vertices().filter(|&v| !topology.is_isolated_vertex(v)).count()
}
