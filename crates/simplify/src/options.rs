//! What to simplify by, as data: the policies of this crate by name, and presets of them.

use core::fmt;
use core::str::FromStr;

use crate::attributes::wedges::CornerAttributes;
use crate::collapse::constraint::Constraints;
use crate::collapse::driver::Update;
use crate::collapse::stop::Limits;
use crate::finish::anneal::AnnealOptions;
use crate::finish::fit::FitOptions;
use crate::finish::peaks::PeakOptions;

/// How a mesh is simplified; see [`crate::simplify`].
#[derive(Clone, Debug)]
pub struct Options {
    /// What a collapse costs.
    pub metric: Metric,
    /// The weight of the curvature factor on top of the cost; 0 for none. See
    /// [`CurvatureFactor`](crate::CurvatureFactor).
    pub curvature_weight: f64,
    /// Where the remaining vertex goes.
    pub placement: PlacementRule,
    /// When costs are brought up to date.
    pub update: Update,
    /// When to stop.
    pub limits: Limits,
    /// The largest allowed distance from the original, in model units, both ways. The result is
    /// the coarsest one in the sequence of collapses, up to three percent of its vertices, that was
    /// found within it after it was fitted; or a finer one, collapsed further as
    /// [`Options::squeeze`] says.
    pub max_error: Option<f64>,
    /// Whether, when `max_error` ends the collapses, a level within it is collapsed further, edge by
    /// edge, wherever that leaves it within. The result has far fewer faces than a fitted level, most
    /// of them nearly as far from the original as they may be, and is not fitted. Not with attributes
    /// that count, nor with limits of vertices, cost, collapses or time.
    pub squeeze: bool,
    /// How the distance from the original is found.
    pub error: ErrorCheck,
    /// What must stay.
    pub constraints: Constraints,
    /// The smallest cosine between the normals of a face before and after a collapse; `None`
    /// allows all. See [`NormalGuard`](crate::NormalGuard).
    pub min_cosine: Option<f64>,
    /// The shape below which faces must not get worse; `None` allows all. See
    /// [`ShapeGuard`](crate::ShapeGuard).
    pub min_shape: Option<f64>,
    /// How many vertices every component keeps; `None` for as few as possible. See
    /// [`ComponentGuard`](crate::ComponentGuard).
    pub min_component_vertices: Option<usize>,
    /// What should stay at the corners of the faces, besides the shape; see
    /// [`AttributeDeviation`](crate::AttributeDeviation). The curvature norms pass over it. The
    /// seams between wedges are not kept by this: give them as features.
    pub attributes: Option<CornerAttributes>,
    /// The weight of the attributes; 0 for none.
    pub attribute_weight: f64,
    /// Whether collapses, fitting and annealing must not make faces cross that did not before. See
    /// [`IntersectionGuard`](crate::IntersectionGuard).
    pub forbid_intersections: bool,
    /// Whether and how the result is fitted to the original. See [`fit`](crate::fit()).
    pub fit: Option<FitOptions>,
    /// Whether and how the fitted result is annealed. See [`anneal`](crate::anneal()).
    pub anneal: Option<AnnealOptions>,
    /// Whether and how the largest errors are taken down in the end. See
    /// [`cut_peaks`](crate::cut_peaks()). Guards are those of these options.
    pub peaks: Option<PeakOptions>,
}

impl Default for Options {
    fn default() -> Self {
        Self::preset(Preset::Default)
    }
}

/// A cost by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Metric {
    /// [`GarlandHeckbert`](crate::GarlandHeckbert) as published.
    Classic,
    /// [`GarlandHeckbert`](crate::GarlandHeckbert), less the errors already made.
    Marginal,
    /// [`Memoryless`](crate::Memoryless).
    Memoryless,
    /// [`Hybrid`](crate::Hybrid).
    Hybrid,
    /// [`CurvatureNorm`](crate::CurvatureNorm) with KKL02 eq. 1.
    CurvatureL1,
    /// [`CurvatureNorm`](crate::CurvatureNorm) with KKL02 eq. 2.
    CurvatureL2,
}

