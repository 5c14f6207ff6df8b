//! Fig. 4: simplification by the L2 curvature norm alone, by 30, 92 and 98 percent.

use dcurv::{CurvatureOptions, Curvatures, VertexArea};
use glam::DVec3;
use mesh_core::TriMesh;
use simplify::{Options, Preset};

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::distances::Original;
use super::head;
use super::runs::{CHAINS, IGEA, levels};
use super::similarity::add_similarity_claim;
use mesh_render::Style;
use xtask_common::Failure;
use xtask_common::decimals::plain;

/// The percentages of the figure.
const REDUCTIONS: [f64; 3] = [30.0, 92.0, 98.0];
/// A mean distance that cannot be seen, in percent of the diagonal: half a pixel on a picture a
/// thousand pixels across.
const INVISIBLE: f64 = 0.05;

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Edges collapse in the order of how little they change the curvature norm, eq. (2), and the \
         new vertex goes where butterfly subdivision would put it. The paper does not say which \
         model its figure shows, and gives no errors.",
    );
    item.stand_in("A head of 20,480 faces made of formulas; with models, Igea.");
    item.how(
        &["simplify::simplify", "simplify::CurvatureNorm", "simplify::ButterflyPoint"],
        &["curvmesh simplify IN -o OUT --preset paper-l2 --ratio 0.7"],
    );
    let mut lines = Vec::new();
    let made = mesh_of(&head::head()?)?;
    let (l2, l1) =
        rayon::join(|| norm_levels(&made, Preset::PaperL2), || norm_levels(&made, Preset::PaperL1));
    let (l2, l1) = (l2?, l1?);
    add_lines(item, &mut lines, ["made head", "L2"], &l2);
    add_lines(item, &mut lines, ["made head", "L1"], &l1);
    for (reduction, level) in REDUCTIONS.iter().zip(&l2.levels) {
        let share = level.topology().face_count() as f64 / made.topology().face_count() as f64;
        item.number(format!("reduction by about {reduction} %"), 100.0 * (1.0 - share));
    }
    add_claims(item, &l2, &l1);
    add_pictures(run, item, "made", &made, &l2, DVec3::new(0.35, 0.1, 1.0))?;
    if !run.quick
        && let Some(igea) = run.model(item, IGEA)?
    {
        let l2 = norm_levels(&igea, Preset::PaperL2)?;
        add_lines(item, &mut lines, ["Igea", "L2"], &l2);
        item.claim(
            "same shape, Igea",
            Outcome::of(l2.errors[0] < INVISIBLE),
            format!("at 30 % the mean distance is {:.4} % of the diagonal", l2.errors[0]),
        );
        add_pictures(run, item, "igea", &igea, &l2, DVec3::new(0.0, 0.0, 1.0))?;
    }
    let header = ["model", "norm", "reduced by", "faces", "mean distance", "change of the norm"];
    item.table(
        "Mean distance between original and result, both ways, in percent of the diagonal of the \
         bounding box. The norm is eq. (2) or (1) of the whole mesh.",
        header,
        lines,
    );
    Ok(())
}

/// The levels of one norm.
struct Levels {
    levels: Vec<TriMesh>,
    /// Mean distances in percent of the diagonal.
    errors: Vec<f64>,
    /// The norm of each level, relative to that of the original, less one.
    norm_changes: Vec<f64>,
}

fn add_lines(
    item: &mut Item,
    lines: &mut Vec<Vec<String>>,
    [name, norm]: [&str; 2],
    levels: &Levels,
) {
    for (i, reduction) in REDUCTIONS.iter().enumerate() {
        let quantity = format!("{name}, {norm}, {reduction} %, mean distance in %");
        item.number_within(quantity, levels.errors[i], CHAINS);
        lines.push(vec![
            name.to_owned(),
            norm.to_owned(),
            format!("{reduction} %"),
            plain(levels.levels[i].topology().face_count() as f64),
            format!("{:.4} %", levels.errors[i]),
            format!("{:+.1} %", 100.0 * levels.norm_changes[i]),
        ]);
    }
}

fn norm_levels(mesh: &TriMesh, preset: Preset) -> Result<Levels, Failure> {
    let original = Original::new(mesh)?;
    let faces = mesh.topology().face_count() as f64;
    let targets = REDUCTIONS.map(|percent| ((1.0 - percent / 100.0) * faces).round() as usize);
    let levels = levels(mesh, Options::preset(preset), &targets)?;
    let errors = levels.iter().map(|m| original.mean_percent(m)).collect::<Result<_, _>>()?;
    let before = norm(mesh, preset);
    let norm_changes = levels.iter().map(|m| norm(m, preset) / before - 1.0).collect();
    Ok(Levels { levels, errors, norm_changes })
}

/// Eq. (1), or the square root of eq. (2), of a whole mesh: with a third of the adjacent faces as
/// the area of a vertex.
fn norm(mesh: &TriMesh, preset: Preset) -> f64 {
    let options = CurvatureOptions { area: VertexArea::Barycentric };
    let curvatures = Curvatures::of(mesh, &options);
    let all = curvatures.vertices().as_slice().iter();
    match preset {
        Preset::PaperL1 => all.map(|c| c.abs_principal_sum().value()).sum(),
        _ => all.map(|c| c.squared_principal_sum().value()).sum::<f64>().sqrt(),
    }
}

fn add_claims(item: &mut Item, l2: &Levels, l1: &Levels) {
    item.claim(
        "same shape",
        Outcome::of(l2.errors[0] < INVISIBLE),
        format!(
            "at 30 % the mean distance is {:.4} % of the diagonal, at 98 % {:.2} %. Holds if the former is \
             less than {INVISIBLE} %, half a pixel",
            l2.errors[0], l2.errors[2]
        ),
    );
    item.claim(
        "no variance",
        Outcome::of(l2.norm_changes[0].abs() < 0.01),
        format!("at 30 % the norm has changed by {:+.2} %", 100.0 * l2.norm_changes[0]),
    );
    let ratios = std::array::from_fn(|i| l2.errors[i] / l1.errors[i]);
    add_similarity_claim(item, "norms are similar", ratios);
}

fn add_pictures(
    run: &Run<'_>,
    item: &mut Item,
    name: &str,
    mesh: &TriMesh,
    l2: &Levels,
    toward: DVec3,
) -> Result<(), Failure> {
    let view = view_of(mesh, toward, DVec3::Y)?;
    let style = Style { size: [520, 620], ..Style::DEFAULT };
    let mut figures = vec![run.picture(
        mesh,
        &view,
        &style,
        &format!("kkl02-norm-{name}-original"),
        &format!("original, {} faces", plain(mesh.topology().face_count() as f64)),
    )?];
    for (reduction, level) in REDUCTIONS.iter().zip(&l2.levels) {
        let count = plain(level.topology().face_count() as f64);
        let caption = format!("L2 norm, {reduction} % fewer: {count} faces");
        let file = format!("kkl02-norm-{name}-{reduction}");
        figures.push(run.picture(level, &view, &style, &file, &caption)?);
    }
    item.side_by_side(figures);
    Ok(())
}
