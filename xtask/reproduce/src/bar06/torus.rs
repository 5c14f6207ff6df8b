//! Fig. 5: points on a torus, by the rule as printed and by better founded ones.

use dcurv::{VertexArea, total_willmore_energy};
use dtri_flip::{CostName, FlipOptions, LatticeError, Stop, Ties, lattice_error};
use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::TriMesh;
use mesh_shapes::{SignedDistance, Torus, scramble};

use super::super::flips::optimise;
use super::super::item::{Figure, Item};
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use super::measures::Measures;
use super::rules::RULES;
use mesh_render::Style;
use xtask_common::Failure;

const TORUS: Torus = Torus { major: 5.0, minor: 2.0 };
/// Rings and sides of the two tori.
const SIZES: [[usize; 2]; 2] = [[12, 6], [24, 12]];
/// Lattice steps on a side of a triangle.
const SUBDIVISIONS: u32 = 20;
/// Orders of flips with the same gain: that of the edges' numbers, and random ones.
const ORDERS: u64 = 40;
/// Starts of the example that goes in circles, and the random flips before each.
const STARTS: u64 = 10;
const SCRAMBLES: usize = 150;

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Points on a torus with radii 5 and 2, in rings of which every other is turned by half a \
         step: the initial triangulation has creases. The paper does not give its points. Beside \
         the printed rule there are the Willmore energy itself, which does change under flips and \
         is a true potential, and F2.",
    );
    item.stand_in("The tori of 12 x 6 and 24 x 12 points of DHKL01, in place of the paper's.");
    item.how(
        &["dtri_flip::VirtualWillmore", "dtri_flip::Willmore", "dtri_flip::lattice_error"],
        &[
            "curvmesh flip IN -o OUT --cost willmore --shape-constraint unrestricted",
            "curvmesh flip IN -o OUT --cost willmore-potential --shape-constraint unrestricted",
        ],
    );
    let mut lines = Vec::new();
    let mut tori = Vec::new();
    let mut energies = Vec::new();
    for [rings, sides] in SIZES {
        let initial = mesh_of(&TORUS.shifted_mesh(rings, sides).map_err(Failure::mesh)?)?;
        let name = format!("{rings} x {sides}");
        let mut figures = vec![picture(run, &initial, &name, "initial")?];
        lines.push(line(item, &name, "initial", &initial, 0));
        for rule in &RULES {
            let mut mesh = initial.clone();
            let flips = rule.optimise(&mut mesh)?.flips;
            if rule.name == RULES[0].name {
                energies.push([&initial, &mesh].map(total_willmore_energy));
            }
            lines.push(line(item, &name, rule.name, &mesh, flips));
            if rule.max_fold.is_none() {
                figures.push(picture(run, &mesh, &name, rule.name)?);
            }
        }
        item.side_by_side(figures);
        tori.push(ByOrder::of(item, name, &initial)?);
    }
    item.table(
        "Ties by edge number. Spread of areas: standard deviation over mean of the triangles' areas. \
         Distances to the torus in units of the model, over a lattice of 20 steps per side.",
        Measures::header(
            &["torus", "rule", "flips"],
            &["spread of areas", "mean distance", "largest"],
        ),
        lines,
    );
    add_claims(item, &tori);
    let list: Vec<String> = energies
        .iter()
        .zip(SIZES)
        .map(|([before, after], [rings, sides])| {
            format!("from {before:.1} to {after:.1} on {rings} x {sides} points")
        })
        .collect();
    item.claim(
        "W is minimised",
        lowered(&energies),
        format!("flips by the virtual energy take W {}", list.join(" and ")),
    );
    add_circles(item)
}

