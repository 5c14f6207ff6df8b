//! Named sets of options.

use core::fmt;
use core::str::FromStr;
use mesh_collapse::{Protect, Schedule, Target};
use mesh_refine::{AnnealOptions, FitOptions, MaxErrorOptions};

use crate::options::{
    AttributeOptions, CostOptions, Metric, Options, PlacementRule, RefineOptions, ToleranceOptions,
    Tuning,
};

/// A named set of options.
///
/// On small meshes chance decides which order of collapses ends closest to the input. So a careful preset also makes
/// the result of the next cheaper one, and keeps that if its mean distance is smaller by more than a percent:
/// [`Simplified::preset_kept`](crate::Simplified::preset_kept). [`Preset::Fast`] tries [`Preset::Draft`], and
/// [`Preset::Default`] tries fast, on inputs of up to 5,000 faces. [`Preset::Quality`] tries the default, and
/// [`Preset::Extreme`] tries quality, on these inputs, and for results of up to 1,000 faces from inputs of up to 100,000. On inputs of up to 5,000 faces every stage of
/// refinement is undone that raises the mean distance. All this holds for the options of a preset with any target of
/// faces, protection, attributes and seed, but not with an error limit, a time limit or
/// [`FitNorm::Max`](crate::FitNorm::Max).
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
    /// Quadrics of Garland and Heckbert 1997 at the point of least cost, one edge after another, without refinement:
    /// the distance that KKL02 compares with. A curvature weight of 1 gives its distance and curvature.
    Quadrics,
    /// The curvature norm KKL02 eq. 1 with butterfly placement, as published: areas are a third of the adjacent faces,
    /// and every collapse is allowed that keeps the mesh manifold. Faces may fold and become slivers.
    PaperL1,
    /// As [`Preset::PaperL1`], with the norm KKL02 eq. 2.
    PaperL2,
    /// As [`Preset::PaperL1`], with the constraints of the other presets, which are not in the paper: no collapse turns
    /// a face over or leaves a sliver.
    PaperL1Guarded,
    /// As [`Preset::PaperL1Guarded`], with the norm KKL02 eq. 2.
    PaperL2Guarded,
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
        Self::Quadrics,
        Self::PaperL1,
        Self::PaperL2,
        Self::PaperL1Guarded,
        Self::PaperL2Guarded,
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
            Self::Quadrics => "quadrics",
            Self::PaperL1 => "paper-l1",
            Self::PaperL2 => "paper-l2",
            Self::PaperL1Guarded => "paper-l1-guarded",
            Self::PaperL2Guarded => "paper-l2-guarded",
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
    "there is no preset {0:?}; there are draft, fast, default, quality, extreme, thin-features, quadrics, paper-l1, \
     paper-l2, paper-l1-guarded, paper-l2-guarded"
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
    /// The options of a preset. No preset has a target.
    #[must_use]
    pub fn preset(preset: Preset) -> Self {
        let plain = Self {
            target: Target::default(),
            cost: CostOptions::default(),
            placement: PlacementRule::OptimalVolume,
            protect: Protect::default(),
            refine: RefineOptions::default(),
            tolerance: ToleranceOptions::default(),
            attributes: AttributeOptions::default(),
            record: true,
        };
        let quadrics = CostOptions {
            metric: Metric::IncrementalQuadric,
            curvature_weight: 0.0,
            ..CostOptions::default()
        };
        // An earlier switch than by default lowers the mean error at a tenth of the faces by .3 %. At other ratios the
        // means agree within half a percent. On parts with flat and round faces it may raise them.
        let careful = CostOptions { switch_ratio: Some(12.0), ..CostOptions::default() };
        match preset {
            Preset::Draft => Self {
                cost: quadrics,
                placement: PlacementRule::Optimal,
                refine: RefineOptions::unfold_only(),
                record: false,
                ..plain
            },
            Preset::Fast => Self { cost: quadrics, refine: RefineOptions::unfold_only(), ..plain },
            Preset::Default => plain,
            Preset::Quality => Self { cost: careful, refine: RefineOptions::quality(), ..plain },
            Preset::Extreme => {
                let mut refine = RefineOptions::quality();
                refine.tuning.anneal = AnnealOptions::default();
                Self { cost: CostOptions { switch_ratio: None, ..careful }, refine, ..plain }
            }
            Preset::ThinFeatures => {
                Self { cost: CostOptions { curvature_weight: 1.0, ..careful }, ..plain }
            }
            Preset::Quadrics => Self {
                cost: CostOptions {
                    metric: Metric::Quadric,
                    schedule: Schedule::Lazy,
                    curvature_weight: 0.0,
                    ..plain.cost
                },
                placement: PlacementRule::Optimal,
                refine: RefineOptions::unfold_only(),
                ..plain
            },
            Preset::PaperL1 => plain.norm(Metric::CurvatureL1).unguarded(),
            Preset::PaperL2 => plain.norm(Metric::CurvatureL2).unguarded(),
            Preset::PaperL1Guarded => plain.norm(Metric::CurvatureL1),
            Preset::PaperL2Guarded => plain.norm(Metric::CurvatureL2),
        }
    }

    /// As in KKL02: a norm, the butterfly point, and all costs up to date.
    fn norm(self, metric: Metric) -> Self {
        Self {
            cost: CostOptions {
                metric,
                curvature_weight: 0.0,
                schedule: Schedule::Exact,
                ..self.cost
            },
            placement: PlacementRule::Butterfly,
            refine: RefineOptions::unfold_only(),
            ..self
        }
    }

    /// Without constraints on faces, of which KKL02 has none. (The quadrics of the boundary have no part in a norm.)
    fn unguarded(mut self) -> Self {
        self.protect.min_cosine = None;
        self.protect.min_shape = None;
        self
    }
}

impl Default for CostOptions {
    /// The cost of [`Preset::Default`].
    fn default() -> Self {
        Self {
            metric: Metric::Hybrid,
            curvature_weight: 0.1,
            schedule: Schedule::Parallel,
            switch_ratio: Some(3.0),
        }
    }
}

impl Default for RefineOptions {
    /// The refinement of [`Preset::Default`]: a short fit, then the largest errors are reduced.
    fn default() -> Self {
        Self { fit: true, max_error: true, ..Self::unfold_only() }
    }
}

impl RefineOptions {
    /// The refinement of [`Preset::Quality`]: a long fit, a few redistributed faces, and more rounds against the
    /// largest errors.
    fn quality() -> Self {
        let max_error = MaxErrorOptions::default();
        let tuning = Tuning {
            fit: FitOptions {
                rounds: 9,
                samples_per_face: 30,
                own_samples_per_face: 12,
                samples_per_triangle: 6,
                ..FitOptions::default()
            },
            anneal: AnnealOptions {
                sweeps: 0,
                rounds: 20,
                reduction_per_round: 150.0,
                samples_per_face: 40,
                ..AnnealOptions::default()
            },
            max_error: MaxErrorOptions {
                spacing: 2.0,
                max_rise: 1.01,
                fit: FitOptions { rounds: 24, ..max_error.fit },
                ..max_error
            },
        };
        Self { fit: true, anneal: true, max_error: true, tuning, ..Self::unfold_only() }
    }
}
