//! Fig. 4: a cube with a vertex a little inside each face.

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions, Ties};
use glam::DVec3;
use mesh_core::TriMesh;
use mesh_shapes::inset_cube;

use super::super::flips::optimise;
use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::measures::Measures;
use mesh_render::Style;
use xtask_common::Failure;
use xtask_common::plot::{Axis, Plot, Series};

/// How far inside: the paper says "slightly". The cube is [-1, 1]³.
const INSETS: [f64; 10] = [0.0, 0.05, 0.1, 0.15, 0.17, 0.2, 0.25, 0.3, 0.4, 0.5];
/// Which of them is drawn.
const DRAWN: usize = 5;

/// Random orders of flips with the same gain.
const ORDERS: u64 = 40;

/// One inset: before, after the paper's rule, and after minimising the area.
struct Case {
    inset: f64,
    initial: TriMesh,
    result: TriMesh,
    flips: u64,
    /// The fewest and the most flips over random orders of ties.
    flips_by_order: [u64; 2],
    smallest: TriMesh,
}

impl Case {
    fn new(inset: f64) -> Result<Self, Failure> {
        let initial = mesh_of(&inset_cube(inset).map_err(Failure::mesh)?)?;
        let mut result = initial.clone();
        let flips = optimise(
            &mut result,
            CostName::Willmore,
            VertexArea::Voronoi,
            &FlipOptions::default(),
        )?
        .flips;
        let mut flips_by_order = [flips; 2];
        for seed in 0..ORDERS {
            let options = FlipOptions { ties: Ties::Seeded(seed), ..FlipOptions::default() };
            let flips =
                optimise(&mut initial.clone(), CostName::Willmore, VertexArea::Voronoi, &options)?
                    .flips;
            flips_by_order = [flips_by_order[0].min(flips), flips_by_order[1].max(flips)];
        }
        let mut smallest = initial.clone();
        let options =
            FlipOptions { look_ahead: 3, forbid_intersections: true, ..FlipOptions::default() };
        optimise(&mut smallest, CostName::Area, VertexArea::Voronoi, &options)?;
        Ok(Self { inset, initial, result, flips, flips_by_order, smallest })
    }

    fn least_area(&self) -> f64 {
        self.smallest.area()
    }

    fn reaches_least_area(&self) -> bool {
        self.result.area() <= self.least_area() * (1.0 + 1e-9)
    }
}

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.how(
        &["dtri_flip::VirtualWillmore", "dcurv::total_willmore_energy", "mesh_shapes::inset_cube"],
        &[
            "curvmesh flip IN -o OUT --cost willmore --shape-constraint unrestricted",
            "curvmesh flip IN -o OUT --cost area --shape-constraint unrestricted",
        ],
    );
    let cases: Vec<Case> = INSETS.into_iter().map(Case::new).collect::<Result<_, _>>()?;
    item.number("corners", 8.0);
    let vertices = cases.first().map_or(0, |case| case.initial.topology().vertex_count());
    item.number("added vertices", vertices as f64 - 8.0);
    describe(item, &cases);
    add_numbers(item, &cases);
    add_claims(item, &cases)?;
    add_plot(item, &cases);
    add_pictures(run, item, &cases)
}

fn describe(item: &mut Item, cases: &[Case]) {
    let first = cases.iter().find(|case| case.flips > 0).map_or(f64::NAN, |case| case.inset);
    item.about(format!(
        "The corners of the cube [-1, 1]³ and the centres of its faces, pulled in by an inset; each \
         face is a fan of four triangles. The paper prints no numbers and not how far in its points \
         are, so the inset is varied. The rule as printed flips nothing up to 0.17; from {first} on \
         it flips some of the twelve edges of the cube, which lowers the area and W, while the sum \
         over the virtual points rises or falls with the inset."
    ));
}

fn add_numbers(item: &mut Item, cases: &[Case]) {
    let mut lines = Vec::new();
    for case in cases {
        let (before, after) = (Measures::of(&case.initial), Measures::of(&case.result));
        before.add(item, &format!("inset {}, before", case.inset));
        after.add(item, &format!("inset {}, after", case.inset));
        item.number(format!("inset {}, flips", case.inset), case.flips as f64);
        item.number(format!("inset {}, least area", case.inset), case.least_area());
        let pairs = before
            .cells()
            .into_iter()
            .zip(after.cells())
            .map(|(b, a)| if a == b { b } else { format!("{b} → {a}") });
        let [fewest, most] = case.flips_by_order;
        item.number(format!("inset {}, fewest flips", case.inset), fewest as f64);
        item.number(format!("inset {}, most flips", case.inset), most as f64);
        let orders = if fewest == most { most.to_string() } else { format!("{fewest} to {most}") };
        let ends = [format!("{:.4}", case.least_area()), case.flips.to_string(), orders];
        lines.push([case.inset.to_string()].into_iter().chain(pairs).chain(ends).collect());
    }
    item.table(
        "Before → after the printed rule. Virtual W: W and all that a point in the middle of each \
         edge, taken alone, adds to it. Least area: where flips by area end that let no faces \
         cross. By order: the number of flips over 40 random orders of equal gains.",
        Measures::header(&["inset"], &["least area", "flips", "by order"]),
        lines,
    );
}

