//! Time and memory of every program, each in its own process on one thread.

use std::path::Path;
use std::process::Command;

use clap::ValueEnum;
use xtask_common::Failure;

use super::case::{Case, Estimate};
use super::cost::{Cost, measured};
use super::programs::Peers;
use super::row::{Key, Ours, Row};
use super::sampling::{Sampling, sample};
use super::surfaces::Surface;
use crate::command_output::command_output;

/// The surface and the mesh that are measured.
const MEASURED: (Surface, Sampling) = (Surface::Torus, Sampling::Irregular);

/// How often each of our estimators runs; the least time counts. Other programs run once.
const REPEATS: usize = 3;

/// One run of an estimator of ours; the study starts this program again with it.
#[derive(Debug, clap::Args)]
pub(crate) struct CurvatureJob {
    estimator: Ours,
    vertices: usize,
}

/// Does the run and prints its cost.
pub(crate) fn run_job(options: &CurvatureJob) -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread()
        .build_global()
        .map_err(Failure::mesh)?;
    let case = case(options.vertices)?;
    let (_, mut cost) = measured(|| options.estimator.estimate(&case))?;
    for _ in 1..REPEATS {
        let (_, next) = measured(|| options.estimator.estimate(&case))?;
        cost.seconds = cost.seconds.min(next.seconds);
    }
    println!("{cost}");
    Ok(())
}

fn case(vertices: usize) -> Result<Case, Failure> {
    let (surface, sampling) = MEASURED;
    Ok(Case::new(sample(surface, sampling, vertices)?, 0.0)?.0)
}

/// A program with its cost and its error.
struct Measured {
    program: String,
    row: Row,
    cost: Cost,
    is_ours: bool,
}

/// The table of time and memory, and our estimators beside the fastest other program of equal or lower error.
pub(super) fn table(vertices: usize, peers: Option<&mut Peers>) -> Result<String, Failure> {
    let case = case(vertices)?;
    let count = case.exact.len();
    let mut all = Vec::new();
    let mut add = |program: &str, estimates: &[Estimate], cost: Cost, is_ours: bool| {
        let (surface, sampling) = MEASURED;
        let key: Key =
            (surface.name(), sampling.name(), vertices, "0".to_owned(), program.to_owned());
        let row = case.row(key, estimates, cost.seconds);
        all.push(Measured { program: program.to_owned(), row, cost, is_ours });
    };
    let this = std::env::current_exe().map_err(Failure::writing(Path::new("benches")))?;
    for &ours in Ours::value_variants() {
        let cost = run_ours(&this, ours, vertices)?;
        add(ours.name(), &ours.estimate(&case)?, cost, true);
    }
    if let Some(peers) = peers {
        for program in peers.programs.clone() {
            peers.end_process();
            if let Some((estimates, cost)) = peers.estimate(&program, &case) {
                add(&program.name, &estimates, cost, false);
            }
        }
        peers.end_process();
    }
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::ASCII_MARKDOWN);
    table.set_header(["", "median error", "vertices/s", "bytes/vertex"]);
    for Measured { program, row, cost, .. } in &all {
        let bytes = cost.peak.map_or_else(String::new, |peak| (peak / count as u64).to_string());
        let error = format!("{:.3} %", 100.0 * row.k_median);
        let speed = format!("{:.0}", count as f64 / cost.seconds);
        table.add_row([program.clone(), error, speed, bytes]);
    }
    let (surface, sampling) = MEASURED;
    let mut text = format!(
        "One thread, {}, {}, {count} vertices, without noise. Times are of the processor.\n\n{table}\n\n",
        surface.name(),
        sampling.name()
    );
    let rivals = || all.iter().filter(|other| !other.is_ours);
    for ours in all.iter().filter(|ours| ours.is_ours) {
        let as_good = rivals().filter(|other| other.row.k_median <= ours.row.k_median);
        let fastest = as_good.min_by(|a, b| a.cost.seconds.total_cmp(&b.cost.seconds));
        text += &fastest.map_or_else(
            || format!("- `{}`: no other program has as little error.\n", ours.program),
            |other| {
                let ratio = other.cost.seconds / ours.cost.seconds;
                format!("- `{}`: {ratio:.2} times the speed of {}, the fastest other program of equal or lower error.\n", ours.program, other.program)
            },
        );
    }
    Ok(text)
}

/// The cost of one of our estimators, from a process of its own.
fn run_ours(this: &Path, ours: Ours, vertices: usize) -> Result<Cost, Failure> {
    let name = ours.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned());
    let mut command = Command::new(this);
    command.arg("curvature-job").arg(name).arg(vertices.to_string());
    let answer = command_output(&mut command).map_err(Failure::Usage)?;
    String::from_utf8_lossy(&answer).parse().map_err(Failure::Usage)
}
