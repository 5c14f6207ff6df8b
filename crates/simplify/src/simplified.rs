//! The result of a simplification, and its report.

use mesh_collapse::{CollapseLog, Rejections, StopReason};
use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_refine::{AnnealReport, FitReport, MaxErrorReport, UnfoldReport};

use crate::preset::Preset;
use crate::shortfall::Shortfall;
use crate::tolerance::measure::AchievedError;

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
    /// empty unless [`Options::record`](crate::Options::record) is set.
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
