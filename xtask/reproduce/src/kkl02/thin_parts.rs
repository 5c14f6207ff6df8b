//! Fig. 5 and 7 (a): a helicopter whose thin propellers are to be kept.

use glam::DVec3;
use mesh_core::TriMesh;
use mesh_metric::Surface;
use rayon::prelude::*;
use simplify::{Options, Preset};

use super::super::item::{Figure, Item};
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::distances::Original;
use super::rotorcraft;
use super::runs::{CHAINS, butterfly, distance_only, levels, simplified, with_curvature};
use mesh_render::Style;
use xtask_common::Failure;
use xtask_common::decimals::plain;
use xtask_common::plot::{Axis, Plot, Series};

/// The faces of the figure, and further ones for the curves.
const FACES: usize = 986;
const CURVE: [usize; 7] = [10_000, 5_000, 2_000, FACES, 500, 300, 200];
/// Which of them is that of the figure.
const FIGURE: usize = 3;
/// The commands that give results of the made craft, whose file is beside the page.
const COMMANDS: [&str; 4] = [
    "curvmesh simplify kkl02-craft-made-original.ply -o distance.ply --faces 986 --preset quadrics",
    "curvmesh simplify kkl02-craft-made-original.ply -o both.ply --faces 986 --preset quadrics --curvature-weight 1",
    "curvmesh simplify kkl02-craft-made-original.ply -o thin.ply --faces 986 --preset thin-features --components 8",
    "curvmesh distance kkl02-craft-made-original.ply both.ply --samples 100k",
];
/// A blade's vertex counts as kept if the result passes within this share of the diagonal.
const KEPT: f64 = 0.002;
/// A real helicopter.
const HELICOPTER: &str = "helicopter.obj";

/// A way to simplify.
struct Way {
    name: &'static str,
    options: fn() -> Options,
    drawn: bool,
}

const WAYS: [Way; 8] = [
    Way { name: "distance only", options: distance_only, drawn: true },
    Way { name: "distance and curvature", options: || with_curvature(1.0), drawn: true },
    Way { name: "distance only, butterfly", options: || butterfly(distance_only()), drawn: false },
    Way {
        name: "distance and curvature, butterfly",
        options: || butterfly(with_curvature(1.0)),
        drawn: false,
    },
    Way {
        name: "curvature only (L1), as published",
        options: || Options::preset(Preset::PaperL1),
        drawn: true,
    },
    Way {
        name: "curvature only (L1), guarded",
        options: || Options::preset(Preset::PaperL1Guarded),
        drawn: true,
    },
    Way { name: "distance only, parts guarded", options: || guarded(distance_only()), drawn: true },
    Way {
        name: "curvmesh, thin features, parts guarded",
        options: || guarded(Options::preset(Preset::ThinFeatures)),
        drawn: true,
    },
];

/// The place of the distance alone with parts guarded.
const GUARDED: usize = 6;

/// Every part keeps some vertices.
fn guarded(mut options: Options) -> Options {
    options.protect.min_component_vertices = Some(8);
    options
}

/// What came of one way.
struct Outcomes {
    /// For all face counts of the curve: means in percent of the diagonal, and the shares of the
    /// blades that are kept.
    curve: Vec<[f64; 2]>,
    mesh: TriMesh,
    mean: f64,
    largest: f64,
    /// The share of the vertices of the blades that the result passes by.
    kept: Option<f64>,
}

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "A helicopter down to 986 faces, by the distance alone (quadrics with optimal placement) and \
         by distance and curvature together. The paper does not say how it joins the two; here the \
         distance cost of a collapse is multiplied by one plus the relative change of the integral \
         of |k1| + |k2|. The curvature alone is shown as published and guarded against folds and slivers. What keeps thin \
         parts best is a guard that leaves every part of the model a few vertices.",
    );
    item.stand_in(
        "A helicopter made of 22 closed parts, with the paper's number of faces; the paper's own is \
         not public. With models, another real one, repaired.",
    );
    item.how(
        &[
            "simplify::simplify",
            "simplify::CurvatureFactor",
            "simplify::ComponentConstraint",
            "mesh_metric::compare",
        ],
        &COMMANDS,
    );
    let craft = rotorcraft::rotorcraft()?;
    let mesh = mesh_of(&craft.soup)?;
    item.number("faces of the original", mesh.topology().face_count() as f64);
    let blades: Vec<DVec3> =
        craft.blade_vertices.iter().map(|&v| craft.soup.positions()[v]).collect();
    let mut lines = Vec::new();
    let results = add_model(item, &mut lines, "made craft", &mesh, Some(&blades))?;
    item.number("faces of the results", results[0].mesh.topology().face_count() as f64);
    add_claims(item, &results);
    let toward = DVec3::new(0.55, 0.75, 1.0);
    add_pictures(run, item, "made", &mesh, &results, toward)?;
    add_curves(item, &results);
    if !run.quick
        && let Some(real) = run.model(item, HELICOPTER)?
    {
        let results = add_model(item, &mut lines, "real helicopter", &real, None)?;
        add_real_claim(item, &results);
        add_pictures(run, item, "real", &real, &results, DVec3::new(0.6, 0.5, 1.0))?;
    }
    let header = ["model", "way", "faces", "mean distance", "largest distance", "blades kept"];
    item.table(
        "Distances both ways in percent of the diagonal of the bounding box. Blades kept: share of \
         the original vertices of the seven blades that the result passes within 0.2 %.",
        header,
        lines,
    );
    Ok(())
}

