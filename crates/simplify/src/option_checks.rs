//! Options that are out of range or exclude each other.

use mesh_collapse::FaceLimits;
use mesh_core::TriMesh;

use crate::error::SimplifyError;
use crate::options::{Metric, Options, PlacementRule};

/// An error if the mesh cannot be simplified by these options.
pub(crate) fn check(mesh: &TriMesh, options: &Options) -> Result<(), SimplifyError> {
    options.check()?;
    let mut used = mesh.topology().vertices().map(|v| (v, mesh.position(v)));
    if let Some((vertex, position)) = used.find(|(_, position)| !position.is_finite()) {
        return Err(SimplifyError::NotFinite { vertex, position });
    }
    let importance = options.protect.importance.as_ref();
    let mut known = importance.into_iter().flat_map(|map| map.live(mesh.topology()));
    match known.find(|(_, importance)| !(**importance >= 0.0 && importance.is_finite())) {
        Some((vertex, &importance)) => Err(SimplifyError::Importance { vertex, importance }),
        None => Ok(()),
    }
}

impl Options {
    /// An error if an option is out of range or two options exclude each other.
    pub(crate) fn check(&self) -> Result<(), SimplifyError> {
        self.check_ranges()?;
        let Self { cost, refine, tolerance, attributes, .. } = self;
        let conflict =
            |option: Option<&'static str>, with: Option<&'static str>, cure| match (option, with) {
                (Some(option), Some(with)) => Err(SimplifyError::Conflict { option, with, cure }),
                _ => Ok(()),
            };
        let norm = cost.metric.is_norm().then_some("cost.metric, a curvature norm");
        let decimate = tolerance.decimate.then_some("tolerance.decimate");
        let factor = (cost.curvature_weight > 0.0).then_some("cost.curvature_weight");
        conflict(factor, norm, "set it to 0")?;
        let by_norm = (self.placement == PlacementRule::CurvatureOptimal)
            .then_some("placement = CurvatureOptimal");
        let no_norm = (!cost.metric.is_norm()).then_some("cost.metric, which is no curvature norm");
        conflict(
            by_norm,
            no_norm,
            "choose a curvature norm (presets paper-l1, paper-l2), or another placement",
        )?;
        let corners = attributes.counting().map(|_| "attributes.corners");
        conflict(corners, norm, "choose another metric, or no attributes")?;
        let poses = attributes.poses.as_ref().map(|_| "attributes.poses");
        conflict(poses, norm, "choose another metric, or no poses")?;
        let custom = (cost.metric == Metric::Custom).then_some("a custom cost");
        conflict(poses, custom, "name a metric, or wrap the cost in Posed")?;
        let no_fit = (!refine.fit).then_some("refine.fit = false");
        conflict(
            refine.anneal.then_some("refine.anneal"),
            no_fit,
            "fit as well, or do not anneal",
        )?;
        let unchecked = tolerance.check.is_none().then_some("tolerance.check = None");
        let cure = "say how the distance is measured: sampled or certified";
        conflict(tolerance.distance.map(|_| "tolerance.distance"), unchecked, cure)?;
        let unlimited = tolerance.distance.is_none().then_some("tolerance.distance = None");
        conflict(decimate, unlimited, "set a distance")?;
        conflict(decimate, self.decimate_conflict(), "remove one of them")
    }

    fn check_ranges(&self) -> Result<(), SimplifyError> {
        let Self { target, cost, protect, refine, tolerance, attributes, .. } = self;
        let check = |option, value: Option<f64>, fits: fn(f64) -> bool, expected| match value {
            Some(value) if !fits(value) => Err(SimplifyError::Option { option, value, expected }),
            _ => Ok(()),
        };
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let share = |x: f64| (0.0..=1.0).contains(&x);
        let weight = |option, value: f64| {
            check(option, Some(value), |x| x >= 0.0 && x.is_finite(), "at least 0 and finite")
        };
        check("target.ratio", target.ratio, share, "between 0 and 1")?;
        check("target.cost", target.cost, |x| x >= 0.0, "at least 0")?;
        weight("cost.curvature_weight", cost.curvature_weight)?;
        let cosine = |x: f64| (-1.0..=1.0).contains(&x);
        check("protect.min_cosine", protect.min_cosine, cosine, "between -1 and 1")?;
        check("protect.min_shape", protect.min_shape, share, "between 0 and 1")?;
        let FaceLimits { max_edge, min_angle, max_valence } = protect.limits;
        check("protect.limits.max_edge", max_edge, positive, "positive and finite")?;
        // 60 degrees in radians are rounded.
        let angle = |x: f64| x > 0.0 && x < core::f64::consts::FRAC_PI_3 - 1e-9;
        let expected = "above 0 and below 60 degrees (pi / 3)";
        check("protect.limits.min_angle", min_angle, angle, expected)?;
        let valence = max_valence.map(|count| count as f64);
        check("protect.limits.max_valence", valence, |x| x >= 3.0, "at least 3")?;
        let factor = |x: f64| x >= 1.0 && x.is_finite();
        check("cost.switch_ratio", cost.switch_ratio, factor, "at least 1 and finite")?;
        check("tolerance.distance", tolerance.distance, positive, "positive and finite")?;
        weight("attributes.weight", attributes.weight)?;
        refine.tuning.fit.check()?;
        refine.tuning.anneal.check()?;
        Ok(refine.tuning.max_error.check()?)
    }
}
