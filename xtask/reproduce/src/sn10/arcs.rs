//! Fig. 4 and 5: the arcs of both osculating circles of a hyperbolic point, and the patch between.

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
        let phi = core::f64::consts::FRAC_PI_2 * axis as f64;
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

/// The paper lets beta go to pi/2 as kappa 2 vanishes; its formula does not.
fn beta_claim(item: &mut Item) {
    let curvature = 1e-6;
    let [_, arc] = Shape::Ellipse.arcs([1.0, curvature], 0.5);
    let beta = arc * curvature;
    item.number("beta of an ellipse, for kappa 2 = 1e-6 and r_g = 0.5 (rad)", beta);
    item.claim(
        "beta tends to pi/2",
        Outcome::Fails,
        format!(
            "with the printed formula beta = min(alpha, 2.5 r_g / rho 2) it tends to 0 ({beta:.2e} \
             for kappa 2 = 1e-6), and its arc to 2.5 r_g, which is what is meant"
        ),
    );
}