fn add_model(
    item: &mut Item,
    lines: &mut Vec<Vec<String>>,
    name: &str,
    mesh: &TriMesh,
    blades: Option<&[DVec3]>,
) -> Result<Vec<Outcomes>, Failure> {
    let original = Original::new(mesh)?;
    let results: Vec<Outcomes> = WAYS
        .par_iter()
        .map(|way| outcomes(&original, mesh, way, blades))
        .collect::<Result<_, _>>()?;
    for (way, result) in WAYS.iter().zip(&results) {
        let of = format!("{name}, {}", way.name);
        item.number_within(format!("{of}, mean distance in %"), result.mean, CHAINS);
        item.number_within(format!("{of}, largest distance in %"), result.largest, CHAINS);
        if let Some(kept) = result.kept {
            item.number_within(format!("{of}, share of the blades kept"), kept, CHAINS);
        }
        lines.push(vec![
            name.to_owned(),
            way.name.to_owned(),
            result.mesh.topology().face_count().to_string(),
            format!("{:.4} %", result.mean),
            format!("{:.3} %", result.largest),
            result.kept.map_or_else(String::new, |kept| format!("{:.0} %", 100.0 * kept)),
        ]);
    }
    Ok(results)
}

fn outcomes(
    original: &Original,
    mesh: &TriMesh,
    way: &Way,
    blades: Option<&[DVec3]>,
) -> Result<Outcomes, Failure> {
    let options = (way.options)();
    // Fitting is done for one face count; without, all come from the same run.
    let mut levels = if options.refine.fit {
        vec![simplified(mesh, options, FACES)?.mesh]
    } else {
        levels(mesh, options, &CURVE)?
    };
    let kept = |mesh: &TriMesh| -> Result<f64, Failure> {
        let Some(points) = blades else { return Ok(f64::NAN) };
        let surface = Surface::new(mesh).map_err(Failure::mesh)?;
        let near = surface.distances(points).into_iter().filter(|d| *d < KEPT * original.diagonal);
        Ok(near.count() as f64 / points.len().max(1) as f64)
    };
    let curve: Vec<[f64; 2]> = levels
        .iter()
        .map(|level| Ok([original.mean_percent(level)?, kept(level)?]))
        .collect::<Result<_, Failure>>()?;
    let simplified = levels.swap_remove(FIGURE.min(levels.len() - 1));
    let distances = original.compare(&simplified)?;
    let kept = blades.map(|_| curve[FIGURE.min(curve.len() - 1)][1]);
    Ok(Outcomes {
        curve,
        mean: original.percent(distances.mean()),
        largest: original.percent(distances.hausdorff()),
        mesh: simplified,
        kept,
    })
}

fn add_claims(item: &mut Item, results: &[Outcomes]) {
    let [distance, both] = [&results[0], &results[1]];
    let percent = |kept: Option<f64>| 100.0 * kept.unwrap_or(0.0);
    item.claim(
        "propellers",
        Outcome::of(both.kept > distance.kept),
        format!(
            "of the blades {:.0} % are kept by the distance alone and {:.0} % with the curvature; \
             {:.0} % by the distance alone when every part is guarded",
            percent(distance.kept),
            percent(both.kept),
            percent(results[GUARDED].kept)
        ),
    );
    item.claim(
        "smaller error, helicopter",
        Outcome::of(both.mean < 0.98 * distance.mean),
        format!(
            "at {FACES} faces the mean distance is {:.4} % by the distance alone and {:.4} % with the \
             curvature ({:+.1} %); with the new vertex at the butterfly point {:.4} % and {:.4} % \
             ({:+.1} %)",
            distance.mean,
            both.mean,
            change(distance, both),
            results[2].mean,
            results[3].mean,
            change(&results[2], &results[3]),
        ),
    );
}

