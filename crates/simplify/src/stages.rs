//! Stages of a run of collapses, as levels of detail.

use mesh_collapse::{Boundary, CollapseLog, Constraints, Level, Protected};
use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_metric::Surface;
use mesh_refine::{Observer, Pipeline, Steps, UnfoldOptions};

use crate::after_collapses::{AfterCollapses, untouched};
use crate::error::SimplifyError;
use crate::folds::original_at_folds;
use crate::options::Options;
use crate::tolerance::measure::{ErrorCheck, Measuring};

/// The stages of a run of collapses.
///
/// A stage is the mesh after some of the collapses, except around faces that the collapses have turned over: flips and
/// moves turn them back, if they can. Then boundary vertices, vertices of features, and vertices that are where they
/// were in the input stay there.
#[derive(Debug)]
pub struct Stages<'a> {
    mesh: &'a TriMesh,
    log: &'a CollapseLog,
    options: Options,
}

impl<'a> Stages<'a> {
    /// Of a run on `mesh`. Of the options of the run, the features, the locked vertices, the limits on faces and the
    /// attributes are needed; the boundary is locked, and no new intersections arise, whatever they say.
    #[must_use]
    pub fn new(mesh: &'a TriMesh, log: &'a CollapseLog, mut options: Options) -> Self {
        options.protect.boundary = Boundary::Lock;
        options.protect.forbid_intersections = true;
        Self { mesh, log, options }
    }

    /// The stage after the first `collapses`, without gaps, and its vertex for each vertex of the input.
    ///
    /// # Errors
    /// The log belongs to another mesh, or the input around the faces that are turned over has no area.
    pub fn level(
        &self,
        collapses: usize,
    ) -> Result<(TriMesh, VertexMap<Option<VertexId>>), SimplifyError> {
        let Self { mesh, log, options } = self;
        let protect = &options.protect;
        let protected = Protected::new(mesh, protect, Constraints::default());
        let mut level = Level::new(mesh, &protected, log, collapses)?;
        let (refined, vertex_map) = match original_at_folds(mesh, &level) {
            None => untouched(level),
            Some(original) => {
                hold_unmoved(mesh, &mut level);
                let steps = Steps {
                    unfold: Some(UnfoldOptions { forbid_intersections: true }),
                    ..Steps::default()
                };
                let after = AfterCollapses { mesh, constraints: &Constraints::default(), options };
                let pipeline = Pipeline::new(mesh, &original, protect, steps, after.texture());
                pipeline.finish(level, &mut Observer::none())?
            }
        };
        let vertex_map = refined.map_from_original(vertex_map);
        Ok((refined.mesh, vertex_map))
    }

    /// The largest number of collapses whose stage stays within a distance of the input, in both directions. The search
    /// stops within 0.5 % of the vertices. The distance is measured as for
    /// [`ToleranceOptions::distance`](crate::ToleranceOptions::distance).
    ///
    /// # Errors
    /// The limit is negative or not finite, the mesh has no faces, or the log belongs to another mesh.
    pub fn within(&self, limit: f64, check: ErrorCheck) -> Result<usize, SimplifyError> {
        let fits = limit >= 0.0 && limit.is_finite();
        SimplifyError::unless(fits, "limit", limit, "at least 0 and finite")?;
        let original = Surface::new(self.mesh)?;
        let measuring = Measuring { original: &original, check, limit: Some(limit) };
        let is_within = |collapses: usize| -> Result<bool, SimplifyError> {
            let (level, _) = self.level(collapses)?;
            let error = measuring.measure(&level, &mut Observer::none())?;
            Ok(error.is_some_and(|error| error.is_within(limit)))
        };
        let (mut good, mut bad) = (0, self.log.len());
        if is_within(bad)? {
            return Ok(bad);
        }
        let vertices = self.mesh.topology().vertex_count();
        while bad - good > 1 + (vertices - good) / 200 {
            // The geometric mean of the vertex counts: errors grow with the size of the faces.
            let middle = vertices as f64 - (((vertices - good) * (vertices - bad)) as f64).sqrt();
            let middle = (middle as usize).clamp(good + 1, bad - 1);
            *(if is_within(middle)? { &mut good } else { &mut bad }) = middle;
        }
        Ok(good)
    }
}

/// Locks the vertices of a level that are where they were in the input, and the edges between them.
fn hold_unmoved(input: &TriMesh, level: &mut Level) {
    let Level { mesh, protected, vertex_map } = level;
    let topology = mesh.topology();
    let locked = protected.locked.get_or_insert_with(|| topology.vertex_map(false));
    let mut unmoved = topology.vertex_map(false);
    for (from, to) in vertex_map.iter().filter_map(|(from, to)| Some((from, (*to)?))) {
        unmoved[to] |= input.position(from) == mesh.position(to);
    }
    let kept = protected.kept.get_or_insert_with(|| topology.edge_map(false));
    topology.vertices().for_each(|v| locked[v] |= unmoved[v]);
    topology
        .edges()
        .for_each(|e| kept[e] |= topology.edge_vertices(e).into_iter().all(|v| unmoved[v]));
}
