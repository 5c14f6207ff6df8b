//! Fig. 7 to 9: a head, a technical part and a cap before and after optimisation.
//!
//! The paper's own models are not public; these are of the same kinds.

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions};
use glam::DVec3;
use mesh_core::TriMesh;
use rayon::prelude::*;

use super::super::bar06::face_shape;
use super::super::flips::optimise;
use super::super::item::{Figure, Item};
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::part;
use mesh_render::Style;
use xtask_common::Failure;

/// A real model.
struct Case {
    file: &'static str,
    name: &'static str,
    toward: DVec3,
    up: DVec3,
}

const CASES: [Case; 4] = [
    Case { file: "face_52k.obj", name: "face", toward: DVec3::new(0.3, 0.1, 1.0), up: DVec3::Y },
    Case { file: "fandisk.obj", name: "fandisk", toward: DVec3::new(0.6, 0.5, -1.0), up: DVec3::Y },
    Case { file: "casting.off", name: "casting", toward: DVec3::new(0.3, 1.0, 0.6), up: DVec3::Y },
    Case {
        file: "anchor_dense.off",
        name: "anchor",
        toward: DVec3::new(0.5, 0.6, 1.0),
        up: DVec3::Y,
    },
];

/// Models with as many faces are not looked ahead on: that takes minutes.
const LARGE: usize = 9_000;

const COSTS: [(&str, CostName); 3] =
    [("F1", CostName::F1), ("F2", CostName::F2), ("F3", CostName::F3)];

/// All costs before and after, with and without look-ahead, and pictures for F2.
pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "A head and technical parts before and after minimising F2, drawn with one normal per face, \
         and all three costs after minimising each, without and with look-ahead. The paper shows \
         pictures only.",
    );
    item.stand_in(
        "In place of the paper's head, technical part and tank cap, which are not public: a face and \
         a part made of formulas; with models, also a scanned head and three technical parts.",
    );
    item.how(
        &["dtri_flip::optimise", "dtri_flip::CostName::total"],
        &[
            "curvmesh flip IN -o OUT --cost f2 --shape-constraint unrestricted",
            "curvmesh flip IN -o OUT --cost f2 --shape-constraint unrestricted --look-ahead 2",
        ],
    );
    let mut lines = Vec::new();
    let made_face = mesh_of(&face_shape::scan()?)?;
    let face = add(
        run,
        item,
        &mut lines,
        "made face",
        &made_face,
        [DVec3::new(-0.35, 0.12, 1.0), DVec3::Y],
        Some(face_shape::height),
    )?;
    let made_part = mesh_of(&part::part()?)?;
    let part = add(
        run,
        item,
        &mut lines,
        "made part",
        &made_part,
        [DVec3::new(-0.5, -1.0, 1.1), DVec3::Z],
        Some(part::height),
    )?;
    claims(item, "", &[face, part]);
    let mut real = Vec::new();
    for case in &CASES {
        if let Some(mesh) = run.model(item, case.file)? {
            real.push(add(run, item, &mut lines, case.name, &mesh, [case.toward, case.up], None)?);
        }
    }
    if real.len() == CASES.len() {
        claims(item, ", real models", &real);
    }
    let header = ["model", "minimised", "depth", "flips", "F1", "F2", "F3"];
    item.table(
        "All costs after minimising one of them; depth 2 looks two flips ahead.",
        header,
        lines,
    );
    Ok(())
}

/// The costs of a mesh: F1, F2, F3.
fn costs(mesh: &TriMesh) -> [f64; 3] {
    COSTS.map(|(_, cost)| cost.total(mesh, VertexArea::Voronoi))
}

/// One model before and after.
struct Change {
    name: String,
    /// The costs after minimising each of them.
    after: [[f64; 3]; 3],
    /// F3 before and after minimising F2.
    f3: [f64; 2],
    /// The mean angle between the normals of faces and surface, where that is known by formula.
    normals: Option<[f64; 2]>,
}

