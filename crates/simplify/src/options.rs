//! What to simplify by, as data: the policies of this crate by name.

use crate::attributes::wedges::CornerAttributes;
use crate::collapse::constraint::Constraints;
use crate::collapse::policies::Update;
use crate::collapse::stop::Limits;
use crate::error::SimplifyError;
use crate::finish::anneal::AnnealOptions;
use crate::finish::fit::FitOptions;
use crate::finish::peaks::PeakOptions;
use crate::limit::measure::ErrorCheck;

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

impl Options {
    /// The same with a number of faces to stop at.
    #[must_use]
    pub fn to_faces(mut self, faces: usize) -> Self {
        self.limits.faces = Some(faces);
        self
    }

    /// Whether the options make sense.
    pub(crate) fn check(&self) -> Result<(), SimplifyError> {
        let check = |option, value: Option<f64>, fits: fn(f64) -> bool, expected| match value {
            Some(value) if !fits(value) => Err(SimplifyError::Option { option, value, expected }),
            _ => Ok(()),
        };
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let not_negative = |x: f64| x >= 0.0 && x.is_finite();
        check("ratio", self.limits.ratio, |x| (0.0..=1.0).contains(&x), "between 0 and 1")?;
        check("cost limit", self.limits.cost, |x| x >= 0.0, "a number that is not negative")?;
        check("max_error", self.max_error, positive, "positive and finite")?;
        check(
            "curvature_weight",
            Some(self.curvature_weight),
            not_negative,
            "at least 0 and finite",
        )?;
        check(
            "attribute_weight",
            Some(self.attribute_weight),
            not_negative,
            "at least 0 and finite",
        )?;
        check("min_cosine", self.min_cosine, |x| (-1.0..=1.0).contains(&x), "between -1 and 1")?;
        check("min_shape", self.min_shape, |x| (0.0..=1.0).contains(&x), "between 0 and 1")?;
        self.fit.as_ref().map_or(Ok(()), FitOptions::check)?;
        self.anneal.as_ref().map_or(Ok(()), AnnealOptions::check)?;
        self.peaks.as_ref().map_or(Ok(()), PeakOptions::check)
    }
}
