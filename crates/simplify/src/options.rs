//! What to simplify by, as data: the policies of this crate by name.

use crate::error::SimplifyError;
use crate::tolerance::measure::ErrorCheck;
use mesh_collapse::{
    ComponentConstraint, Constraints, IntersectionConstraint, NormalConstraint, Protect, Schedule,
    ShapeConstraint, Target,
};
use mesh_refine::{AnnealOptions, CornerAttributes, FitNorm, FitOptions, MaxErrorOptions};

/// How a mesh is simplified; see [`crate::simplify`].
///
/// In the order of what is done: edges collapse, as [`CollapseOptions`] say and with an eye on the
/// [`AttributeOptions`]; [`RefineOptions`] bring the result closer to the original; and
/// [`LimitOptions`] hold it to a distance. No option changes the meaning of another one; those that
/// exclude each other are an error.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Options {
    /// Which edges collapse, and when that ends.
    pub collapse: CollapseOptions,
    /// What is done with the mesh that is left.
    pub refine: RefineOptions,
    /// How far the result may be from the original.
    pub limit: LimitOptions,
    /// What should stay at the corners of the faces, besides the shape.
    pub attributes: AttributeOptions,
}

/// Which edges collapse, and when that ends.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CollapseOptions {
    /// What a collapse costs.
    pub metric: Metric,
    /// The weight of the curvature factor on top of the cost; 0 for none. See
    /// [`CurvatureFactor`](crate::CurvatureFactor). Not with the curvature norms.
    pub curvature_weight: f64,
    /// Where the remaining vertex goes.
    pub placement: PlacementRule,
    /// When costs are brought up to date.
    pub schedule: Schedule,
    /// With [`Schedule::Parallel`] and [`Metric::Hybrid`]: at how many times the wanted faces this metric
    /// takes over from accumulated quadrics, which are several times as quick. Where that is more than 60 % of
    /// all faces, it takes over at these, or from the beginning if they are less than 1.9 times the wanted faces.
    /// `None` for the metric from the beginning, on one core; at least 1 otherwise. Where only a largest error ends
    /// the collapses, and the level that it leaves is squeezed ([`LimitOptions::squeeze`]), it is that which takes
    /// over, with a metric of its own, unless the curvature weight is above 0.1.
    pub switch_ratio: Option<f64>,
    /// Whether every collapse is recorded; see [`Simplified::log`](crate::Simplified::log). Takes 60
    /// bytes for each.
    pub record: bool,
    /// When to stop.
    pub limits: Target,
    /// What must stay.
    pub protect: Protect,
    /// The smallest cosine between the normals of a face before and after a collapse; `None`
    /// allows all. See [`NormalConstraint`].
    pub min_cosine: Option<f64>,
    /// The shape below which faces must not get worse; `None` allows all. See [`ShapeConstraint`].
    pub min_shape: Option<f64>,
    /// How many vertices every component keeps, here and when the mesh is finished; `None` for as few
    /// as possible. See [`ComponentConstraint`].
    pub min_component_vertices: Option<usize>,
    /// Whether faces must not come to cross that did not before, here and when the mesh is finished.
    /// See [`IntersectionConstraint`].
    pub forbid_intersections: bool,
}

/// What is done with the mesh that the collapses leave.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RefineOptions {
    /// Whether and how the result is fitted to the original. See [`fit`](crate::fit()).
    pub fit: Option<FitOptions>,
    /// Whether and how the fitted result is annealed. See [`anneal`](crate::anneal()). Not without
    /// `fit`.
    pub anneal: Option<AnnealOptions>,
    /// Whether and how the largest errors are taken down in the end. See
    /// [`reduce_max_error`](crate::reduce_max_error()).
    pub max_error: Option<MaxErrorOptions>,
}

