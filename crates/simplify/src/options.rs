//! Options of a simplification, as data.

use core::str::FromStr;

use mesh_collapse::{Protect, Schedule, Target};
use mesh_refine::{
    AnnealOptions, CornerAttributes, FitNorm, FitOptions, MaxErrorOptions, Poses, Steps,
    UnfoldOptions,
};

use crate::tolerance::measure::ErrorCheck;

/// How a mesh is simplified; see [`crate::simplify`].
///
/// The fields follow the order of the work: edges collapse until the [`Target`] is met, the result is refined, and its
/// distance from the input is held to a tolerance. No option changes the meaning of another; options that exclude each
/// other are an error.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Options {
    /// When to stop.
    pub target: Target,
    /// What a collapse costs, and in which order edges collapse.
    pub cost: CostOptions,
    /// Where the remaining vertex goes.
    pub placement: PlacementRule,
    /// What must stay. Every stage obeys it.
    pub protect: Protect,
    /// What brings the result closer to the input.
    pub refine: RefineOptions,
    /// How far the result may be from the input.
    pub tolerance: ToleranceOptions,
    /// Values at the corners of the faces that should change as little as the shape.
    pub attributes: AttributeOptions,
    /// Whether every collapse is recorded; see [`Simplified::log`](crate::Simplified::log). Takes 60 bytes for each.
    pub record: bool,
}

/// What a collapse costs, and in which order edges collapse.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CostOptions {
    /// Cost of a collapse.
    pub metric: Metric,
    /// Weight of the curvature factor, which multiplies the cost; 0 for none. See
    /// [`CurvatureFactor`](crate::CurvatureFactor). Not with the curvature norms.
    pub curvature_weight: f64,
    /// Order of the collapses, and when costs are updated.
    pub schedule: Schedule,
    /// With [`Schedule::Parallel`] and [`Metric::Hybrid`]: the ratio of faces to wanted faces at which this metric
    /// takes over from accumulated quadrics, which are several times faster. See [`Plan`](crate::Plan) for the cases in
    /// which it takes over earlier. `None` for the metric from the beginning; at least 1 otherwise.
    pub switch_ratio: Option<f64>,
}

/// What brings the result closer to the input.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RefineOptions {
    /// Whether the result is fitted: vertices move and edges flip. See [`fit`](crate::fit()).
    pub fit: bool,
    /// Whether the fitted result is annealed: faces are redistributed. Not without `fit`. See
    /// [`anneal`](crate::anneal()).
    pub anneal: bool,
    /// Whether the largest errors are reduced at the end. See [`reduce_max_error`](crate::reduce_max_error()).
    pub max_error: bool,
    /// Whether faces that chains of collapses or of other steps turned over against the input are turned back, by flips
    /// and moves. See [`unfold`](crate::unfold()).
    pub unfold: bool,
    /// Error norm that all refinement steps minimise. With [`FitNorm::L1`], the largest errors are reduced only while
    /// the root mean square does not rise. With [`FitNorm::Max`], there are more rounds, and the mean may rise.
    pub norm: FitNorm,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Settings for experts.
    pub tuning: Tuning,
}

/// Settings of the refinement for experts; [`RefineOptions`] overrides the norm, the seed and what is protected.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tuning {
    /// Settings of the fit.
    pub fit: FitOptions,
    /// Settings of the annealing.
    pub anneal: AnnealOptions,
    /// Settings of the reduction of the largest error.
    pub max_error: MaxErrorOptions,
}

/// How far the result may be from the input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ToleranceOptions {
    /// Largest allowed distance from the input, in model units, both ways. The result is the coarsest level of the
    /// sequence of collapses that was found within it after refinement, up to three percent of its vertices. Needs
    /// `check`.
    pub distance: Option<f64>,
    /// Whether and how the distance of the result is measured.
    pub check: Option<ErrorCheck>,
    /// Whether a level within `distance` is collapsed further, edge by edge, wherever the distance allows it. The
    /// result has far fewer faces than a refined level, and is not refined. Needs `distance`; not with attributes that
    /// count, nor with a target of vertices, cost, collapses or time.
    pub decimate: bool,
}

/// Values at the corners of the faces that should change as little as the shape.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AttributeOptions {
    /// The values; see [`AttributeDeviation`](crate::AttributeDeviation). This does not keep the seams between wedges:
    /// give them as features. Not with the curvature norms.
    pub corners: Option<CornerAttributes>,
    /// Their weight; 0 for none.
    pub weight: f64,
    /// The poses of a mesh that deforms: errors count in all of them, see [`Posed`](crate::Posed). Vertices are fitted in
    /// the pose of the input, and no further refinement is done. Not with the curvature norms.
    pub poses: Option<Poses>,
}

