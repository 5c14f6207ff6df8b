//! Greedy, look-ahead, annealing and rebuilding on the same scrambled sphere: the costs that they reach.
#![allow(missing_docs, clippy::print_stdout)]

use std::ops::ControlFlow;

use dcurv::VertexArea;
use dtri_flip::{Anneal, CostName, FlipOptions, Rebuild};
use mesh_core::SplitMix64;
use mesh_core::TriMesh;
use mesh_shapes::{Sphere, scramble};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The convex hull is the best triangulation of these points; the scrambled one is far from it.
    let hull = TriMesh::from_soup(&Sphere { radius: 1.0 }.random_hull(120, 1)?)?;
    let mut start = hull.clone();
    scramble(&mut start, 100, &mut SplitMix64::new(1), |_, _| true);
    let greedy = FlipOptions::default();
    let strategies = [
        ("greedy", greedy.clone()),
        ("look-ahead 2", FlipOptions { look_ahead: 2, ..greedy.clone() }),
        ("annealing", FlipOptions { anneal: Some(Anneal::default()), ..greedy.clone() }),
        ("rebuilding", FlipOptions { rebuild: Some(Rebuild::default()), ..greedy }),
    ];
    println!("{:6} {:13} {:>6} {:>12} {:>12}", "cost", "strategy", "flips", "reached", "hull");
    for cost in [CostName::F1, CostName::F2, CostName::F3] {
        for (name, options) in &strategies {
            let mut mesh = start.clone();
            let report = cost.optimise(&mut mesh, VertexArea::Voronoi, options, &mut |_| {
                ControlFlow::Continue(())
            })?;
            let (reached, best) = (report.cost_after, cost.total(&hull, VertexArea::Voronoi));
            println!("{cost:6} {name:13} {:6} {reached:12.6} {best:12.6}", report.flips);
        }
    }
    Ok(())
}