/// Measures a mesh and adds its numbers to the item; returns a line for the table.
fn line(item: &mut Item, torus: &str, rule: &str, mesh: &TriMesh, flips: u64) -> Vec<String> {
    let of = format!("{torus}, {rule}");
    let measures = Measures::of(mesh);
    measures.add(item, &of);
    let error = distance(mesh);
    let spread = spread_of_areas(mesh);
    item.number(format!("{of}, flips"), flips as f64);
    item.number(format!("{of}, spread of areas"), spread);
    item.number(format!("{of}, mean distance"), error.mean);
    item.number(format!("{of}, largest distance"), error.max);
    let mut line = vec![torus.to_owned(), rule.to_owned(), flips.to_string()];
    line.extend(measures.cells());
    line.extend([spread, error.mean, error.max].map(|x| format!("{x:.4}")));
    line
}

fn distance(mesh: &TriMesh) -> LatticeError {
    lattice_error(mesh, SUBDIVISIONS, |p| TORUS.signed_distance(p))
}

/// How unequal the triangles are: standard deviation over mean of the areas.
fn spread_of_areas(mesh: &TriMesh) -> f64 {
    let areas: Vec<f64> = mesh.topology().faces().map(|face| mesh.face_area(face)).collect();
    let count = areas.len().max(1) as f64;
    let mean = areas.iter().sum::<f64>() / count;
    let variance = areas.iter().map(|a| (a - mean).powi(2)).sum::<f64>() / count;
    variance.sqrt() / mean
}

fn picture(run: &Run<'_>, mesh: &TriMesh, torus: &str, rule: &str) -> Result<Figure, Failure> {
    let view = view_of(mesh, DVec3::new(0.0, -0.75, 1.0), DVec3::Y)?;
    let style = Style { size: [640, 540], edge_width: 1.5, ..Style::DEFAULT };
    let name = format!("bar06-torus-{torus}-{rule}").replace(' ', "-").to_lowercase();
    run.picture(mesh, &view, &style, &name, &format!("{torus} points, {rule}"))
}

/// The printed rule over random orders of flips with the same gain.
struct ByOrder {
    torus: String,
    /// Spread of the areas, mean and largest distance: before, and the range of each after.
    before: [f64; 3],
    least: [f64; 3],
    most: [f64; 3],
}

impl ByOrder {
    const NAMES: [&str; 3] = ["spread of areas", "mean distance", "largest distance"];

    fn of(item: &mut Item, torus: String, initial: &TriMesh) -> Result<Self, Failure> {
        let measure = |mesh: &TriMesh| {
            let error = distance(mesh);
            [spread_of_areas(mesh), error.mean, error.max]
        };
        let (mut least, mut most) = ([f64::INFINITY; 3], [0.0; 3]);
        let orders = [Ties::EdgeId].into_iter().chain((1..ORDERS).map(Ties::Seeded));
        for ties in orders {
            let mut mesh = initial.clone();
            let options = FlipOptions { ties, ..FlipOptions::default() };
            optimise(&mut mesh, CostName::Willmore, VertexArea::Voronoi, &options)?;
            let values = measure(&mesh);
            least = core::array::from_fn(|i| values[i].min(least[i]));
            most = core::array::from_fn(|i| values[i].max(most[i]));
        }
        for (i, name) in Self::NAMES.iter().enumerate() {
            item.number(format!("{torus}, as printed, least {name} of {ORDERS} orders"), least[i]);
            item.number(format!("{torus}, as printed, most {name} of {ORDERS} orders"), most[i]);
        }
        Ok(Self { torus, before: measure(initial), least, most })
    }

    /// Whether a measure falls, for all orders, some, or none.
    fn falls(&self, measure: usize) -> Outcome {
        match (
            self.least[measure] < self.before[measure],
            self.most[measure] < self.before[measure],
        ) {
            (_, true) => Outcome::Holds,
            (true, false) => Outcome::InPart,
            (false, false) => Outcome::Fails,
        }
    }

    fn text(&self, measure: usize) -> String {
        format!(
            "{:.3} before, {:.3} to {:.3} after",
            self.before[measure], self.least[measure], self.most[measure]
        )
    }
}

