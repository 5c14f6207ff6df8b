//! Fig. 11 and 12: the regions that circular and elliptical patches cover on a saddle and a torus.

use curvpatch::{CurvatureEstimator, FitTest, Params, Shape};
use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_shapes::{Diagonals, Saddle, Torus};

use super::super::item::{Figure, Item};
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::drawing::{BLUE, Drawing, GREEN, ORANGE};
use super::patches::{STYLE, axes_of_paper, estimator, face_at, patch};
use xtask_common::Failure;

/// A surface with the places where patches are put.
struct Case {
    name: &'static str,
    figure: &'static str,
    mesh: TriMesh,
    radius: f64,
    toward: DVec3,
    up: DVec3,
    /// Name, and a point and a side that tell the face.
    places: Vec<(&'static str, DVec3, DVec3)>,
}

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Circular and elliptical patches of the same r_g at the same faces. A region is the faces \
         with all vertices under the patch (drawn darker); its area is given over pi r_g². An \
         ellipse is longer along the direction of smaller curvature, by |kappa 1 / kappa 2| up to \
         2.5, so at the symmetric centre of the saddle both shapes are nearly the same, and on top \
         of the torus, where kappa 2 vanishes, the ellipse reaches its limit. The paper shows \
         pictures and prints no areas.",
    );
    item.how(
        &["curvpatch::Shape", "curvpatch::FitTest::faces_under", "curvpatch::FitTest::full_error"],
        &["curvmesh patch IN -o OUT.glb --face N --radius R --shape ellipse"],
    );
    let mut lines = Vec::new();
    let mut areas: [Vec<f64>; 2] = Default::default();
    for case in cases()? {
        let estimator = estimator(&case.mesh, Params::robust())?;
        let shapes = [(Shape::Circle, "circles"), (Shape::Ellipse, "ellipses")];
        let mut figures = Vec::new();
        for ((shape, name), areas) in shapes.into_iter().zip(&mut areas) {
            let mut drawn = figure(run, item, &case, &estimator, shape, name)?;
            lines.append(&mut drawn.lines);
            areas.append(&mut drawn.areas);
            figures.push(drawn.figure);
        }
        item.side_by_side(figures);
    }
    let [circles, ellipses] = &areas;
    let gains: Vec<String> = circles
        .iter()
        .zip(ellipses)
        .map(|(circle, ellipse)| format!("{:.2}", ellipse / circle))
        .collect();
    item.claim(
        "ellipses cover more",
        covers_more(circles, ellipses),
        format!(
            "the area under the ellipse over that under the circle of the same r_g is {} at the six places; it is \
             about 1 at the centre of the saddle, where both curvatures have one size",
            gains.join(", ")
        ),
    );
    item.table(
        "Areas over pi r_g², errors in percent of r_g",
        ["place", "patches", "kappa 1", "kappa 2", "arc 2 / r_g", "faces", "area", "error"],
        lines,
    );
    Ok(())
}

fn cases() -> Result<[Case; 2], Failure> {
    let saddle = Saddle { coefficient: 0.5, half_width: 1.0 };
    let torus = Torus { major: 2.0, minor: 1.0 };
    Ok([
        Case {
            name: "saddle",
            figure: "Fig. 11",
            mesh: mesh_of(&saddle.mesh(40, Diagonals::Alternating).map_err(Failure::mesh)?)?,
            radius: 0.3,
            toward: DVec3::new(0.4, -0.9, 1.0),
            up: DVec3::Z,
            places: vec![
                ("centre", DVec3::ZERO, DVec3::Z),
                ("slope", DVec3::new(-0.55, -0.5, 0.0), DVec3::Z),
                ("crest", DVec3::new(0.62, 0.0, 0.19), DVec3::Z),
            ],
        },
        Case {
            name: "torus",
            figure: "Fig. 12",
            mesh: mesh_of(&torus.mesh(72, 36).map_err(Failure::mesh)?)?,
            radius: 0.35,
            toward: DVec3::new(0.0, -1.0, 1.1),
            up: DVec3::Z,
            places: vec![
                ("outside", DVec3::new(-0.9, -2.75, 0.25), DVec3::NEG_Y),
                ("top", DVec3::new(1.45, -1.4, 1.0), DVec3::Z),
                ("inside", DVec3::new(0.1, 1.1, 0.35), DVec3::NEG_Y),
            ],
        },
    ])
}

