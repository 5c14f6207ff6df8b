//! The paper's look-ahead strategy (sec. 3) on the torus of Table 1.

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions};

use super::super::flips::optimise;
use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::Run;
use super::torus::{SUBDIVISIONS, TORUS, distance_to_torus, norms, paper_mesh};
use xtask_common::Failure;

/// The costs and errors where single flips end, and where pairs of flips end.
pub(super) fn compute(_: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "The cost that is left, and the distance to the torus, after single flips (depth 1) and \
         with pairs of flips where no single one helps (depth 2). The paper describes the strategy \
         and prints no numbers. A lower cost need not be nearer to the torus. Ties are broken by \
         edge number, so F1 at depth 1 ends in the other of the two minima of Table 1.",
    );
    item.how(
        &["dtri_flip::optimise", "dtri_flip::lattice_error"],
        &["curvmesh flip IN -o OUT --cost f2 --shape-constraint unrestricted --look-ahead 2"],
    );
    let mut lines = Vec::new();
    let mut costs = Vec::new();
    for (name, cost) in [("F1", CostName::F1), ("F2", CostName::F2), ("F3", CostName::F3)] {
        for look_ahead in [1, 2] {
            let mut mesh = paper_mesh(&TORUS)?;
            let options = FlipOptions { look_ahead, ..FlipOptions::default() };
            let report = optimise(&mut mesh, cost, VertexArea::Voronoi, &options)?;
            costs.push(report.cost_after);
            let error = distance_to_torus(&mesh, SUBDIVISIONS);
            let mut line = vec![name.to_owned(), look_ahead.to_string(), report.flips.to_string()];
            let values = [("cost", report.cost_after)].into_iter().chain(norms(&error));
            for (quantity, value) in values {
                item.number(format!("{name}, depth {look_ahead}, {quantity}"), value);
                line.push(format!("{value:.6}"));
            }
            lines.push(line);
        }
    }
    let pairs: Vec<[f64; 2]> = costs.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
    item.claim(
        "same or better minimum",
        same_or_better(&pairs),
        format!(
            "on this torus the cost left by pairs of flips over that by single flips is {} for F1, F2 and F3; the two runs \
             take different paths, so that nothing guarantees it",
            pairs.iter().map(|[one, two]| format!("{:.4}", two / one)).collect::<Vec<_>>().join(", ")
        ),
    );
    let header = ["minimised", "depth", "flips", "cost left", "L1", "L2", "Linf"];
    item.table("Distances in units of the model; the tube's radius is 2.", header, lines);
    Ok(())
}

/// Whether pairs of flips leave at most the cost of single flips: always, sometimes, or never.
fn same_or_better(costs: &[[f64; 2]]) -> Outcome {
    let count = costs.iter().filter(|[one, two]| *two <= one * (1.0 + 1e-12)).count();
    match count {
        0 => Outcome::Fails,
        n if n == costs.len() => Outcome::Holds,
        _ => Outcome::InPart,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_higher_cost_turns_the_verdict() {
        assert_eq!(same_or_better(&[[2.0, 1.0], [3.0, 3.0]]), Outcome::Holds);
        assert_eq!(same_or_better(&[[1.0, 2.0], [3.0, 3.0]]), Outcome::InPart);
        assert_eq!(same_or_better(&[[1.0, 2.0]]), Outcome::Fails);
    }
}
