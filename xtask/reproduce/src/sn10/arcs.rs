//! Fig. 4 and 5: the arcs of both osculating circles of a hyperbolic point, and the patch between.

use core::f64::consts::FRAC_PI_2;

use curvpatch::{FitTest, Params, Shape};
use glam::DVec3;
use mesh_shapes::{AnalyticSurface, Diagonals, Saddle};

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::drawing::{BLUE, BLUE_LINE, DARK, Drawing, RED_LINE, arc};
use super::patches::{STYLE, axes_of_paper, estimator, face_at, patch};
use xtask_common::Failure;

const SADDLE: Saddle = Saddle { coefficient: 0.5, half_width: 1.0 };
const RADIUS: f64 = 0.5;
const TOWARD: DVec3 = DVec3::new(0.45, -1.0, 0.75);

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "At a hyperbolic point both principal arcs have length r_g to either side and bend to \
         opposite sides of the tangent plane. The patch is spanned by them: its third coordinate \
         is the mean of theirs with the weights cos² and sin² of the angle. One formula with \
         limits for zero curvature serves all signs.",
    );
    item.how(
        &["curvpatch::CurvatureEstimator::patch", "curvpatch::Patch::point"],
        &["curvmesh patch IN -o OUT.glb --face 1055 --radius 0.5 --shape circle --preset paper"],
    );
    let mesh = mesh_of(&SADDLE.mesh(32, Diagonals::Alternating).map_err(Failure::mesh)?)?;
    let face = face_at(&mesh, DVec3::ZERO, DVec3::Z);
    let estimator = estimator(&mesh, Params::paper())?;
    let fit = patch(&estimator, face, RADIUS, Shape::Circle)?;
    let exact = SADDLE.principal_curvatures(fit.curvature.center);
    let axes = axes_of_paper(fit.curvature.curvatures);
    let [k1, k2] = axes.map(|axis| fit.curvature.curvatures[axis]);
    let scale = exact.max.max(-exact.min);
    let error = (k1.max(k2) - exact.max).abs().max((k1.min(k2) - exact.min).abs()) / scale;
    item.number("error of the principal curvatures (%)", 100.0 * error);
    item.number("alpha = r_g / rho 1 (rad)", RADIUS * k1.abs());
    item.number("beta = r_g / rho 2 (rad)", RADIUS * k2.abs());
    let errors = FitTest::new(&mesh).full_error(&fit, RADIUS, false);
    item.number("largest distance of patch and mesh (% of r_g)", 100.0 * errors.max() / RADIUS);
    beta_claim(item);

    let view = view_of(&mesh, TOWARD, DVec3::Z)?;
    let lift = 1.5 * errors.max();
    let up = lift * fit.patch.frame()[2];
    let mut arcs = Drawing::of(&mesh, &[], BLUE);
    for (axis, color) in axes.into_iter().zip([RED_LINE, BLUE_LINE]) {
        let phi = FRAC_PI_2 * axis as f64;
        arcs.line(arc(&fit.patch, phi).map(|p| p + up).collect(), color, 5.0);
    }
    arcs.dot(fit.patch.center() + up, 0.022, TOWARD, DARK);
    let mut whole = Drawing::of(&mesh, &[], BLUE);
    whole.patch(&fit.patch, BLUE, lift, 4.0)?;
    item.side_by_side([
        arcs.draw(
            run,
            &view,
            &STYLE,
            "sn10-arcs",
            "Fig. 4: the arcs of the two osculating circles",
        )?,
        whole.draw(
            run,
            &view,
            &STYLE,
            "sn10-boundary",
            "Fig. 5: the patch and its boundary curve",
        )?,
    ]);
    Ok(())
}

/// Values of kappa 2 that tend to 0, beside kappa 1 = 1.
const VANISHING: [f64; 4] = [1e-1, 1e-2, 1e-4, 1e-6];

/// The limit of beta as kappa 2 vanishes, by the printed formula.
fn beta_claim(item: &mut Item) {
    let betas =
        VANISHING.map(|curvature| curvature * Shape::Ellipse.arcs([1.0, curvature], RADIUS)[1]);
    let [.., last] = betas;
    item.number("beta of an ellipse, for kappa 2 = 1e-6 and r_g = 0.5 (rad)", last);
    item.claim(
        "beta tends to pi/2",
        tends_to(betas, FRAC_PI_2),
        format!(
            "with the printed formula beta = min(alpha, 2.5 r_g / rho 2), beta is {} for kappa 2 = 0.1, \
             0.01, 1e-4 and 1e-6: it tends to 0, and its arc to 2.5 r_g",
            betas.map(|beta| format!("{beta:.1e}")).join(", ")
        ),
    );
}

/// Whether a sequence comes nearer to a limit with every step and in the end reaches it.
fn tends_to(values: [f64; 4], limit: f64) -> Outcome {
    let gaps = values.map(|value| (value - limit).abs());
    match (gaps.is_sorted_by(|a, b| a > b), gaps[3] < 1e-3 * limit) {
        (_, true) => Outcome::Holds,
        (true, false) => Outcome::InPart,
        (false, false) => Outcome::Fails,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beta_that_reaches_the_limit_turns_the_verdict() {
        assert_eq!(tends_to([0.1, 0.01, 1e-4, 1e-6], FRAC_PI_2), Outcome::Fails);
        assert_eq!(tends_to(VANISHING.map(|k| FRAC_PI_2 - k), FRAC_PI_2), Outcome::Holds);
        assert_eq!(tends_to([1.0, 1.1, 1.2, 1.3], FRAC_PI_2), Outcome::InPart);
    }
}
