//! Sec. 4: convex data, from scrambled hulls.

use dtri_flip::CostName;

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::Run;
use benches::convex_study::{COSTS, Case, FLIPS, Scramble, Shape, Strategy};
use xtask_common::Failure;

/// The full study, which takes long; see its first lines.
const STUDY: &str = include_str!("../../../../benches/recorded/convex-study.csv");
/// Starts per case of the small one.
const SEEDS: u64 = 6;
const POINTS: usize = 60;
/// "Almost all."
const ALMOST_ALL: f64 = 0.9;

pub(super) fn compute(_: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Random points on a sphere or an ellipsoid. The start is the convex triangulation after some \
         random legal flips, either any (free) or only those that keep the surface without overlaps \
         (embedded); the question is whether flips find back to it. A small study is run here, with \
         6 starts per case and 60 points on the sphere; the table of the full one is on record.",
    );
    item.how(
        &["dtri_flip::optimise", "mesh_shapes::scramble"],
        &[
            "curvmesh flip IN -o OUT --cost f2 --shape-constraint unrestricted --look-ahead 3",
            "cargo run -p benches -- convex-study",
        ],
    );
    let live = Live::run(item)?;
    item.table(
        format!("Now: runs of {SEEDS} that end at the hull, by kind (free or embedded) and number of random flips."),
        header(["strategy", "cost"]),
        live.lines,
    );
    let (runs, lines) = recorded_lines()?;
    item.table(
        format!("On record: share of {runs} runs that end at the hull, by kind (free or embedded) and number of random flips."),
        header(["points", "surface", "strategy", "cost"]),
        lines,
    );
    let share = |[hulls, runs]: [usize; 2]| hulls as f64 / runs.max(1) as f64;
    let greedy = share(live.greedy);
    let gentle = share(live.greedy_gentle);
    let outcome = match (greedy > ALMOST_ALL, gentle > ALMOST_ALL) {
        (true, _) => Outcome::Holds,
        (false, true) => Outcome::InPart,
        (false, false) => Outcome::Fails,
    };
    item.claim(
        "convex data",
        outcome,
        format!(
            "greedy flips end at the hull in {:.0} % of all runs; in {:.0} % of those by F2 and F3 \
             whose start is embedded and at most 60 flips away; in {:.0} % of those by F1, and in {:.0} % of \
             those from 150 free flips on. Looking three flips ahead, F2 and F3 get there in {:.0} % of the runs \
             with embedded starts",
            100.0 * greedy,
            100.0 * gentle,
            100.0 * share(live.greedy_f1),
            100.0 * share(live.greedy_wild),
            100.0 * share(live.ahead_embedded)
        ),
    );
    item.claim(
        "global optimum",
        Outcome::of(live.below_hull == 0),
        format!(
            "of {} runs by F2 and F3 {} end below the cost of the hull; of those by F1, {} do",
            live.runs_f2_f3, live.below_hull, live.below_hull_f1
        ),
    );
    let [embedded, free] = live.extrinsic;
    item.claim(
        "Alboul and van Damme",
        always_converges([embedded, free]),
        format!(
            "greedy flips by their curvature, K+ + K-, end at the hull in {:.0} % of the runs with embedded starts, \
             and in {:.0} % of those with free starts, whose surface crosses itself",
            100.0 * share(embedded),
            100.0 * share(free)
        ),
    );
    Ok(())
}

/// Whether all runs end at the hull: from any start, or from embedded starts only.
fn always_converges(ends: [[usize; 2]; 2]) -> Outcome {
    match ends.map(|[hulls, runs]| hulls == runs) {
        [true, true] => Outcome::Holds,
        [true, false] => Outcome::InPart,
        [false, _] => Outcome::Fails,
    }
}

/// The small study.
#[derive(Default)]
struct Live {
    lines: Vec<Vec<String>>,
    /// Hulls and runs: all greedy ones; those by F2 and F3 from embedded starts up to 60 flips away; those by
    /// F1; those from 150 free flips on; those by F2 and F3 with look-ahead from embedded starts.
    greedy: [usize; 2],
    greedy_gentle: [usize; 2],
    greedy_f1: [usize; 2],
    greedy_wild: [usize; 2],
    ahead_embedded: [usize; 2],
    /// Runs by F2 and F3, and how many of them end below the cost of the hull; the same for F1.
    runs_f2_f3: usize,
    below_hull: usize,
    below_hull_f1: usize,
    /// Hulls and runs by the cost of Alboul and van Damme, from embedded and from free starts.
    extrinsic: [[usize; 2]; 2],
}