/// The patches of one shape on one surface.
struct Drawn {
    figure: Figure,
    lines: Vec<Vec<String>>,
    /// Covered areas over pi `r_g²`, place by place.
    areas: Vec<f64>,
}

/// The mesh tells areas apart by whole faces, so a share this small is no difference.
const GRAIN: f64 = 0.1;

/// Whether ellipses cover at least as much as circles everywhere, and more somewhere.
fn covers_more(circles: &[f64], ellipses: &[f64]) -> Outcome {
    let ratio = || circles.iter().zip(ellipses).map(|(circle, ellipse)| ellipse / circle);
    match (ratio().all(|r| r > 1.0 - GRAIN), ratio().any(|r| r > 1.0 + GRAIN)) {
        (true, true) => Outcome::Holds,
        (false, true) => Outcome::InPart,
        (_, false) => Outcome::Fails,
    }
}

/// Draws the patches of a shape and measures what they cover.
fn figure(
    run: &Run<'_>,
    item: &mut Item,
    case: &Case,
    estimator: &CurvatureEstimator<'_>,
    shape: Shape,
    shape_name: &str,
) -> Result<Drawn, Failure> {
    let Case { name, mesh, radius, .. } = case;
    let mut probe = FitTest::new(mesh);
    let mut fits = Vec::new();
    let mut covered: Vec<FaceId> = Vec::new();
    let mut lines = Vec::new();
    let mut areas = Vec::new();
    for (place, point, side) in &case.places {
        let fit = patch(estimator, face_at(mesh, *point, *side), *radius, shape)?;
        let faces = probe.faces_under(&fit);
        let area: f64 = faces.iter().map(|&face| mesh.face_area(face)).sum();
        let share = area / (core::f64::consts::PI * radius * radius);
        let error = 100.0 * probe.full_error(&fit, *radius, false).max() / radius;
        areas.push(share);
        let what = format!("{name}, {place}, {shape_name}");
        item.number(format!("{what}, area over pi r_g²"), share);
        item.number(format!("{what}, error (% of r_g)"), error);
        let axes = axes_of_paper(fit.curvature.curvatures);
        let [k1, k2] = axes.map(|axis| fit.curvature.curvatures[axis]);
        lines.push(vec![
            format!("{name}, {place}"),
            shape_name.to_owned(),
            format!("{k1:.3}"),
            format!("{k2:.3}"),
            format!("{:.2}", fit.patch.arcs()[axes[1]] / radius),
            faces.len().to_string(),
            format!("{share:.2}"),
            format!("{error:.2}"),
        ]);
        covered.extend(faces);
        fits.push(fit);
    }
    let mut drawing = Drawing::of(mesh, &covered, [120, 120, 118]);
    for (fit, color) in fits.iter().zip([BLUE, ORANGE, GREEN]) {
        let error = probe.full_error(fit, *radius, false).max();
        drawing.patch(&fit.patch, color, error.max(0.04 * radius), 3.0)?;
    }
    let view = view_of(mesh, case.toward, case.up)?;
    let caption = format!("{}: {shape_name} of r_g = {radius} on the {name}", case.figure);
    let figure =
        drawing.draw(run, &view, &STYLE, &format!("sn10-{name}-{shape_name}"), &caption)?;
    Ok(Drawn { figure, lines, areas })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smaller_ellipses_turn_the_verdict() {
        assert_eq!(covers_more(&[1.0, 1.0], &[1.0, 2.0]), Outcome::Holds);
        assert_eq!(covers_more(&[1.0, 1.0], &[0.5, 2.0]), Outcome::InPart);
        assert_eq!(covers_more(&[1.0, 1.0], &[1.0, 0.9]), Outcome::Fails);
    }
}