impl Default for AttributeOptions {
    fn default() -> Self {
        Self { corners: None, weight: 1.0, poses: None }
    }
}

impl AttributeOptions {
    /// The attributes, if they count.
    #[must_use]
    pub fn counting(&self) -> Option<&CornerAttributes> {
        self.corners.as_ref().filter(|_| self.weight > 0.0)
    }
}

/// A cost by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Metric {
    /// [`GarlandHeckbert`](crate::GarlandHeckbert) as published.
    Quadric,
    /// [`GarlandHeckbert`](crate::GarlandHeckbert), less the errors already made.
    IncrementalQuadric,
    /// [`Memoryless`](crate::Memoryless).
    Memoryless,
    /// [`Hybrid`](crate::Hybrid).
    Hybrid,
    /// [`CurvatureNorm`](crate::CurvatureNorm) with KKL02 eq. 1.
    CurvatureL1,
    /// [`CurvatureNorm`](crate::CurvatureNorm) with KKL02 eq. 2.
    CurvatureL2,
    /// The cost of the policies that [`simplify_with`](crate::simplify_with) is given; see [`Options::custom`].
    Custom,
}

impl Metric {
    /// Whether it is one of the curvature norms. They cannot be combined with the curvature factor or attribute costs.
    #[must_use]
    pub fn is_norm(self) -> bool {
        matches!(self, Self::CurvatureL1 | Self::CurvatureL2)
    }
}

/// A placement by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum PlacementRule {
    /// [`Optimal`](crate::Optimal) among the positions that keep the volume.
    OptimalVolume,
    /// [`Optimal`](crate::Optimal) among all positions.
    Optimal,
    /// [`BestEndpoint`](crate::BestEndpoint): the vertices are a subset of the original ones.
    Endpoint,
    /// [`Midpoint`](crate::Midpoint).
    Midpoint,
    /// [`ButterflyPoint`](crate::ButterflyPoint).
    Butterfly,
    /// [`LeastCost`](crate::LeastCost): the position that changes the curvature norm least, found by a search. Needs
    /// [`Metric::CurvatureL1`] or [`Metric::CurvatureL2`]. About fifty times as slow as
    /// [`PlacementRule::Butterfly`].
    CurvatureOptimal,
    /// The placement of the policies that [`simplify_with`](crate::simplify_with) is given; see [`Options::custom`].
    Custom,
}

impl PlacementRule {
    /// All placements that have a name: all but [`PlacementRule::Custom`].
    pub const NAMED: &'static [Self] = &[
        Self::OptimalVolume,
        Self::Optimal,
        Self::Endpoint,
        Self::Midpoint,
        Self::Butterfly,
        Self::CurvatureOptimal,
    ];

    /// The name, as [`FromStr`] takes it; `custom` for [`PlacementRule::Custom`].
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::OptimalVolume => "optimal-volume",
            Self::Optimal => "optimal",
            Self::Endpoint => "endpoint",
            Self::Midpoint => "midpoint",
            Self::Butterfly => "butterfly",
            Self::CurvatureOptimal => "curvature-optimal",
            Self::Custom => "custom",
        }
    }
}

/// A name that is no placement.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "there is no placement {0:?}; there are optimal-volume, optimal, endpoint, midpoint, butterfly, curvature-optimal"
)]
pub struct UnknownPlacement(pub String);

impl FromStr for PlacementRule {
    type Err = UnknownPlacement;

    fn from_str(name: &str) -> Result<Self, UnknownPlacement> {
        let found = Self::NAMED.iter().find(|placement| placement.name() == name);
        found.copied().ok_or_else(|| UnknownPlacement(name.to_owned()))
    }
}

/// The factor by which the mean may rise if only the largest distance counts.
const MAX_RISE: f64 = 1.5;
/// Rounds that reduce the largest distances in this case.
const ROUNDS_FOR_MAX: usize = 60;

impl RefineOptions {
    /// No refinement.
    #[must_use]
    pub fn none() -> Self {
        Self {
            fit: false,
            anneal: false,
            max_error: false,
            unfold: false,
            norm: FitNorm::L2,
            seed: 1,
            tuning: Tuning::default(),
        }
    }

    /// No refinement, but faces that are turned over are turned back.
    #[must_use]
    pub fn unfold_only() -> Self {
        Self { unfold: true, ..Self::none() }
    }

