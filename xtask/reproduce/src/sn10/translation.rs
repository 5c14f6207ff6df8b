//! Fig. 6: patches of elliptic points are moved along their normal onto the mesh.

use curvpatch::{Params, Patch, PatchFit, Shape};
use glam::DVec3;
use mesh_core::TriMesh;
use mesh_shapes::{SignedDistance, Sphere, Torus};

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of};
use super::drawing::arc;
use super::patches::{estimator, patch};
use super::statistics::{median, percent};
use xtask_common::Failure;
use xtask_common::plot::{Axis, Plot, Series};

const RADIUS: f64 = 0.2;

pub(super) fn compute(_: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "The patch touches its face at the barycentre, which lies below the surface that the \
         vertices are on: seen from outside of a convex mesh, the patch is too deep. It is moved \
         along its normal by the mean height of the three vertices over it. The numbers are medians \
         over a mesh with r_g = 0.2: the distance of the patch's centre from the true surface, \
         before and after. The paper moves patches of elliptic points only; on a torus, where a \
         third of the points are hyperbolic, that leaves the centre of those where it was. The \
         robust preset always moves them.",
    );
    item.how(&["curvpatch::CurvatureEstimator::patch", "curvpatch::Patch::translated"], &[]);
    let sphere = mesh_of(&Sphere::UNIT.icosphere(3).map_err(Failure::mesh)?)?;
    let torus = Torus { major: 2.0, minor: 1.0 };
    let donut = mesh_of(&torus.mesh(64, 32).map_err(Failure::mesh)?)?;
    let [before, after] =
        center_errors(&sphere, Params::paper(), |p| Sphere::UNIT.signed_distance(p))?;
    item.number("sphere, centre off before (% of r_g)", before);
    item.number("sphere, centre off after (% of r_g)", after);
    item.claim(
        "translation onto the mesh",
        Outcome::of(after < 0.1 * before),
        format!("on a sphere the centre is {before:.2} % of r_g off before and {after:.3} % after"),
    );
    for (name, params) in super::patches::PRESETS {
        let [before, after] = center_errors(&donut, params, |p| torus.signed_distance(p))?;
        item.number(format!("torus, {name} preset, centre off before (% of r_g)"), before);
        item.number(format!("torus, {name} preset, centre off after (% of r_g)"), after);
    }
    profile(item)
}

/// Medians of the distance of patch centres from the surface, without and with the translation, in
/// percent of the radius.
fn center_errors(
    mesh: &TriMesh,
    params: Params,
    distance: impl Fn(DVec3) -> f64,
) -> Result<[f64; 2], Failure> {
    let estimator = estimator(mesh, params)?;
    let mut errors = [Vec::new(), Vec::new()];
    for face in mesh.topology().faces().step_by(mesh.topology().face_count() / 100) {
        let fit = patch(&estimator, face, RADIUS, Shape::Circle)?;
        let moved = fit.patch;
        for (errors, patch) in errors.iter_mut().zip([untranslated(&fit), moved]) {
            errors.push(percent(distance(patch.center()).abs(), RADIUS));
        }
    }
    Ok(errors.map(median))
}

fn untranslated(fit: &PatchFit) -> Patch {
    fit.patch.translated(0.0)
}

/// A cut through a coarse sphere along the first principal direction of a patch.
fn profile(item: &mut Item) -> Result<(), Failure> {
    let mesh = mesh_of(&Sphere::UNIT.icosphere(2).map_err(Failure::mesh)?)?;
    let estimator = estimator(&mesh, Params::paper())?;
    let face = super::patches::face_at(&mesh, DVec3::new(0.3, 0.2, 1.0), DVec3::Z);
    let fit = patch(&estimator, face, 0.5, Shape::Circle)?;
    let flat = |points: &mut dyn Iterator<Item = DVec3>| -> Vec<[f64; 2]> {
        points.map(|p| fit.patch.to_local(p)).map(|p| [p.x, p.z]).collect()
    };
    let section = estimator.trace(face, &fit.curvature, 0.0);
    let series = [
        ("mesh", flat(&mut section.points.into_iter())),
        ("patch before", flat(&mut arc(&untranslated(&fit), 0.0).step_by(6))),
        ("patch after", flat(&mut arc(&fit.patch, 0.0).step_by(6))),
    ];
    let plot = Plot {
        x: Axis::linear("along T1, radius of the sphere = 1"),
        y: Axis::linear("height over the face"),
        series: series.map(|(name, points)| Series::new(name, points)).into(),
    };
    item.plot(
        &plot,
        "A cut through a coarse sphere with a patch of r_g = 0.5 (heights exaggerated).",
    );
    Ok(())
}
