//! Fig. 4: seven points in convex position, where single flips and pairs of them get stuck.

use std::path::Path;

use dcurv::VertexArea;
use dtri_flip::{Anneal, CostName, FlipOptions};
use glam::DVec3;
use mesh_core::shapes::seven_points;

use super::super::item::{Item, Row};
use super::super::published::Paper;
use super::{bounds, mesh_of, optimise, picture};
use crate::failure::Failure;
use crate::render::{Style, View};

pub(super) const NAME: &str = "Fig. 4";

/// The costs of both triangulations, and where every strategy ends that starts from the given one.
pub(super) fn item(paper: &Paper, out: &Path) -> Result<Item, Failure> {
    let [given, convex] = [mesh_of(&seven_points::given())?, mesh_of(&seven_points::convex())?];
    let mut rows = Vec::new();
    for (name, cost) in [("F1", CostName::F1), ("F2", CostName::F2), ("F3", CostName::F3)] {
        let mut row = |quantity: &str, value| {
            rows.push(Row::new(paper, NAME, &format!("{name}, {quantity}"), value));
        };
        row("given triangulation", cost.total(&given, VertexArea::Voronoi));
        row("convex triangulation", cost.total(&convex, VertexArea::Voronoi));
        for (strategy, options) in strategies() {
            let mut mesh = given.clone();
            let report = optimise(&mut mesh, cost, VertexArea::Voronoi, &options)?;
            row(&format!("{strategy} ends at"), report.cost_after);
        }
    }
    let view = View {
        toward: DVec3::new(0.25, -0.7, 1.0),
        up: DVec3::new(0.0, 1.0, 0.2),
        bounds: bounds(&given)?,
    };
    let style = Style { size: [900, 560], smooth: false, edge_width: 2.5 };
    let draw = |mesh, name, caption| picture(mesh, &view, &style, name, caption, out);
    Ok(Item {
        paper: paper.short.clone(),
        name: NAME.into(),
        about: "Seven points on their convex hull, in a triangulation that is not the hull but a \
                local minimum of all three costs. Single flips and pairs of flips stay there. Rows \
                of three flips and annealing reach the hull for F2 and F3, whose least value it \
                has; for F1 the given triangulation is the better one. The paper prints the points \
                and no costs."
            .into(),
        needs: None,
        rows,
        figures: vec![
            draw(
                &given,
                "dhkl01-seven-points-given",
                "given: concave along the edge in its middle",
            )?,
            draw(&convex, "dhkl01-seven-points-convex", "convex: the least value of F2 and F3")?,
        ],
        functions: vec!["dtri_flip::CostName::total", "dtri_flip::optimise"],
        command: "curvmesh flip IN -o OUT --cost f2 --look-ahead 3",
    })
}

fn strategies() -> [(&'static str, FlipOptions); 4] {
    let look_ahead = |look_ahead| FlipOptions { look_ahead, ..FlipOptions::default() };
    let anneal = FlipOptions { anneal: Some(Anneal::default()), ..FlipOptions::default() };
    [
        ("greedy", look_ahead(1)),
        ("look-ahead 2", look_ahead(2)),
        ("look-ahead 3", look_ahead(3)),
        ("annealing", anneal),
    ]
}
