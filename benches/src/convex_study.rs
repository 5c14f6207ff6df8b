//! `cargo run -p benches -- convex-study`: how often edge flips find a scrambled convex hull again.
//!
//! DHKL01, sec. 4: for convex data, "in almost all cases" every cost leads to the convex triangulation, from any
//! initial one. Here the initial triangulation is the hull after a number of random flips.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

use clap::ValueEnum;
use dcurv::VertexArea;
use dtri_flip::{Anneal, CostName, FlipOptions, Quad, Rebuild, ShapeConstraint};
use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::{EdgeId, PolygonSoup, Repair, TriMesh, build};
use mesh_shapes::{Ellipsoid, ShapeError, Sphere, scramble};
use rayon::prelude::*;

use xtask_common::{Failure, Numbers, progress_bar};

/// What to run, and how often.
#[derive(Debug, clap::Args)]
pub struct ConvexStudy {
    /// How many starts per case
    #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// How many points, on the sphere and on the ellipsoid
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "60,200")]
    points: Vec<usize>,
    /// Which strategies; all of them by default
    #[arg(long, value_name = "STRATEGY", value_delimiter = ',')]
    strategies: Vec<Strategy>,
    /// Which costs
    #[arg(
        long, value_name = "COST", value_delimiter = ',', default_value = "f1,f2,f3,gauss-extrinsic",
        value_parser = parse_cost,
    )]
    costs: Vec<CostName>,
    /// Which flips scramble the hull
    #[arg(long, value_name = "KIND", value_delimiter = ',', default_value = "free,embedded")]
    scrambles: Vec<Scramble>,
    /// How many random flips
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "20,60,150,600")]
    flips: Vec<usize>,
    /// Six starts per case and 60 points only
    #[arg(long, conflicts_with_all = ["seeds", "points"])]
    quick: bool,
    /// The folder for the table (convex-study.txt) and the numbers (convex-study.csv). What is in the
    /// numbers already is not computed again
    #[arg(long, value_name = "DIR", default_value = "target/convex-study")]
    out: PathBuf,
}

/// How the optimisation gets out of local minima.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Strategy {
    /// The flip with the largest gain, until none is left.
    Greedy,
    /// Sequences of up to two flips.
    #[value(name = "look-ahead-2")]
    LookAhead2,
    /// Sequences of up to three flips.
    #[value(name = "look-ahead-3")]
    LookAhead3,
    /// Simulated annealing.
    Anneal,
    /// Simulated annealing, then sequences of up to three flips.
    #[value(name = "anneal-look-ahead-3")]
    AnnealLookAhead3,
    /// Local rebuilding of the triangulation.
    Rebuild,
}

/// The surface that the points lie on.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Of radius 1.
    Sphere,
    /// With half axes 3, 2 and 1.
    Ellipsoid,
}

/// Which flips scramble the hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scramble {
    /// Every legal one, also those that make the surface cross itself.
    Free,
    /// Those that keep the surface without overlaps, seen from the centre.
    Embedded,
}

/// One of [`COSTS`], or the cost of Alboul and van Damme.
fn parse_cost(text: &str) -> Result<CostName, String> {
    let mut known = COSTS.into_iter().chain([CostName::GaussExtrinsic]);
    let found = known.find(|cost| cost.as_str() == text);
    found.ok_or_else(|| "expected f1, f2, f3 or gauss-extrinsic".into())
}

/// The costs of DHKL01.
pub const COSTS: [CostName; 3] = [CostName::F1, CostName::F2, CostName::F3];
/// How many random flips.
pub const FLIPS: [usize; 4] = [20, 60, 150, 600];
/// First seed of the scrambles, separate from the seeds of the points.
const SCRAMBLE_SEED: u64 = 1000;

const HEADER: [&str; 9] =
    ["points", "shape", "strategy", "cost", "scramble", "flips", "runs", "hull", "seconds"];