fn add(
    run: &Run<'_>,
    item: &mut Item,
    lines: &mut Vec<Vec<String>>,
    name: &str,
    mesh: &TriMesh,
    view: [DVec3; 2],
    height: Option<fn(f64, f64) -> f64>,
) -> Result<Change, Failure> {
    let before = costs(mesh);
    let mut after_each = [[0.0; 3]; 3];
    let line = |minimised: &str, depth: &str, flips: u64, costs: [f64; 3]| {
        let names = [name, minimised, depth].map(str::to_owned);
        let costs = costs.map(|cost| format!("{cost:.4}"));
        names.into_iter().chain([flips.to_string()]).chain(costs).collect()
    };
    lines.push(line("-", "", 0, before));
    item.number(format!("{name}, F2 before"), before[1]);
    let depths = if mesh.topology().face_count() < LARGE { 1..=2 } else { 1..=1 };
    let runs: Vec<(usize, usize)> =
        (0..3).flat_map(|cost| depths.clone().map(move |depth| (cost, depth))).collect();
    let minimise = |&(cost, look_ahead): &(usize, usize)| {
        let mut optimised = mesh.clone();
        let options = FlipOptions { look_ahead, ..FlipOptions::default() };
        let report = optimise(&mut optimised, COSTS[cost].1, VertexArea::Voronoi, &options)?;
        Ok((optimised, report.flips))
    };
    let results: Vec<(TriMesh, u64)> =
        runs.par_iter().map(minimise).collect::<Result<_, Failure>>()?;
    for (&(cost, depth), (optimised, flips)) in runs.iter().zip(&results) {
        let after = costs(optimised);
        let minimised = COSTS[cost].0;
        lines.push(line(minimised, &depth.to_string(), *flips, after));
        if depth == 1 {
            after_each[cost] = after;
            item.number(format!("{name}, {minimised} after"), after[cost]);
            item.number(format!("{name}, flips by {minimised}"), *flips as f64);
        } else {
            item.number(format!("{name}, {minimised} after, depth {depth}"), after[cost]);
        }
    }
    let by_f2 = runs.iter().zip(&results).find(|(run, _)| **run == (1, 1));
    let by_f2 = by_f2.map_or(mesh, |(_, (optimised, _))| optimised);
    let draw = |mesh, when| figure(run, mesh, name, view, when);
    item.side_by_side([draw(mesh, "before")?, draw(by_f2, "after")?]);
    let f3 = [mesh, by_f2].map(|mesh| costs(mesh)[2]);
    let normals = height.map(|height| [mesh, by_f2].map(|mesh| mean_normal_error(mesh, height)));
    Ok(Change { name: name.to_owned(), after: after_each, f3, normals })
}

/// Results are very similar if F2 after minimising each cost differs by at most this share of what is left of it.
const SIMILAR: f64 = 0.05;

/// The claims on a group of models; `suffix` tells the groups apart.
fn claims(item: &mut Item, suffix: &str, changes: &[Change]) {
    let list = |line: &dyn Fn(&Change) -> String| {
        changes.iter().map(line).collect::<Vec<String>>().join("; ")
    };
    item.claim(
        &format!("smoother{suffix}"),
        smoother(changes),
        format!(
            "judged by F3, which was not minimised, and, where the surface is known by formula, by the mean angle \
             between the normals of faces and surface, before and after minimising F2: {}",
            list(&|change| {
                let normals = change.normals.map_or_else(String::new, |[before, after]| {
                    format!(", the angle from {before:.2}° to {after:.2}°")
                });
                let [before, after] = change.f3;
                format!("{}, F3 from {before:.1} to {after:.1}{normals}", change.name)
            })
        ),
    );
    item.claim(
        &format!("similar{suffix}"),
        similar(changes),
        format!(
            "F2 after minimising F1, F2 and F3 differs by {} of its least value (very similar: at most \
             {:.0} %)",
            list(&|change| format!("{:.1} % on {}", 100.0 * change.spread(), change.name)),
            100.0 * SIMILAR
        ),
    );
}