fn add_claims(item: &mut Item, cases: &[Case]) -> Result<(), Failure> {
    let reached: Vec<f64> =
        cases.iter().filter(|c| c.reaches_least_area()).map(|c| c.inset).collect();
    let moved = || cases.iter().filter(|case| case.flips > 0);
    let all_lower = moved().all(|case| case.result.area() < case.initial.area());
    let gap = moved().map(|case| case.result.area() / case.least_area() - 1.0).fold(0.0, f64::max);
    let outcome = least_area(reached.len(), cases.len(), all_lower);
    let list: Vec<String> = reached.iter().map(f64::to_string).collect();
    let list =
        if list.is_empty() { "no inset".into() } else { format!("inset {}", list.join(", ")) };
    item.claim(
        "minimum area",
        outcome,
        format!(
            "wherever the rule flips at all the area falls, but it is the least one for {list}: the \
             rule stops after some of the twelve flips that lower the area, up to {:.0} % above the \
             least area that flips find without crossing faces",
            100.0 * gap
        ),
    );
    let (mut back, mut changed) = (0, 0);
    for case in moved() {
        let mut mesh = case.result.clone();
        optimise(
            &mut mesh,
            CostName::GaussExtrinsic,
            VertexArea::Voronoi,
            &FlipOptions::default(),
        )?;
        let same =
            mesh.topology().canonical_triangles() == case.initial.topology().canonical_triangles();
        back += usize::from(same);
        changed += 1;
    }
    item.claim("opposite effect", leads_back(back, changed), format!(
        "flips by the total absolute extrinsic curvature of Alboul and van Damme lead from the result back to the initial triangulation for {back} of \
         the {changed} insets at which the rule had changed anything"
    ));
    Ok(())
}

/// Whether flips by the other cost lead back wherever the rule changed anything.
fn leads_back(back: usize, changed: usize) -> Outcome {
    match back {
        0 => Outcome::Fails,
        n if n == changed => Outcome::Holds,
        _ => Outcome::InPart,
    }
}

/// Holds if the area is least for every inset; in part if it falls wherever the rule flips.
fn least_area(reached: usize, cases: usize, all_lower: bool) -> Outcome {
    match (reached == cases, all_lower) {
        (true, _) => Outcome::Holds,
        (false, true) => Outcome::InPart,
        (false, false) => Outcome::Fails,
    }
}

fn add_plot(item: &mut Item, cases: &[Case]) {
    let series = |name: &str, value: fn(&Case) -> f64| {
        Series::new(name, cases.iter().map(|case| [case.inset, value(case)]).collect())
    };
    let plot = Plot {
        x: Axis::linear("inset of the face centres (half an edge of the cube is 1)"),
        y: Axis::linear("area (square units of the model)"),
        series: vec![
            series("initial", |case| case.initial.area()),
            series("after the printed rule", |case| case.result.area()),
            Series { dashed: true, ..series("least area", Case::least_area) },
        ],
    };
    item.plot(&plot, "The remark on the minimum area would hold where the two lower curves meet.");
}

fn add_pictures(run: &Run<'_>, item: &mut Item, cases: &[Case]) -> Result<(), Failure> {
    let Some(case) = cases.get(DRAWN) else { return Ok(()) };
    let view = view_of(&case.initial, DVec3::new(0.45, 0.5, 1.0), DVec3::Y)?;
    let style = Style { size: [620, 600], edge_width: 2.2, ..Style::DEFAULT };
    let draw = |mesh, name: &str, what: &str| {
        let caption = format!("{what}, inset {}", case.inset);
        run.picture(mesh, &view, &style, &format!("bar06-cube-{name}"), &caption)
    };
    item.side_by_side([
        draw(&case.initial, "initial", "initial")?,
        draw(&case.result, "virtual", "after the printed rule")?,
        draw(&case.smallest, "area", "least area")?,
    ]);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_that_stay_turn_the_verdict() {
        assert_eq!(leads_back(5, 5), Outcome::Holds);
        assert_eq!(leads_back(4, 5), Outcome::InPart);
        assert_eq!(leads_back(0, 5), Outcome::Fails);
        assert_eq!(least_area(3, 3, true), Outcome::Holds);
        assert_eq!(least_area(2, 3, true), Outcome::InPart);
        assert_eq!(least_area(2, 3, false), Outcome::Fails);
    }
}