/// A placement by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlacementRule {
    /// [`Optimal`](crate::Optimal) among the places that keep the volume.
    OptimalVolume,
    /// [`Optimal`](crate::Optimal) among all places.
    Optimal,
    /// [`BestEndpoint`](crate::BestEndpoint): the vertices are some of the original ones.
    Endpoint,
    /// [`Midpoint`](crate::Midpoint).
    Midpoint,
    /// [`ButterflyPoint`](crate::ButterflyPoint).
    Butterfly,
}

/// How the distance of the result from the original is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ErrorCheck {
    /// Not at all; from samples when there is a largest allowed error.
    #[default]
    None,
    /// From samples of both surfaces, which may miss the largest distance by a little.
    Sampled,
    /// By proven bounds.
    Certified,
}

/// A named set of options.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Preset {
    /// Accumulated quadrics with marginal cost and kept volume: the quickest.
    Fast,
    /// The hybrid metric with a little curvature, and two rounds of fitting.
    #[default]
    Default,
    /// As the default, with eight rounds of fitting and more done about the largest errors.
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
    pub const ALL: [Self; 7] = [
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
    "there is no preset {0:?}; there are fast, default, quality, extreme, thin-features, paper-l1, paper-l2"
)]
pub struct UnknownPreset(pub String);

impl FromStr for Preset {
    type Err = UnknownPreset;

    fn from_str(name: &str) -> Result<Self, UnknownPreset> {
        let found = Self::ALL.into_iter().find(|preset| preset.name() == name);
        found.ok_or_else(|| UnknownPreset(name.to_owned()))
    }
}

impl Options {
    /// The options of a preset. No preset has a limit.
    #[must_use]
    pub fn preset(preset: Preset) -> Self {
        let base = Self {
            metric: Metric::Hybrid,
            curvature_weight: 0.1,
            placement: PlacementRule::OptimalVolume,
            update: Update::Lazy,
            limits: Limits::default(),
            max_error: None,
            squeeze: true,
            error: ErrorCheck::None,
            constraints: Constraints::default(),
            min_cosine: Some(crate::NormalGuard::default().min_cosine),
            min_shape: Some(crate::ShapeGuard::default().min_shape),
            min_component_vertices: None,
            attributes: None,
            attribute_weight: 1.0,
            forbid_intersections: false,
            fit: Some(FitOptions::default()),
            anneal: None,
            peaks: Some(PeakOptions::default()),
        };
        let paper = |metric| Self {
            metric,
            curvature_weight: 0.0,
            placement: PlacementRule::Butterfly,
            update: Update::Eager,
            squeeze: false,
            fit: None,
            peaks: None,
            ..base.clone()
        };
        let long_fit = FitOptions { rounds: 8, ..FitOptions::default() };
        let peaks = PeakOptions::default();
        let low_peaks = PeakOptions {
            spacing: 2.0,
            max_rise: 1.01,
            fit: FitOptions { rounds: 24, ..peaks.fit },
            ..peaks
        };
        match preset {
            Preset::Fast => Self {
                metric: Metric::Marginal,
                curvature_weight: 0.0,
                squeeze: false,
                fit: None,
                peaks: None,
                ..base
            },
            Preset::Default => base,
            Preset::Quality => Self { fit: Some(long_fit), peaks: Some(low_peaks), ..base },
            Preset::Extreme => {
                let anneal = Some(AnnealOptions::default());
                Self { fit: Some(long_fit), anneal, peaks: Some(low_peaks), ..base }
            }
            Preset::ThinFeatures => Self { curvature_weight: 1.0, ..base },
            Preset::PaperL1 => paper(Metric::CurvatureL1),
            Preset::PaperL2 => paper(Metric::CurvatureL2),
        }
    }

    /// The same with a number of faces to stop at.
    #[must_use]
    pub fn to_faces(mut self, faces: usize) -> Self {
        self.limits.faces = Some(faces);
        self
    }
}