impl RefineOptions {
    /// The same, for another norm: fits and annealing make that small. The largest errors are taken down
    /// only as far as the root mean square does not rise with [`FitNorm::L1`], and whatever happens to the
    /// mean, in more rounds, with [`FitNorm::Max`].
    #[must_use]
    pub fn minimising(mut self, norm: FitNorm) -> Self {
        let fits = self.fit.iter_mut().chain(self.anneal.iter_mut().map(|anneal| &mut anneal.fit));
        fits.for_each(|fit| fit.norm = norm);
        if let Some(max_error) = &mut self.max_error {
            match norm {
                FitNorm::L1 => max_error.max_rise = 1.0,
                FitNorm::Max => {
                    max_error.max_rise = max_error.max_rise.max(MAX_RISE);
                    max_error.fit.rounds = max_error.fit.rounds.max(ROUNDS_FOR_MAX);
                }
                _ => {}
            }
        }
        self
    }
}

/// What the mean may rise by where the largest distance is all that counts.
const MAX_RISE: f64 = 1.5;
/// How many rounds the largest distances are fitted for then.
const ROUNDS_FOR_MAX: usize = 60;

/// How far the result may be from the original.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LimitOptions {
    /// The largest allowed distance from the original, in model units, both ways. The result is
    /// the coarsest one in the sequence of collapses, up to three percent of its vertices, that was
    /// found within it after it was finished. Needs `check`.
    pub distance: Option<f64>,
    /// Whether and how the distance of the result is found.
    pub check: Option<ErrorCheck>,
    /// Whether a level within `distance`, where that is what ends the collapses, is collapsed further,
    /// edge by edge, wherever that leaves it within. The result has far fewer faces than a finished
    /// level, most of them nearly as far from the original as they may be, and is not finished. Needs
    /// `distance`; not with attributes that count, nor with limits of vertices, cost, collapses or
    /// time.
    pub decimate: bool,
}

/// What should stay at the corners of the faces, besides the shape.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AttributeOptions {
    /// The values; see [`AttributeDeviation`](crate::AttributeDeviation). The seams between wedges are not kept by this: give
    /// them as features. Not with the curvature norms.
    pub corners: Option<CornerAttributes>,
    /// Their weight; 0 for none.
    pub weight: f64,
}

