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
        &["curvmesh flip IN -o OUT --cost f2", "curvmesh flip IN -o OUT --cost f2 --look-ahead 2"],
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
    )?;
    let made_part = mesh_of(&part::part()?)?;
    let part = add(
        run,
        item,
        &mut lines,
        "made part",
        &made_part,
        [DVec3::new(-0.5, -1.0, 1.1), DVec3::Z],
    )?;
    claim(item, "smoother", &[face, part]);
    let mut real = Vec::new();
    for case in &CASES {
        if let Some(mesh) = run.model(item, case.file)? {
            real.push(add(run, item, &mut lines, case.name, &mesh, [case.toward, case.up])?);
        }
    }
    if real.len() == CASES.len() {
        claim(item, "smoother, real models", &real);
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

/// What became of a model: its costs before, and after minimising each of them.
struct Change {
    name: String,
    before: [f64; 3],
    after: [[f64; 3]; 3],
}

fn add(
    run: &Run<'_>,
    item: &mut Item,
    lines: &mut Vec<Vec<String>>,
    name: &str,
    mesh: &TriMesh,
    view: [DVec3; 2],
) -> Result<Change, Failure> {
    let mut change = Change { name: name.to_owned(), before: costs(mesh), after: [[0.0; 3]; 3] };
    let line = |minimised: &str, depth: &str, flips: u64, costs: [f64; 3]| {
        let names = [name, minimised, depth].map(str::to_owned);
        let costs = costs.map(|cost| format!("{cost:.4}"));
        names.into_iter().chain([flips.to_string()]).chain(costs).collect()
    };
    lines.push(line("-", "", 0, change.before));
    item.number(format!("{name}, F2 before"), change.before[1]);
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
            change.after[cost] = after;
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
    Ok(change)
}

/// Smoother: every cost falls when it is minimised. Similar: F2 ends about as low by any of them.
fn claim(item: &mut Item, name: &str, changes: &[Change]) {
    let is_smoother =
        changes.iter().all(|change| (0..3).all(|i| change.after[i][i] < change.before[i]));
    let falls: Vec<String> = changes
        .iter()
        .map(|c| {
            let fall = |after: [f64; 3]| format!("{:.0}", 100.0 * (1.0 - after[1] / c.before[1]));
            let [f1, f2, f3] = c.after.map(fall);
            format!("{} {f2} % ({f1} % by F1, {f3} % by F3)", c.name)
        })
        .collect();
    item.claim(name, Outcome::of(is_smoother), format!("F2 falls on {}", falls.join(", on ")));
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
