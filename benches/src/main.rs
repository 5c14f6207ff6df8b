//! Measurements that take minutes to hours, one command each; `benches --help` lists them.
//!
//! This is a program, so unlike the libraries it prints. Benchmarks with criterion are in `criterion`.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod command_output;
mod compiled;
mod curvature_study;
mod fetch;
mod figures;
mod giant;
mod instructions;
mod job_set;
mod json_lines;
mod machine;
mod marked_page;
mod memory;
mod peers;
mod preset_study;
mod process;
mod raw_mesh;
mod rivals;
mod timing;
mod tolerance_study;

use std::process::ExitCode;

use benches::{convex_study, limit_study};
use clap::Parser;

#[derive(Debug, Parser)]
#[command(name = "benches", about = "Measurements that take minutes to hours")]
enum Measurement {
    /// Count how often edge flips find a scrambled convex hull again
    ///
    ///     cargo run -p benches -- convex-study --quick --strategies greedy,look-ahead-3
    #[command(verbatim_doc_comment)]
    ConvexStudy(convex_study::ConvexStudy),
    /// Count the faces that presets leave within a certified largest error
    ///
    ///     cargo run --release -p benches -- tolerance-study --models meshes
    ///     cargo run --release -p benches -- tolerance-study --models meshes --meshes cow.obj --presets fast,default
    #[command(verbatim_doc_comment)]
    ToleranceStudy(tolerance_study::ToleranceStudy),
    /// Measure how far simplified meshes are from the best possible ones
    ///
    ///     cargo run --release -p benches -- limit-study --quick
    ///     cargo run --release -p benches -- limit-study --surfaces sphere,torus --presets default,quality
    ///     cargo run --release -p benches -- limit-study --peer "other=other-program {in} {out} --faces {faces}"
    #[command(verbatim_doc_comment)]
    LimitStudy(limit_study::LimitStudy),
    /// Measure estimates of curvature against exact values
    ///
    ///     cargo run --release -p benches -- curvature-study --quick
    ///     cargo run --release -p benches -- curvature-study --peers --clones libraries --speed 20000
    ///     cargo run --release -p benches -- curvature-study --surfaces pipe --samplings along25 --export meshes
    #[command(verbatim_doc_comment)]
    CurvatureStudy(curvature_study::CurvatureStudy),
    #[command(hide = true)]
    CurvatureJob(curvature_study::CurvatureJob),
    /// Measure our presets beside other programs: time, error, memory
    ///
    ///     cargo run --release -p benches --features meshopt -- peers --models meshes
    ///     cargo run --release -p benches -- peers --models meshes --jobs short
    ///     cargo run --release -p benches -- peers --models meshes --max-errors 0.2
    ///     cargo run -p benches -- peers --from benches/recorded/peers.jsonl
    ///     cargo run -p benches -- peers --from benches/recorded/peers.jsonl --html peers.html
    #[command(verbatim_doc_comment)]
    Peers(peers::Peers),
    /// Compare the mean error of each preset with that of the next cheaper one
    ///
    ///     cargo run --release -p benches -- preset-study --models meshes
    ///     cargo run --release -p benches -- preset-study --parts 40 --seed 7
    #[command(verbatim_doc_comment)]
    PresetStudy(preset_study::PresetStudy),
    /// Fetch the meshes of the benchmark from their public repositories, and check them
    ///
    ///     cargo run -p benches -- fetch --to meshes
    ///     cargo run -p benches -- fetch --to meshes --cache downloads --meshes cow.obj,fandisk.obj
    #[command(verbatim_doc_comment)]
    Fetch(fetch::Fetch),
    /// Compare our edge flips with those of other programs: time, F1 to F3, angles, defects
    ///
    ///     cargo run --release -p benches -- flips --models meshes --jobs full,growth
    ///     cargo run --release -p benches -- flips --jobs growth --tools f1,f2
    ///     cargo run -p benches -- flips --from benches/recorded/flips.jsonl
    #[command(verbatim_doc_comment)]
    Flips(rivals::Flips),
    /// Compare our Hausdorff distances with those of other programs: bounds, time, memory
    ///
    ///     cargo run --release -p benches -- distances --models meshes
    ///     cargo run --release -p benches -- distances --models meshes --tools proved,cascading
    ///     cargo run -p benches -- distances --from benches/recorded/distances.jsonl
    #[command(verbatim_doc_comment)]
    Distances(rivals::Distances),
    #[command(hide = true)]
    RivalJob(rivals::RivalJob),
    #[command(hide = true)]
    PeerJob(peers::PeerJob),
    /// Write a torus with bumps of any size as binary PLY, without holding it in memory
    ///
    ///     cargo run --release -p benches -- giant -o giant.ply --faces 10000000
    #[command(verbatim_doc_comment)]
    Giant(giant::Giant),
    /// Count the instructions of one fixed job of each layer, with callgrind
    ///
    ///     CARGO_INCREMENTAL=0 CARGO_PROFILE_DEV_CODEGEN_UNITS=1 cargo run -p benches -- instructions --check
    #[command(verbatim_doc_comment)]
    Instructions(instructions::Instructions),
    #[command(hide = true)]
    InstructionsJob(instructions::InstructionsJob),
}

fn main() -> ExitCode {
    xtask_common::exit_code(match Measurement::parse() {
        Measurement::ConvexStudy(options) => convex_study::run(&options),
        Measurement::LimitStudy(options) => limit_study::run(&options),
        Measurement::ToleranceStudy(options) => tolerance_study::run(&options),
        Measurement::CurvatureStudy(options) => curvature_study::run(&options),
        Measurement::CurvatureJob(options) => curvature_study::run_job(&options),
        Measurement::Peers(options) => peers::run(&options),
        Measurement::PresetStudy(options) => preset_study::run(&options),
        Measurement::Fetch(options) => fetch::run(&options),
        Measurement::Flips(options) => rivals::run_flips(&options),
        Measurement::Distances(options) => rivals::run_distances(&options),
        Measurement::RivalJob(options) => rivals::run_job(&options),
        Measurement::PeerJob(options) => peers::run_job(&options),
        Measurement::Giant(options) => giant::run(&options),
        Measurement::Instructions(options) => instructions::run(&options),
        Measurement::InstructionsJob(options) => instructions::run_job(&options),
    })
}