/// Runs the cases that are missing in the file of numbers, and prints the table.
pub fn run(options: &ConvexStudy) -> Result<(), Failure> {
    std::fs::create_dir_all(&options.out).map_err(Failure::writing(&options.out))?;
    let path = options.out.join("convex-study.csv");
    let (mut numbers, known) = Numbers::open(path, &HEADER, known_case)?;
    let mut table = Table::new(&options.columns());
    let cases = options.cases();
    let bar = progress_bar(cases.len());
    for case in cases {
        bar.set_message(case.to_string());
        let names = case.names(options.seeds());
        let hulls = match known.iter().find(|(known, _)| *known == names) {
            Some((_, hulls)) => *hulls,
            None => {
                let ends = case.ends(options.seeds())?;
                numbers.add(&case.record(options.seeds(), &ends))?;
                ends.at_hull
            }
        };
        table.add(&case, hulls as f64 / options.seeds() as f64);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let text = table.finish(options.seeds());
    let path = options.out.join("convex-study.txt");
    std::fs::write(&path, &text).map_err(Failure::writing(&path))?;
    print!("{text}");
    Ok(())
}

/// The names of a case and the number of its runs that end at the hull.
fn known_case(record: &csv::StringRecord) -> Option<(Vec<String>, usize)> {
    let names = record.iter().take(7).map(str::to_owned).collect();
    Some((names, record.get(7)?.parse().ok()?))
}

impl ConvexStudy {
    fn seeds(&self) -> u64 {
        if self.quick { 6 } else { self.seeds }
    }

    /// The columns of the table.
    fn columns(&self) -> Vec<(Scramble, usize)> {
        let of = |&scramble| self.flips.iter().map(move |&flips| (scramble, flips));
        self.scrambles.iter().flat_map(of).collect()
    }

    /// All cases, ordered by lines of the table.
    fn cases(&self) -> Vec<Case> {
        let points = if self.quick { &[60][..] } else { &self.points[..] };
        let columns = self.columns();
        let strategies = match &self.strategies[..] {
            [] => Strategy::value_variants(),
            some => some,
        };
        let mut cases = Vec::new();
        for &points in points {
            for shape in [Shape::Sphere, Shape::Ellipsoid] {
                for &strategy in strategies {
                    for &cost in &self.costs {
                        let case = |&(scramble, flips)| Case {
                            points,
                            shape,
                            strategy,
                            cost,
                            scramble,
                            flips,
                        };
                        cases.extend(columns.iter().map(case));
                    }
                }
            }
        }
        cases
    }
}

/// One number of the study.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Number of points.
    pub points: usize,
    /// The surface that they lie on.
    pub shape: Shape,
    /// How the optimisation leaves local minima.
    pub strategy: Strategy,
    /// The cost that the flips lower.
    pub cost: CostName,
    /// Which random flips make the start.
    pub scramble: Scramble,
    /// How many random flips.
    pub flips: usize,
}

/// Counts of the final states of runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ends {
    /// At the hull.
    pub at_hull: usize,
    /// At a lower cost than the hull.
    pub below_hull: usize,
    /// Total time, in seconds.
    pub seconds: f64,
}

impl Case {
    /// Counts the final states of the runs.
    pub fn ends(&self, seeds: u64) -> Result<Ends, Failure> {
        let add = |a: Ends, b: Ends| Ends {
            at_hull: a.at_hull + b.at_hull,
            below_hull: a.below_hull + b.below_hull,
            seconds: a.seconds + b.seconds,
        };
        let runs = (0..seeds).into_par_iter().map(|seed| self.end(seed));
        runs.try_reduce(Ends::default, |a, b| Ok(add(a, b)))
    }

    fn end(&self, seed: u64) -> Result<Ends, Failure> {
        let soup = self.shape.random_hull(self.points, seed).map_err(Failure::mesh)?;
        let mut mesh = build(&soup, &Repair::strict()).map_err(Failure::mesh)?.mesh;
        let hull = mesh.topology().canonical_triangles();
        let cost_of_hull = self.cost.total(&mesh, VertexArea::Voronoi);
        let random = &mut SplitMix64::new(SCRAMBLE_SEED.wrapping_add(seed));
        scramble(&mut mesh, self.flips, random, |mesh, edge| self.scramble.allows(mesh, edge));
        let go_on = &mut |_| ControlFlow::Continue(());
        let start = Instant::now();
        let report = self
            .cost
            .optimise(&mut mesh, VertexArea::Voronoi, &self.strategy.options(), go_on)
            .map_err(Failure::mesh)?;
        let seconds = start.elapsed().as_secs_f64();
        let at_hull = mesh.topology().canonical_triangles() == hull;
        let below_hull = !at_hull && report.cost_after < cost_of_hull * (1.0 - 1e-9);
        let [at_hull, below_hull] = [at_hull, below_hull].map(usize::from);
        Ok(Ends { at_hull, below_hull, seconds })
    }

    /// The key of the case in the file of numbers.
    fn names(&self, seeds: u64) -> Vec<String> {
        let column = [self.scramble.name().to_owned(), self.flips.to_string(), seeds.to_string()];
        self.line().into_iter().chain(column).collect()
    }

    /// The record of a case, with the mean time of a run.
    fn record(&self, seeds: u64, ends: &Ends) -> Vec<String> {
        let mut record = self.names(seeds);
        record.push(ends.at_hull.to_string());
        record.push(format!("{:.3}", ends.seconds / seeds as f64));
        record
    }

    /// The label of the line in the table.
    fn line(&self) -> [String; 4] {
        [
            self.points.to_string(),
            self.shape.name().to_owned(),
            self.strategy.to_string(),
            self.cost.to_string(),
        ]
    }
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.line().join(", "))
    }
}

