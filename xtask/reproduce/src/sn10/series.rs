//! Fig. 8: patches in a row on a dense cylinder.

use curvpatch::{FitTest, Params, Shape, StripOptions};
use glam::DVec3;
use mesh_shapes::{Cylinder, RowPhase};

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::drawing::{BLUE, Drawing, GREEN, ORANGE};
use super::patches::{STYLE, estimator, face_at};
use mesh_render::Style;
use xtask_common::Failure;

const CYLINDER: Cylinder = Cylinder { radius: 1.0, height: 4.0 };
const RADIUS: f64 = 0.3;
/// Of the facets, not of the circle round them.
const PERIMETER: f64 = 6.2787;
const TALL: Style = Style { size: [520, 760], ..STYLE };
const TOWARD: DVec3 = DVec3::new(1.0, 0.35, 0.3);

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Centres at equal distances along one normal section, each with its own curvature and \
         frame: circles round the cylinder, and ellipses along it.",
    );
    item.how(
        &["curvpatch::CurvatureEstimator::strip"],
        &["curvmesh patch IN -o OUT.ply --tolerance 0.01 --relative"],
    );
    let mesh = mesh_of(&CYLINDER.mesh(32, 48, RowPhase::Staggered).map_err(Failure::mesh)?)?;
    let estimator = estimator(&mesh, Params::robust())?;
    let view = view_of(&mesh, TOWARD, DVec3::Z)?;
    let mut probe = FitTest::new(&mesh);
    let rows = [
        ("round", DVec3::new(0.94, 0.33, 2.0), DVec3::Y, Shape::Circle, PERIMETER / 12.0, 12),
        ("along", DVec3::new(0.94, 0.33, 0.8), DVec3::Z, Shape::Ellipse, 1.2, 3),
    ];
    let mut figures = Vec::new();
    let mut worst = 0.0_f64;
    for (name, start, direction, shape, spacing, max_patches) in rows {
        let face = face_at(&mesh, start, TOWARD);
        let options = StripOptions { shape, spacing, max_patches, ..StripOptions::new(RADIUS) };
        let strip = estimator.strip(face, direction, &options).map_err(Failure::mesh)?;
        let errors = strip.patches.iter().map(|fit| probe.full_error(fit, RADIUS, true).max());
        let largest = 100.0 * errors.fold(0.0, f64::max) / RADIUS;
        item.number(format!("{name} the cylinder, patches"), strip.patches.len() as f64);
        item.number(format!("{name} the cylinder, largest error (% of r_g)"), largest);
        worst = worst.max(largest);
        let mut drawing = Drawing::of(&mesh, &[], BLUE);
        // Lifted by turns, so that neighbours do not run through each other.
        let looks = [(BLUE, 0.015), (ORANGE, 0.03), (GREEN, 0.045)];
        for (fit, (color, lift)) in strip.patches.iter().zip(looks.into_iter().cycle()) {
            drawing.patch(&fit.patch, color, lift, 2.5)?;
        }
        let caption = format!("Fig. 8: {} patches {name} the cylinder", strip.patches.len());
        figures.push(drawing.draw(run, &view, &TALL, &format!("sn10-series-{name}"), &caption)?);
    }
    item.claim(
        "a series replaces a part of the mesh",
        Outcome::of(worst < 5.0),
        format!("both rows stay within {worst:.1} % of r_g of the mesh"),
    );
    item.side_by_side(figures);
    Ok(())
}