impl Live {
    fn run(item: &mut Item) -> Result<Self, Failure> {
        let mut live = Self::default();
        // Look-ahead by the cost of Alboul and van Damme takes minutes: it is on record only.
        let extrinsic = (Strategy::Greedy, CostName::GaussExtrinsic);
        for strategy in [Strategy::Greedy, Strategy::LookAhead3] {
            let costs = COSTS.into_iter().chain([extrinsic.1]);
            for cost in costs.filter(|&cost| cost != extrinsic.1 || strategy == extrinsic.0) {
                let mut line = vec![strategy.to_string(), cost.to_string()];
                for scramble in [Scramble::Free, Scramble::Embedded] {
                    for flips in FLIPS {
                        let (points, shape) = (POINTS, Shape::Sphere);
                        let case = Case { points, shape, strategy, cost, scramble, flips };
                        let hulls = live.add(&case)?;
                        let of = format!("{strategy}, {cost}, {} {flips}", scramble.name());
                        item.number(
                            format!("{of}, runs of {SEEDS} that end at the hull"),
                            hulls as f64,
                        );
                        line.push(hulls.to_string());
                    }
                }
                live.lines.push(line);
            }
        }
        Ok(live)
    }

    fn add(&mut self, case: &Case) -> Result<usize, Failure> {
        let ends = case.ends(SEEDS)?;
        let is_embedded = matches!(case.scramble, Scramble::Embedded);
        if case.cost == CostName::GaussExtrinsic {
            let [hulls, runs] = &mut self.extrinsic[usize::from(!is_embedded)];
            *hulls += ends.at_hull;
            *runs += SEEDS as usize;
            return Ok(ends.at_hull);
        }
        let is_f1 = case.cost == CostName::F1;
        let mut count = |tally: fn(&mut Self) -> &mut [usize; 2]| {
            let [hulls, runs] = tally(self);
            *hulls += ends.at_hull;
            *runs += SEEDS as usize;
        };
        match case.strategy {
            Strategy::Greedy => {
                count(|live| &mut live.greedy);
                if is_embedded && !is_f1 && case.flips <= 60 {
                    count(|live| &mut live.greedy_gentle);
                }
                if is_f1 {
                    count(|live| &mut live.greedy_f1);
                }
                if !is_embedded && case.flips >= 150 {
                    count(|live| &mut live.greedy_wild);
                }
            }
            _ if is_embedded && !is_f1 => count(|live| &mut live.ahead_embedded),
            _ => {}
        }
        if is_f1 {
            self.below_hull_f1 += ends.below_hull;
        } else {
            self.runs_f2_f3 += SEEDS as usize;
            self.below_hull += ends.below_hull;
        }
        Ok(ends.at_hull)
    }
}

/// Names of a line, then the columns of the random flips.
fn header<const N: usize>(names: [&str; N]) -> Vec<String> {
    let scrambles = [Scramble::Free, Scramble::Embedded];
    let columns = scrambles
        .iter()
        .flat_map(|scramble| FLIPS.map(|flips| format!("{} {flips}", short_name(*scramble))));
    names.map(str::to_owned).into_iter().chain(columns).collect()
}

/// The name at the head of a column, which is to be narrow.
fn short_name(scramble: Scramble) -> &'static str {
    match scramble {
        Scramble::Free => "free",
        Scramble::Embedded => "emb.",
    }
}

/// The full study: how many runs per case, and a line per points, surface, strategy and cost. Cells of
/// cases that were not run are empty.
fn recorded_lines() -> Result<(usize, Vec<Vec<String>>), Failure> {
    const NAMES: [&str; 4] = ["points", "surface", "strategy", "cost"];
    let columns = header(NAMES);
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(STUDY.as_bytes());
    let mut most_runs = 0;
    let mut lines: Vec<Vec<String>> = Vec::new();
    for record in reader.deserialize() {
        type Record = (String, String, String, String, String, usize, usize, usize, Option<f64>);
        let (points, shape, strategy, cost, scramble, flips, runs, hulls, _): Record =
            record.map_err(Failure::numbers)?;
        let column = format!("{} {flips}", if scramble == "free" { "free" } else { "emb." });
        let Some(column) = columns.iter().position(|name| *name == column) else { continue };
        let names = [points, shape, strategy, cost];
        let at = lines.iter().position(|line| line[..4] == names).unwrap_or(lines.len());
        if at == lines.len() {
            let empty = vec![String::new(); columns.len() - names.len()];
            lines.push(names.into_iter().chain(empty).collect());
        }
        lines[at][column] = format!("{:.0} %", 100.0 * hulls as f64 / runs.max(1) as f64);
        most_runs = most_runs.max(runs);
    }
    Ok((most_runs, lines))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_run_that_is_stuck_turns_the_verdict() {
        assert_eq!(always_converges([[6, 6], [6, 6]]), Outcome::Holds);
        assert_eq!(always_converges([[6, 6], [5, 6]]), Outcome::InPart);
        assert_eq!(always_converges([[5, 6], [6, 6]]), Outcome::Fails);
    }

    #[test]
    fn the_recorded_table_is_complete() {
        let (runs, lines) = recorded_lines().unwrap();
        assert!(runs >= 50 && !lines.is_empty());
        let columns = header(["points", "surface", "strategy", "cost"]).len();
        assert!(lines.iter().all(|line| line.len() == columns));
    }
}