impl Strategy {
    fn options(self) -> FlipOptions {
        let rebuild = (self == Self::Rebuild).then(Rebuild::default);
        let (look_ahead, anneal) = match self {
            Self::Greedy | Self::Rebuild => (1, None),
            Self::LookAhead2 => (2, None),
            Self::LookAhead3 => (3, None),
            Self::Anneal => (1, Some(Anneal::default())),
            Self::AnnealLookAhead3 => (3, Some(Anneal::default())),
        };
        // As in the papers: no constraint.
        let shape = Some(ShapeConstraint::Unrestricted);
        FlipOptions { look_ahead, anneal, rebuild, shape, ..FlipOptions::default() }
    }
}

impl std::fmt::Display for Strategy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Greedy => "greedy",
            Self::LookAhead2 => "look-ahead 2",
            Self::LookAhead3 => "look-ahead 3",
            Self::Anneal => "anneal",
            Self::AnnealLookAhead3 => "anneal + look-ahead 3",
            Self::Rebuild => "rebuild",
        })
    }
}

impl Shape {
    fn random_hull(self, points: usize, seed: u64) -> Result<PolygonSoup, ShapeError> {
        match self {
            Self::Sphere => Sphere { radius: 1.0 }.random_hull(points, seed),
            Self::Ellipsoid => {
                Ellipsoid { semi_axes: DVec3::new(3.0, 2.0, 1.0) }.random_hull(points, seed)
            }
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Ellipsoid => "ellipsoid",
        }
    }
}

impl Scramble {
    fn allows(self, mesh: &TriMesh, edge: EdgeId) -> bool {
        match self {
            Self::Free => true,
            Self::Embedded => stays_embedded(mesh, edge),
        }
    }

    /// The name in the table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Embedded => "embedded",
        }
    }
}

/// Whether a surface around the origin still has no overlaps after a flip, seen from there: the new triangles face
/// outward.
fn stays_embedded(mesh: &TriMesh, edge: EdgeId) -> bool {
    Quad::around(mesh.topology(), edge).is_some_and(|quad| {
        quad.flipped_triangles().iter().all(|triangle| {
            let [a, b, c] = triangle.map(|v| mesh.position(v));
            a.dot(b.cross(c)) > 0.0
        })
    })
}

/// The shares in percent: a line per points, shape, strategy and cost, a column per scramble.
struct Table {
    columns: Vec<String>,
    lines: Vec<Vec<String>>,
}

impl Table {
    fn new(columns: &[(Scramble, usize)]) -> Self {
        let name = |(scramble, flips): &(Scramble, usize)| format!("{} {flips}", scramble.name());
        Self { columns: columns.iter().map(name).collect(), lines: Vec::new() }
    }

    /// Adds to the last line if the case belongs there.
    fn add(&mut self, case: &Case, share: f64) {
        let name = case.line();
        if self.lines.last().is_none_or(|line| line[..name.len()] != name) {
            self.lines.push(name.to_vec());
        }
        if let Some(line) = self.lines.last_mut() {
            line.push(format!("{:.0}", 100.0 * share));
        }
    }

    fn finish(self, seeds: u64) -> String {
        let mut table = comfy_table::Table::new();
        table.load_preset(comfy_table::presets::UTF8_HORIZONTAL_ONLY);
        let names = ["points", "shape", "strategy", "cost"].map(str::to_owned);
        table.set_header(names.into_iter().chain(self.columns));
        table.add_rows(self.lines);
        format!(
            "Runs that end at the convex hull, in percent of {seeds}, by the number of random \
             flips\n{table}\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{COSTS, Case, ConvexStudy, FLIPS, Scramble, Shape, Strategy};
    use dtri_flip::CostName;

    fn case(scramble: Scramble, flips: usize) -> Case {
        let (shape, strategy, cost) = (Shape::Sphere, Strategy::Greedy, CostName::F2);
        Case { points: 60, shape, strategy, cost, scramble, flips }
    }

    #[test]
    fn greedy_finds_the_hull_after_few_flips_and_not_after_many_free_ones() {
        assert!(case(Scramble::Free, 20).ends(50).unwrap().at_hull >= 45);
        assert!(case(Scramble::Free, 150).ends(50).unwrap().at_hull <= 5);
        assert!(case(Scramble::Embedded, 60).ends(50).unwrap().at_hull >= 45);
    }

    #[test]
    fn a_hull_of_too_few_points_is_an_error() {
        let case = Case { points: 3, ..case(Scramble::Free, 20) };
        assert!(case.ends(1).unwrap_err().to_string().contains("points"));
    }

    #[test]
    fn quick_runs_every_strategy_on_sixty_points() {
        let study = ConvexStudy {
            seeds: 50,
            points: vec![60, 200],
            strategies: Vec::new(),
            costs: COSTS.to_vec(),
            scrambles: vec![Scramble::Free, Scramble::Embedded],
            flips: FLIPS.to_vec(),
            quick: true,
            out: "unused".into(),
        };
        assert_eq!(study.seeds(), 6);
        assert_eq!(study.cases().len(), 2 * 6 * COSTS.len() * 2 * FLIPS.len());
        assert!(study.cases().iter().all(|case| case.points == 60));
    }
}