    /// Whether there is any refinement besides turning faces back.
    #[must_use]
    pub fn is_any(&self) -> bool {
        self.fit || self.max_error
    }

    /// The stages with all their settings, for a mesh that keeps what `protect` says and at least `min_faces` faces.
    #[must_use]
    pub fn steps(&self, protect: &Protect, min_faces: usize) -> Steps {
        let Self { norm, seed, tuning, .. } = *self;
        let fitted = |fit: FitOptions| FitOptions {
            seed,
            forbid_intersections: fit.forbid_intersections || protect.forbid_intersections,
            ..fit
        };
        let (fit, anneal, mut reduce) = (tuning.fit, tuning.anneal, tuning.max_error);
        match norm {
            FitNorm::L1 => reduce.max_rise = 1.0,
            FitNorm::Max => {
                reduce.max_rise = reduce.max_rise.max(MAX_RISE);
                reduce.fit.rounds = reduce.fit.rounds.max(ROUNDS_FOR_MAX);
            }
            _ => {}
        }
        Steps {
            fit: self.fit.then(|| fitted(FitOptions { norm, ..fit })),
            anneal: self.anneal.then(|| AnnealOptions {
                fit: fitted(FitOptions { norm, ..anneal.fit }),
                ..anneal
            }),
            max_error: self.max_error.then(|| MaxErrorOptions {
                min_faces: reduce.min_faces.max(min_faces),
                forbid_intersections: reduce.forbid_intersections || protect.forbid_intersections,
                min_component_vertices: protect.min_component_vertices,
                fit: FitOptions { seed: reduce.fit.seed, ..fitted(reduce.fit) },
                ..reduce
            }),
            unfold: self
                .unfold
                .then_some(UnfoldOptions { forbid_intersections: protect.forbid_intersections }),
            undo: false,
        }
    }
}

impl Options {
    /// These options for custom policies: [`simplify_with`](crate::simplify_with) takes cost and placement from
    /// the policies, and rejects options that name another cost or placement.
    #[must_use]
    pub fn custom(mut self) -> Self {
        self.cost = CostOptions { metric: Metric::Custom, curvature_weight: 0.0, ..self.cost };
        self.placement = PlacementRule::Custom;
        self
    }

    /// These options for a run whose stages become levels of detail: collapses are recorded, one metric is used from
    /// the start, and nothing is refined, because refinement would move the last stage away from the others.
    #[must_use]
    pub fn for_levels(mut self) -> Self {
        self.record = true;
        self.refine = RefineOptions::none();
        self.cost.switch_ratio = None;
        self
    }

    /// These options with a number of faces to stop at.
    #[must_use]
    pub fn to_faces(mut self, faces: usize) -> Self {
        self.target.faces = Some(faces);
        self
    }

    /// These options with a largest distance from the input, in model units, and how it is measured. Call it last:
    /// where vertices may be placed freely, or the largest errors are reduced ([`RefineOptions::max_error`]), and no
    /// other option excludes it, the result has as few faces as the distance allows ([`ToleranceOptions::decimate`]).
    #[must_use]
    pub fn within(mut self, distance: f64, check: ErrorCheck) -> Self {
        let is_free =
            matches!(self.placement, PlacementRule::Optimal | PlacementRule::OptimalVolume)
                && !self.cost.metric.is_norm();
        let decimate = (is_free || self.refine.max_error) && self.decimate_conflict().is_none();
        self.tolerance =
            ToleranceOptions { distance: Some(distance), check: Some(check), decimate };
        self
    }

    /// Whether the mean distance is what counts. With an error limit, or a norm for the largest distance, it is not.
    pub(crate) fn counts_mean(&self) -> bool {
        self.tolerance.distance.is_none() && self.refine.norm != FitNorm::Max
    }

    /// The option that excludes decimation to a tolerance: other targets would be passed, and attributes would be
    /// ignored.
    pub(crate) fn decimate_conflict(&self) -> Option<&'static str> {
        let Target { vertices, cost, collapses, time, .. } = self.target;
        let conflicts = [
            (vertices.is_some(), "target.vertices"),
            (cost.is_some(), "target.cost"),
            (collapses.is_some(), "target.collapses"),
            (time.is_some(), "target.time"),
            (self.attributes.counting().is_some(), "attributes.corners"),
            (self.attributes.poses.is_some(), "attributes.poses"),
        ];
        conflicts.into_iter().find_map(|(is_set, option)| is_set.then_some(option))
    }
}