fn add_claims(item: &mut Item, tori: &[ByOrder]) {
    let all = |measures: &[usize]| {
        let outcomes = tori.iter().flat_map(|torus| measures.iter().map(|&m| torus.falls(m)));
        outcomes.reduce(|a, b| if a == b { a } else { Outcome::InPart }).unwrap_or(Outcome::Fails)
    };
    let list = |line: &dyn Fn(&ByOrder) -> String| {
        let lines: Vec<String> =
            tori.iter().map(|t| format!("{} points: {}", t.torus, line(t))).collect();
        lines.join("; ")
    };
    item.claim(
        "more regular",
        all(&[0]),
        format!(
            "spread of the areas, over {ORDERS} orders of equal gains: {}",
            list(&|t| t.text(0))
        ),
    );
    item.claim(
        "smoother",
        all(&[1, 2]),
        format!(
            "distance to the torus, over {ORDERS} orders of equal gains: {}",
            list(&|t| format!("mean {}, largest {}", t.text(1), t.text(2)))
        ),
    );
}

/// Whether an energy falls from before to after: always, sometimes, or never.
fn lowered(energies: &[[f64; 2]]) -> Outcome {
    let count = energies.iter().filter(|[before, after]| after < before).count();
    match count {
        0 => Outcome::Fails,
        n if n == energies.len() => Outcome::Holds,
        _ => Outcome::InPart,
    }
}

/// Whether runs end by themselves, from scrambled tori without the half step.
fn add_circles(item: &mut Item) -> Result<(), Failure> {
    let mut circles = 0;
    for seed in 0..STARTS {
        let mut mesh = mesh_of(&TORUS.mesh(18, 9).map_err(Failure::mesh)?)?;
        scramble(&mut mesh, SCRAMBLES, &mut SplitMix64::new(seed), |_, _| true);
        let report =
            optimise(&mut mesh, CostName::Willmore, VertexArea::Voronoi, &FlipOptions::default())?;
        circles += u32::from(report.stop == Stop::CycleGuard);
    }
    item.number(format!("runs of {STARTS} that go in circles"), f64::from(circles));
    item.claim(
        "each edge flips once",
        Outcome::of(circles == 0),
        format!(
            "the reduction is not the difference of one energy: from a torus of 18 x 9 points, without \
             the half step and after {SCRAMBLES} random flips, {circles} of {STARTS} runs go in \
             circles and end only because here no edge may flip more than eight times"
        ),
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_energy_that_rises_turns_the_verdict() {
        assert_eq!(lowered(&[[2.0, 1.0], [3.0, 2.0]]), Outcome::Holds);
        assert_eq!(lowered(&[[1.0, 2.0], [3.0, 2.0]]), Outcome::InPart);
        assert_eq!(lowered(&[[1.0, 2.0]]), Outcome::Fails);
    }

    /// The printed rule raises W on the torus of 12 x 6 points; flips by W itself lower it.
    #[test]
    fn another_rule_turns_the_verdict() {
        let initial = mesh_of(&TORUS.shifted_mesh(12, 6).unwrap()).unwrap();
        let energies = |rule: usize| {
            let mut mesh = initial.clone();
            RULES[rule].optimise(&mut mesh).unwrap();
            [[&initial, &mesh].map(total_willmore_energy)]
        };
        assert_eq!(lowered(&energies(0)), Outcome::Fails);
        assert_eq!(lowered(&energies(2)), Outcome::Holds);
    }

    #[test]
    fn measures_that_rise_turn_the_verdict() {
        let torus = |before: f64| ByOrder {
            torus: String::new(),
            before: [before; 3],
            least: [1.0; 3],
            most: [2.0; 3],
        };
        assert_eq!(torus(3.0).falls(0), Outcome::Holds);
        assert_eq!(torus(1.5).falls(0), Outcome::InPart);
        assert_eq!(torus(0.5).falls(0), Outcome::Fails);
    }
}
