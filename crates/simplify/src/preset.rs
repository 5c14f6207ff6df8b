//! Named sets of options.

use core::fmt;
use core::str::FromStr;
use mesh_collapse::{NormalConstraint, Protect, Schedule, ShapeConstraint, Target};
use mesh_refine::{AnnealOptions, FitOptions, MaxErrorOptions};

use crate::options::{
    AttributeOptions, CollapseOptions, LimitOptions, Metric, Options, PlacementRule, RefineOptions,
};

/// A named set of options.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Preset {
    /// Accumulated quadrics with marginal cost, and nothing recorded: for when only speed counts.
    Draft,
    /// Accumulated quadrics with marginal cost and kept volume: quick.
    Fast,
    /// The hybrid metric with a little curvature, and four rounds of fitting.
    #[default]
    Default,
    /// As the default, with nine rounds of fitting and more done about the largest errors; results with less
    /// than a 150th of the faces trade some, too.
    Quality,
    /// As quality, and then annealed: many times slower.
    Extreme,
    /// As the default, with a curvature factor of full weight: lower maximum on thin parts for a
    /// little more mean.
    ThinFeatures,
    /// The curvature norm KKL02 eq. 1 with butterfly placement, as published.
    PaperL1,
    /// The curvature norm KKL02 eq. 2 with butterfly placement, as published.
    PaperL2,
}

impl Preset {
    /// All presets.
    pub const ALL: &'static [Self] = &[
        Self::Draft,
        Self::Fast,
        Self::Default,
        Self::Quality,
        Self::Extreme,
        Self::ThinFeatures,
        Self::PaperL1,
        Self::PaperL2,
    ];

    /// The name, as [`FromStr`] takes it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Fast => "fast",
            Self::Default => "default",
            Self::Quality => "quality",
            Self::Extreme => "extreme",
            Self::ThinFeatures => "thin-features",
            Self::PaperL1 => "paper-l1",
            Self::PaperL2 => "paper-l2",
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is no preset.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "there is no preset {0:?}; there are draft, fast, default, quality, extreme, thin-features, paper-l1, paper-l2"
)]
pub struct UnknownPreset(pub String);

impl FromStr for Preset {
    type Err = UnknownPreset;

    fn from_str(name: &str) -> Result<Self, UnknownPreset> {
        let found = Self::ALL.iter().find(|preset| preset.name() == name);
        found.copied().ok_or_else(|| UnknownPreset(name.to_owned()))
    }
}

impl Default for Options {
    fn default() -> Self {
        Self::preset(Preset::Default)
    }
}

impl Options {
    /// The options of a preset. No preset has a limit.
    #[must_use]
    pub fn preset(preset: Preset) -> Self {
        let max_error = MaxErrorOptions::default();
        let low_peaks = MaxErrorOptions {
            spacing: 2.0,
            max_rise: 1.01,
            fit: FitOptions { rounds: 24, ..max_error.fit },
            ..max_error
        };
        let long_fit = FitOptions {
            rounds: 9,
            samples_per_face: 30,
            own_samples_per_face: 12,
            samples_per_triangle: 6,
            ..FitOptions::default()
        };
        let few_trades = AnnealOptions {
            sweeps: 0,
            rounds: 20,
            reduction_per_round: 150.0,
            samples_per_face: 40,
            ..AnnealOptions::default()
        };
        let quality = RefineOptions {
            fit: Some(long_fit),
            anneal: Some(few_trades),
            max_error: Some(low_peaks),
        };
        // Earlier than by default, which is worth .3 % of the mean error to a tenth of the faces. Still earlier or
        // later, means are the same within half a percent; the largest error on a small mesh is a matter of single
        // edges.
        let careful = CollapseOptions { switch_ratio: Some(12.0), ..CollapseOptions::default() };
        let (collapse, finish) = match preset {
            Preset::Draft => (
                CollapseOptions {
                    metric: Metric::IncrementalQuadric,
                    curvature_weight: 0.0,
                    placement: PlacementRule::Optimal,
                    record: false,
                    ..CollapseOptions::default()
                },
                RefineOptions::default(),
            ),
            Preset::Fast => (
                CollapseOptions {
                    metric: Metric::IncrementalQuadric,
                    curvature_weight: 0.0,
                    ..CollapseOptions::default()
                },
                RefineOptions::default(),
            ),
            Preset::Default => (CollapseOptions::default(), RefineOptions::short()),
            Preset::Quality => (careful, quality),
            Preset::Extreme => {
                let anneal = Some(AnnealOptions::default());
                let collapse = CollapseOptions { switch_ratio: None, ..careful };
                (collapse, RefineOptions { anneal, ..quality })
            }
            Preset::ThinFeatures => {
                let curvature_weight = 1.0;
                (CollapseOptions { curvature_weight, ..careful }, RefineOptions::short())
            }
            Preset::PaperL1 => {
                (CollapseOptions::published(Metric::CurvatureL1), RefineOptions::default())
            }
            Preset::PaperL2 => {
                (CollapseOptions::published(Metric::CurvatureL2), RefineOptions::default())
            }
        };
        let (limit, attributes) = (LimitOptions::default(), AttributeOptions::default());
        Self { collapse, refine: finish, limit, attributes }
    }
}

impl Default for CollapseOptions {
    /// Those of [`Preset::Default`].
    fn default() -> Self {
        Self {
            metric: Metric::Hybrid,
            curvature_weight: 0.1,
            placement: PlacementRule::OptimalVolume,
            schedule: Schedule::Parallel,
            switch_ratio: Some(3.0),
            record: true,
            limits: Target::default(),
            protect: Protect::default(),
            min_cosine: Some(NormalConstraint::default().min_cosine),
            min_shape: Some(ShapeConstraint::default().min_shape),
            min_component_vertices: None,
            forbid_intersections: false,
        }
    }
}

impl CollapseOptions {
    /// As in KKL02: a norm, the butterfly point, and all costs up to date.
    fn published(metric: Metric) -> Self {
        Self {
            metric,
            curvature_weight: 0.0,
            placement: PlacementRule::Butterfly,
            schedule: Schedule::Exact,
            ..Self::default()
        }
    }
}

impl RefineOptions {
    /// Those of [`Preset::Default`]: a short fit, and the largest errors taken down.
    fn short() -> Self {
        let (fit, max_error) = (Some(FitOptions::default()), Some(MaxErrorOptions::default()));
        Self { fit, anneal: None, max_error }
    }
}