/// Smoother by measures that F2 does not minimise: by both, by one, or by none, on every model.
fn smoother(changes: &[Change]) -> Outcome {
    let falls = |[before, after]: [f64; 2]| after < before;
    let by_f3 = changes.iter().all(|change| falls(change.f3));
    let by_normals = changes.iter().filter_map(|change| change.normals).all(falls);
    match (by_f3, by_normals) {
        (true, true) => Outcome::Holds,
        (false, false) => Outcome::Fails,
        _ => Outcome::InPart,
    }
}

/// Whether the three results are very similar, on all models, some, or none.
fn similar(changes: &[Change]) -> Outcome {
    let count = changes.iter().filter(|change| change.spread() <= SIMILAR).count();
    match count {
        0 => Outcome::Fails,
        n if n == changes.len() => Outcome::Holds,
        _ => Outcome::InPart,
    }
}

impl Change {
    /// The range of F2 after minimising each cost, over its least value.
    fn spread(&self) -> f64 {
        let f2 = self.after.map(|costs| costs[1]);
        let least = f2.into_iter().fold(f64::INFINITY, f64::min);
        f2.into_iter().fold(0.0, f64::max) / least - 1.0
    }
}

/// The mean angle between the normals of the faces and of the surface above them, weighted by area, in
/// degrees.
fn mean_normal_error(mesh: &TriMesh, height: fn(f64, f64) -> f64) -> f64 {
    const STEP: f64 = 1e-4;
    let (mut sum, mut area) = (0.0, 0.0);
    for face in mesh.topology().faces() {
        let corners = mesh.triangle(face);
        let center = corners.into_iter().sum::<DVec3>() / 3.0;
        let slope = |dx: f64, dy: f64| {
            (height(center.x + dx, center.y + dy) - height(center.x - dx, center.y - dy))
                / (2.0 * STEP)
        };
        let normal = DVec3::new(-slope(STEP, 0.0), -slope(0.0, STEP), 1.0);
        let weight = mesh.face_area(face);
        sum += weight * mesh.face_cross(face).angle_between(normal);
        area += weight;
    }
    (sum / area).to_degrees()
}

fn figure(
    run: &Run<'_>,
    mesh: &TriMesh,
    model: &str,
    [toward, up]: [DVec3; 2],
    when: &str,
) -> Result<Figure, Failure> {
    let view = view_of(mesh, toward, up)?;
    let style = Style { size: [720, 600], ..Style::DEFAULT };
    let name = format!("dhkl01-{}-{when}", model.replace(' ', "-"));
    run.picture(mesh, &view, &style, &name, &format!("{model}, {when} minimising F2"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change() -> Change {
        Change {
            name: String::new(),
            after: [[3.0, 10.0, 9.0], [3.1, 9.9, 9.0], [3.1, 10.0, 8.9]],
            f3: [9.0, 6.0],
            normals: Some([5.0, 3.0]),
        }
    }

    #[test]
    fn a_higher_cost_or_worse_normals_turn_the_verdict() {
        assert_eq!(smoother(&[change()]), Outcome::Holds);
        let rougher = Change { f3: [6.0, 9.0], ..change() };
        assert_eq!(smoother(&[change(), rougher]), Outcome::InPart);
        let worse = Change { f3: [6.0, 9.0], normals: Some([3.0, 5.0]), ..change() };
        assert_eq!(smoother(&[worse]), Outcome::Fails);
    }

    #[test]
    fn results_that_differ_turn_the_verdict() {
        assert_eq!(similar(&[change()]), Outcome::Holds);
        let mut other = change();
        other.after[0][1] = 12.0;
        assert_eq!(similar(&[change(), other]), Outcome::InPart);
    }
}
