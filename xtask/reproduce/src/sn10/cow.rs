//! Fig. 13, a large elliptical patch on the cow, and what the paper leaves to the reader: covers of
//! whole meshes.

use curvpatch::{Cover, CoverOptions, FitTest, Params, PatchSizer, Shape, SizeOptions, SizedPatch};
use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_shapes::{Ellipsoid, Irregular, Torus};

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::drawing::{Drawing, ORANGE, cover, patches};
use super::patches::{STYLE, axes_of_paper, estimator};
use mesh_render::Style;
use xtask_common::Failure;

const MODEL: &str = "cow.obj";
/// Patches may be this far from the mesh, as a share of the diagonal of its bounding box.
const TOLERANCE: f64 = 0.01;
const FROM_SIDE: DVec3 = DVec3::new(0.35, 0.25, 1.0);

pub(super) fn figure(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "The largest elliptical patch within 1 % of the diagonal of the bounding box, among those of \
         every fourth face that look to the camera. The paper shows one patch of a size chosen by \
         hand, and no numbers.",
    );
    item.stand_in(
        "An irregular ellipsoid, which is generated; with models, a cow like the paper's.",
    );
    item.how(
        &["curvpatch::PatchSizer::fit"],
        &["curvmesh patch cow.obj -o OUT.glb --face N --tolerance 0.01 --relative --shape ellipse --lenient"],
    );
    let shape = Ellipsoid { semi_axes: DVec3::new(2.2, 1.1, 0.9) };
    let irregular = Irregular { jitter: 0.2, seed: 3 };
    let ellipsoid = mesh_of(&shape.irregular_icosphere(4, irregular).map_err(Failure::mesh)?)?;
    let mut figures = vec![largest(run, item, &ellipsoid, "ellipsoid")?];
    if let Some(cow) = run.model(item, MODEL)? {
        figures.push(largest(run, item, &cow, "cow")?);
        sizes(item, &cow)?;
    }
    item.side_by_side(figures);
    Ok(())
}

fn diagonal(mesh: &TriMesh) -> f64 {
    mesh.bounding_box().map_or(0.0, |bounds| bounds.diagonal())
}

/// Finds and draws the elliptical patch that covers most.
fn largest(
    run: &Run<'_>,
    item: &mut Item,
    mesh: &TriMesh,
    name: &str,
) -> Result<super::super::item::Figure, Failure> {
    let diagonal = diagonal(mesh);
    let estimator = estimator(mesh, Params::robust())?;
    let options = SizeOptions::new(TOLERANCE * diagonal);
    let mut sizer = PatchSizer::new(&estimator, options).map_err(Failure::mesh)?;
    let seeds = mesh.topology().faces().step_by(4);
    let to_camera = |f: &FaceId| mesh.face_normal(*f).dot(FROM_SIDE.normalize()) > 0.7;
    let area = |sized: &SizedPatch| sized.faces.iter().map(|&f| mesh.face_area(f)).sum::<f64>();
    let fits = seeds.filter(to_camera).filter_map(|face| sizer.fit(face, Shape::Ellipse).ok());
    let best = fits
        .max_by(|a, b| area(a).total_cmp(&area(b)))
        .ok_or(Failure::Usage(format!("no patch fits the {name}")))?;
    let axes = axes_of_paper(best.fit.patch.curvatures());
    let [l1, l2] = axes.map(|axis| best.fit.patch.arcs()[axis]);
    let error = FitTest::new(mesh).full_error(&best.fit, options.tolerance, false).max();
    item.number(format!("{name}, r_g (% of the diagonal)"), 100.0 * l1 / diagonal);
    item.number(format!("{name}, second arc (% of the diagonal)"), 100.0 * l2 / diagonal);
    item.number(format!("{name}, faces under the patch"), best.faces.len() as f64);
    item.number(format!("{name}, error (% of the diagonal)"), 100.0 * error / diagonal);
    let mut drawing = Drawing::of(mesh, &best.faces, [120, 120, 118]);
    drawing.patch(&best.fit.patch, ORANGE, 1.2 * error, 3.0)?;
    let view = view_of(mesh, FROM_SIDE, DVec3::Y)?;
    let caption = format!(
        "Fig. 13: an elliptical patch on the {name} that stands for {} faces",
        best.faces.len()
    );
    drawing.draw(run, &view, &WIDE, &format!("sn10-large-patch-{name}"), &caption)
}