fn change(before: &Outcomes, after: &Outcomes) -> f64 {
    100.0 * (after.mean / before.mean - 1.0)
}

fn add_real_claim(item: &mut Item, results: &[Outcomes]) {
    let [distance, both] = [&results[0], &results[1]];
    item.claim(
        "smaller error, real helicopter",
        Outcome::of(both.mean < 0.98 * distance.mean),
        format!(
            "the mean distance is {:.4} % by the distance alone and {:.4} % with the curvature, the \
             largest {:.2} % and {:.2} %",
            distance.mean, both.mean, distance.largest, both.largest
        ),
    );
}

/// Mean error against face count, as in Fig. 7 (a), and what is kept of the blades.
fn add_curves(item: &mut Item, results: &[Outcomes]) {
    let quantities = [
        ("mean distance in %", "mean distance (% of the diagonal of the bounding box)"),
        ("blades kept", "share of the blades that is kept"),
    ];
    for (i, (quantity, label)) in quantities.into_iter().enumerate() {
        let mut series = Vec::new();
        for (way, result) in WAYS.iter().zip(results).filter(|(_, r)| r.curve.len() == CURVE.len())
        {
            let mut points = Vec::new();
            for (faces, values) in CURVE.iter().zip(&result.curve) {
                let of = format!("curve, {}, {faces} faces, {quantity}", way.name);
                item.number_within(of, values[i], CHAINS);
                points.push([*faces as f64, values[i]]);
            }
            series.push(Series::new(way.name, points));
        }
        let y = if i == 0 { Axis::log(label) } else { Axis::linear(label) };
        let plot = Plot { x: Axis::log("faces"), y, series };
        let caption = [
            "Mean distance from the made craft, as Fig. 7 (a).",
            "What is left of the made craft's blades.",
        ];
        item.plot(&plot, caption[i]);
    }
}

/// The name of the files of an original, without extension.
fn original_file(name: &str) -> String {
    format!("kkl02-craft-{name}-original")
}

fn add_pictures(
    run: &Run<'_>,
    item: &mut Item,
    name: &str,
    mesh: &TriMesh,
    results: &[Outcomes],
    toward: DVec3,
) -> Result<(), Failure> {
    let view = view_of(mesh, toward, DVec3::Y)?;
    let style = Style { size: [720, 480], edge_width: 0.8, ..Style::DEFAULT };
    let draw = |mesh: &TriMesh, file: &str, caption: &str| -> Result<Figure, Failure> {
        let caption = format!("{caption}, {} faces", plain(mesh.topology().face_count() as f64));
        run.picture(mesh, &view, &style, &format!("kkl02-craft-{name}-{file}"), &caption)
    };
    let plain_style = Style { edge_width: 0.0, ..style.clone() };
    let caption = format!("original, {} faces", plain(mesh.topology().face_count() as f64));
    let mut figures =
        vec![run.picture(mesh, &view, &plain_style, &original_file(name), &caption)?];
    for (i, (way, result)) in WAYS.iter().zip(results).enumerate() {
        if way.drawn {
            figures.push(draw(&result.mesh, &i.to_string(), way.name)?);
        }
    }
    item.side_by_side(figures);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::{read_in, run_in};
    use crate::recorded::Recorded;
    use mesh_render::Paint;

    #[test]
    fn the_commands_give_the_recorded_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let run = Run { out: folder.path(), models: None, quick: true };
        let mesh = mesh_of(&rotorcraft::rotorcraft().unwrap().soup).unwrap();
        run.keep(&original_file("made"), &mesh, Paint::Clay).unwrap();
        COMMANDS.iter().for_each(|command| run_in(folder.path(), command));
        let (original, recorded) = (Original::new(&mesh).unwrap(), Recorded::read().unwrap());
        let ways = [
            ("distance.ply", WAYS[0].name),
            ("both.ply", WAYS[1].name),
            ("thin.ply", "curvmesh, thin features, parts guarded"),
        ];
        for (file, way) in ways {
            let result = read_in(folder.path(), file);
            assert_eq!(result.topology().face_count(), FACES, "{way}");
            let mean = original.percent(original.compare(&result).unwrap().mean());
            let quantity = format!("made craft, {way}, mean distance in %");
            let expected = recorded.value("KKL02", "Fig. 5 and 7 (a)", &quantity).unwrap();
            assert!((mean / expected - 1.0).abs() < 1e-6, "{way}: {mean}, {expected} is recorded");
        }
    }
}
