//! Options for a scaled mesh, and its result at the size of the original.

use mesh_collapse::{CollapseLog, FaceLimits, LogEntry, Protect, Target};
use mesh_core::UnitScale;
use mesh_refine::{AnnealReport, FitReport, MaxErrorReport};

use crate::options::{AttributeOptions, Metric, Options, ToleranceOptions};
use crate::simplified::Simplified;
use crate::tolerance::measure::AchievedError;

impl Metric {
    /// The unit of the cost as a power of length; 0 for [`Metric::Custom`], whose unit is unknown.
    #[must_use]
    pub fn length_exponent(self) -> i32 {
        match self {
            Self::Quadric | Self::IncrementalQuadric | Self::Memoryless | Self::Hybrid => 4,
            Self::CurvatureL1 => -1,
            Self::CurvatureL2 => -2,
            // Custom policies see the mesh at its own size.
            Self::Custom => 0,
        }
    }
}

impl Options {
    /// The options for a scaled mesh.
    pub(crate) fn scaled(&self, scale: UnitScale) -> Self {
        let length = |length: Option<f64>| length.map(|length| scale.length(length));
        let exponent = self.cost.metric.length_exponent();
        let cost = self.target.cost.map(|cost| scale.power(cost, exponent));
        let limits =
            FaceLimits { max_edge: length(self.protect.limits.max_edge), ..self.protect.limits };
        let corners = self.attributes.corners.as_ref().map(|corners| corners.scaled(scale));
        let poses = self.attributes.poses.as_ref().map(|poses| poses.scaled(scale));
        Self {
            target: Target { cost, ..self.target },
            protect: Protect { limits, ..self.protect.clone() },
            tolerance: ToleranceOptions {
                distance: length(self.tolerance.distance),
                ..self.tolerance
            },
            attributes: AttributeOptions { corners, poses, weight: self.attributes.weight },
            ..self.clone()
        }
    }
}

impl Simplified {
    /// The result of a scaled mesh at the size of the original.
    pub(crate) fn restored(mut self, scale: UnitScale, options: &Options) -> Self {
        let length = |length: f64| scale.original_length(length);
        let exponent = options.cost.metric.length_exponent();
        let cost = |cost: f64| scale.original_power(cost, exponent);
        scale.restore(self.mesh.positions_mut());
        let entry = |entry: LogEntry| LogEntry {
            position: scale.original_point(entry.position),
            cost: cost(entry.cost),
            ..entry
        };
        let log = self.log.into_entries().into_iter().map(entry).collect();
        let fit = |fit: FitReport| FitReport {
            rms_before: length(fit.rms_before),
            rms_last: length(fit.rms_last),
            ..fit
        };
        let anneal = |anneal: AnnealReport| AnnealReport {
            rms_before: length(anneal.rms_before),
            rms_after: length(anneal.rms_after),
            ..anneal
        };
        let max_error = |reduced: MaxErrorReport| MaxErrorReport {
            largest_before: length(reduced.largest_before),
            largest_after: length(reduced.largest_after),
            ..reduced
        };
        let error = |error: AchievedError| AchievedError {
            lower: length(error.lower),
            upper: error.upper.map(length),
        };
        Self {
            log: CollapseLog::from_entries(log),
            max_cost: cost(self.max_cost),
            error: self.error.map(error),
            boundary_shift: self.boundary_shift.map(length),
            fit: self.fit.map(fit),
            anneal: self.anneal.map(anneal),
            max_error: self.max_error.map(max_error),
            ..self
        }
    }
}
