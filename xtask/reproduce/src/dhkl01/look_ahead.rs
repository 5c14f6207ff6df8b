//! The paper's look-ahead strategy (sec. 3) on the torus of Table 1.

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions};

use super::super::flips::optimise;
use super::super::item::Item;
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
        &["curvmesh flip IN -o OUT --cost f2 --look-ahead 2"],
    );
    let mut lines = Vec::new();
    for (name, cost) in [("F1", CostName::F1), ("F2", CostName::F2), ("F3", CostName::F3)] {
        for look_ahead in [1, 2] {
            let mut mesh = paper_mesh(&TORUS)?;
            let options = FlipOptions { look_ahead, ..FlipOptions::default() };
            let report = optimise(&mut mesh, cost, VertexArea::Voronoi, &options)?;
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
    let header = ["minimised", "depth", "flips", "cost left", "L1", "L2", "Linf"];
    item.table("Distances in units of the model; the tube's radius is 2.", header, lines);
    Ok(())
}