impl Default for AttributeOptions {
    fn default() -> Self {
        Self { corners: None, weight: 1.0 }
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
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

/// A placement by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
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

impl Metric {
    /// Whether it is one of the curvature norms, which nothing comes on top of.
    #[must_use]
    pub fn is_norm(self) -> bool {
        matches!(self, Self::CurvatureL1 | Self::CurvatureL2)
    }
}

impl CollapseOptions {
    /// The guards that the options name.
    #[must_use]
    pub fn constraints(&self) -> Constraints {
        let mut constraints = Constraints::default();
        if let Some(min_vertices) = self.min_component_vertices {
            constraints.push(ComponentConstraint::new(min_vertices));
        }
        if let Some(min_cosine) = self.min_cosine {
            constraints.push(NormalConstraint { min_cosine });
        }
        if let Some(min_shape) = self.min_shape {
            constraints.push(ShapeConstraint { min_shape });
        }
        // The most expensive check comes last.
        if self.forbid_intersections {
            constraints.push(IntersectionConstraint::default());
        }
        constraints
    }
}

impl Options {
    /// The same for a run whose stages become levels of detail: it is recorded, the metric that it ends
    /// with makes all of it, and nothing is finished, which would move the last stage away from the others.
    #[must_use]
    pub fn for_levels(mut self) -> Self {
        self.collapse.record = true;
        self.refine = RefineOptions::default();
        self.collapse.switch_ratio = None;
        self
    }

    /// The same with a number of faces to stop at.
    #[must_use]
    pub fn to_faces(mut self, faces: usize) -> Self {
        self.collapse.limits.faces = Some(faces);
        self
    }

    /// The same with a largest distance from the original, in model units, and how that is found. To be
    /// called last: where vertices may be placed freely, or the options take care of the largest errors
    /// ([`RefineOptions::peaks`]), and nothing in them speaks against it, as few faces are left as can be
    /// ([`LimitOptions::squeeze`]).
    #[must_use]
    pub fn within(mut self, distance: f64, check: ErrorCheck) -> Self {
        let CollapseOptions { metric, placement, .. } = self.collapse;
        let is_free = matches!(placement, PlacementRule::Optimal | PlacementRule::OptimalVolume)
            && !metric.is_norm();
        let decimate =
            (is_free || self.refine.max_error.is_some()) && self.squeeze_conflict().is_none();
        self.limit = LimitOptions { distance: Some(distance), check: Some(check), decimate };
        self
    }

    /// What a mesh cannot be squeezed with: what is left of other limits would not be known, and
    /// attributes would be passed over.
    fn squeeze_conflict(&self) -> Option<&'static str> {
        let Target { vertices, cost, collapses, time, .. } = self.collapse.limits;
        let conflicts = [
            (vertices.is_some(), "collapse.limits.vertices"),
            (cost.is_some(), "collapse.limits.cost"),
            (collapses.is_some(), "collapse.limits.collapses"),
            (time.is_some(), "collapse.limits.time"),
            (self.attributes.counting().is_some(), "attributes.corners"),
        ];
        conflicts.into_iter().find_map(|(is_set, option)| is_set.then_some(option))
    }

    /// Whether the options make sense, each by itself and all together.
    pub(crate) fn check(&self) -> Result<(), SimplifyError> {
        let Self { collapse, refine, limit, attributes } = self;
        let check = |option, value: Option<f64>, fits: fn(f64) -> bool, expected| match value {
            Some(value) if !fits(value) => Err(SimplifyError::Option { option, value, expected }),
            _ => Ok(()),
        };
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let share = |x: f64| (0.0..=1.0).contains(&x);
        let weight = |option, value: f64| {
            check(option, Some(value), |x| x >= 0.0 && x.is_finite(), "at least 0 and finite")
        };
        check("collapse.limits.ratio", collapse.limits.ratio, share, "between 0 and 1")?;
        check("collapse.limits.cost", collapse.limits.cost, |x| x >= 0.0, "at least 0")?;
        weight("collapse.curvature_weight", collapse.curvature_weight)?;
        let cosine = |x: f64| (-1.0..=1.0).contains(&x);
        check("collapse.min_cosine", collapse.min_cosine, cosine, "between -1 and 1")?;
        check("collapse.min_shape", collapse.min_shape, share, "between 0 and 1")?;
        let factor = |x: f64| x >= 1.0 && x.is_finite();
        check("collapse.switch_ratio", collapse.switch_ratio, factor, "at least 1 and finite")?;
        check("limit.distance", limit.distance, positive, "positive and finite")?;
        weight("attributes.weight", attributes.weight)?;
        refine.fit.as_ref().map_or(Ok(()), FitOptions::check)?;
        refine.anneal.as_ref().map_or(Ok(()), AnnealOptions::check)?;
        refine.max_error.as_ref().map_or(Ok(()), MaxErrorOptions::check)?;

        let norm = collapse.metric.is_norm().then_some("collapse.metric, a curvature norm");
        let decimate = limit.decimate.then_some("limit.decimate");
        let conflict =
            |option: Option<&'static str>, with: Option<&'static str>, cure| match (option, with) {
                (Some(option), Some(with)) => Err(SimplifyError::Conflict { option, with, cure }),
                _ => Ok(()),
            };
        let factor = (collapse.curvature_weight > 0.0).then_some("collapse.curvature_weight");
        conflict(factor, norm, "set it to 0")?;
        let corners = attributes.counting().map(|_| "attributes.corners");
        conflict(corners, norm, "take another metric, or none of the attributes")?;
        let no_fit = refine.fit.is_none().then_some("refine.fit = None");
        conflict(refine.anneal.map(|_| "refine.anneal"), no_fit, "fit as well, or do not anneal")?;
        let unchecked = limit.check.is_none().then_some("limit.check = None");
        let cure = "say how the distance is found: sampled or certified";
        conflict(limit.distance.map(|_| "limit.distance"), unchecked, cure)?;
        let unlimited = limit.distance.is_none().then_some("limit.distance = None");
        conflict(decimate, unlimited, "set a distance")?;
        conflict(decimate, self.squeeze_conflict(), "do without one of them")
    }
}
