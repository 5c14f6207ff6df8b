//! The paper's look-ahead strategy (sec. 3) on the torus of Table 1.

use std::path::Path;

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions};

use super::super::item::{Item, Row};
use super::super::published::Paper;
use super::{SUBDIVISIONS, distance_to_torus, norms, optimise, paper_torus};
use crate::failure::Failure;

pub(super) const NAME: &str = "Look-ahead on the torus";

/// The costs and errors where single flips end, and where pairs of flips end.
pub(super) fn item(paper: &Paper, _: &Path) -> Result<Item, Failure> {
    let mut rows = Vec::new();
    for (name, cost) in [("F1", CostName::F1), ("F2", CostName::F2)] {
        for look_ahead in [1, 2] {
            let mut mesh = paper_torus()?;
            let options = FlipOptions { look_ahead, ..FlipOptions::default() };
            let report = optimise(&mut mesh, cost, VertexArea::Voronoi, &options)?;
            let mut row = |quantity: &str, value| {
                let quantity = format!("{name}, depth {look_ahead}, {quantity}");
                rows.push(Row::new(paper, NAME, &quantity, value));
            };
            row("cost", report.cost_after);
            for (norm, value) in norms(&distance_to_torus(&mesh, SUBDIVISIONS)) {
                row(norm, value);
            }
        }
    }
    Ok(Item {
        paper: paper.short.clone(),
        name: NAME.into(),
        about:
            "The cost that is left, and the distance to the torus, after single flips (depth 1) \
                and with pairs of flips where no single one helps (depth 2). The paper describes \
                the strategy and prints no numbers. A lower cost need not be nearer to the torus. \
                Ties are broken by edge number, so F1 at depth 1 ends in the other of the two \
                minima of Table 1."
                .into(),
        needs: None,
        rows,
        figures: Vec::new(),
        functions: vec!["dtri_flip::optimise", "dtri_flip::lattice_error"],
        command: "curvmesh flip IN -o OUT --cost f2 --look-ahead 2",
    })
}
