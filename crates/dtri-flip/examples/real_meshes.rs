//! Optimises real meshes by every cost and prints the costs before and after.
#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

#[allow(dead_code)]
#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions};

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let costs: Vec<CostName> = match args.first() {
        Some(name) => vec![name.parse().unwrap()],
        None => CostName::ALL.to_vec(),
    };
    let look_ahead = args.get(1).map_or(1, |k| k.parse().unwrap());
    let guard = args.get(2).is_some();
    for name in ["rocker-arm.obj", "fandisk.obj", "armadillo_52k.off", "igea.obj"] {
        let Some(mesh) = common::model(name) else { return };
        for &cost in &costs {
            let mut mesh = mesh.clone();
            let (start, cpu) = (Instant::now(), cpu_seconds());
            let options =
                FlipOptions { look_ahead, forbid_intersections: guard, ..Default::default() };
            let report = cost
                .optimise(&mut mesh, VertexArea::Voronoi, &options, &mut |_| {
                    std::ops::ControlFlow::Continue(())
                })
                .unwrap();
            println!(
                "{name:18} {cost:18} {:12.4} -> {:12.4}  {:7} flips  {:.3} s  ({:.2} s CPU)  {} {:?}",
                report.cost_before,
                report.cost_after,
                report.flips,
                start.elapsed().as_secs_f64(),
                cpu_seconds() - cpu,
                report.stop,
                report.rejected,
            );
        }
    }
}

/// The processor time used so far, if the system reports it. It hardly depends on other load.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks =
        after_name.split_whitespace().skip(11).take(2).filter_map(|t| t.parse::<f64>().ok());
    ticks.sum::<f64>() / 100.0
}