const WIDE: Style = Style { size: [1000, 700], ..STYLE };

/// How much the sizes of patches within one tolerance vary.
fn sizes(item: &mut Item, mesh: &TriMesh) -> Result<(), Failure> {
    let diagonal = diagonal(mesh);
    let estimator = estimator(mesh, Params::robust())?;
    let options = SizeOptions::new(TOLERANCE * diagonal);
    let mut sizer = PatchSizer::new(&estimator, options).map_err(Failure::mesh)?;
    let seeds = mesh.topology().faces().step_by(20);
    let fits = seeds.filter_map(|face| sizer.fit(face, Shape::Circle).ok());
    let mut radii: Vec<f64> = fits.map(|s| 100.0 * s.fit.curvature.radius / diagonal).collect();
    radii.sort_by(f64::total_cmp);
    let at = |share: f64| radii[(share * (radii.len() - 1) as f64).round() as usize];
    let [low, high] = [0.05, 0.95].map(at);
    item.number("cow, 5th percentile of r_g (% of the diagonal)", low);
    item.number("cow, 95th percentile of r_g (% of the diagonal)", high);
    item.claim(
        "sizes vary strongly",
        Outcome::of(high > 3.0 * low),
        format!("from {low:.2} to {high:.2} % of the diagonal (5th to 95th percentile)"),
    );
    Ok(())
}

pub(super) fn covers(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "The paper names re-triangulation, simplification and rendering as uses of patches and \
         chooses their sizes by hand. Here sizes follow from a tolerance, and patches are chosen \
         until they cover whatever can be covered: on the left the faces in the colour of the \
         patch that covers them, on the right the patches themselves. Faces that no patch covers \
         within the tolerance stay triangles; they are red.",
    );
    item.stand_in("A torus, which is generated; with models, a cow.");
    item.how(
        &["curvpatch::cover", "curvpatch::Cover::to_mesh"],
        &["curvmesh patch cow.obj -o cover.ply --tolerance 0.01 --relative --lenient"],
    );
    let torus = Torus { major: 2.0, minor: 1.0 }.mesh(48, 24).map_err(Failure::mesh)?;
    let above = DVec3::new(0.0, -0.8, 1.0);
    add_cover(run, item, &mesh_of(&torus)?, "torus", above)?;
    if let Some(cow) = run.model(item, MODEL)? {
        add_cover(run, item, &cow, "cow", FROM_SIDE)?;
    }
    Ok(())
}

fn add_cover(
    run: &Run<'_>,
    item: &mut Item,
    mesh: &TriMesh,
    name: &str,
    toward: DVec3,
) -> Result<(), Failure> {
    let estimator = estimator(mesh, Params::robust())?;
    let tolerance = TOLERANCE * diagonal(mesh);
    let made =
        curvpatch::cover(&estimator, &CoverOptions::new(tolerance)).map_err(Failure::mesh)?;
    add_numbers(item, name, mesh, &made);
    let view = view_of(mesh, toward, DVec3::Y)?;
    let caption = format!(
        "{} patches within 1 % of the diagonal cover {} of the {} faces of the {name}",
        made.patches.len(),
        made.covered_faces(),
        mesh.topology().face_count()
    );
    let thin = Style { edge_width: 0.7, ..WIDE };
    let faces = cover(mesh, &made);
    let smooth = patches(mesh, &made)?;
    item.side_by_side([
        faces.draw(run, &view, &thin, &format!("sn10-cover-{name}"), &caption)?,
        smooth.draw(
            run,
            &view,
            &thin,
            &format!("sn10-cover-{name}-patches"),
            "The patches, cut into triangles; in red the triangles that stay",
        )?,
    ]);
    Ok(())
}

fn add_numbers(item: &mut Item, name: &str, mesh: &TriMesh, made: &Cover) {
    item.number(format!("{name}, patches"), made.patches.len() as f64);
    item.number(format!("{name}, faces that stay triangles"), made.residual.len() as f64);
    let area =
        |faces: &mut dyn Iterator<Item = FaceId>| faces.map(|f| mesh.face_area(f)).sum::<f64>();
    let whole = area(&mut mesh.topology().faces());
    let left = area(&mut made.residual.iter().copied());
    item.number(format!("{name}, area covered (%)"), 100.0 * (1.0 - left / whole));
    item.number(format!("{name}, largest error / tolerance"), made.max_error() / made.tolerance);
}
