//! Tasks around the workspace: `cargo xtask reproduce` computes what the papers print,
//! `cargo xtask convex-study` tries the costs of DHKL01 on convex data, `cargo xtask tolerance-study`
//! counts the faces within a largest error, `cargo xtask limit-study` measures the distance from the best
//! possible mesh, `cargo xtask circles` holds the files of each crate to be in layers,
//! `cargo xtask torture` runs every command on every file of a folder, `cargo xtask peers`
//! measures other tools beside ours, `cargo xtask python` builds and tests the Python package, `cargo xtask giant` writes a mesh of any size,
//! `cargo xtask instructions` counts those of a job of each layer, and `cargo xtask deny` checks the
//! dependencies.
//!
//! One module per command. This is a program, so unlike the libraries it prints.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod circles;
mod convex_study;
mod decimals;
mod deny;
mod failure;
mod giant;
mod instructions;
mod limit_study;
mod numbers;
mod peers;
mod plot;
mod progress;
mod python;
mod reproduce;
mod tolerance_study;
mod torture;
mod virtual_environment;

use std::process::ExitCode;

use clap::Parser;

#[derive(Debug, Parser)]
#[command(name = "cargo xtask", about = "Reproduces the papers and tries to break the program")]
enum Task {
    /// Compute the papers' tables and figures and compare them with what is printed
    ///
    /// Without further arguments everything is reproduced on generated data:
    ///
    ///     cargo xtask reproduce
    #[command(verbatim_doc_comment)]
    Reproduce(reproduce::Reproduce),
    /// Count how often a scrambled convex hull is found again
    ///
    ///     cargo xtask convex-study --quick --strategies greedy,look-ahead-3
    #[command(verbatim_doc_comment)]
    ConvexStudy(convex_study::ConvexStudy),
    /// Count the faces that presets leave within a largest error, proved
    ///
    ///     cargo xtask tolerance-study --models meshes
    ///     cargo xtask tolerance-study --models meshes --meshes cow.obj --presets fast,default,paper-l1
    #[command(verbatim_doc_comment, alias = "limits-study")]
    ToleranceStudy(tolerance_study::ToleranceStudy),
    /// Measure how far simplified meshes are from the best possible ones
    ///
    ///     cargo xtask limit-study --quick
    ///     cargo xtask limit-study --surfaces sphere,torus --presets default,quality
    ///     cargo xtask limit-study --peer "other=other-program {in} {out} --faces {faces}"
    #[command(verbatim_doc_comment)]
    LimitStudy(limit_study::LimitStudy),
    /// Look for circles among the files of each crate: what a file uses shall lie below it
    ///
    ///     cargo xtask circles
    ///     cargo xtask circles crates/simplify
    #[command(verbatim_doc_comment)]
    Circles(circles::Circles),
    /// Run every command on every file, under limits, and check what comes out with other readers
    ///
    ///     cargo xtask torture --models meshes
    ///     cargo xtask torture --models meshes --quick --only simplify,flip --every 7
    #[command(verbatim_doc_comment)]
    Torture(torture::Torture),
    /// Measure our presets beside other tools: time, errors, memory
    ///
    ///     cargo run --release -p xtask --features meshopt -- peers --models meshes
    ///     cargo run --release -p xtask -- peers --models meshes --max-errors 0.2
    #[command(verbatim_doc_comment)]
    Peers(peers::Peers),
    #[command(hide = true)]
    PeerJob(peers::PeerJob),
    /// Build the Python package as a wheel, and test it from outside the source tree
    ///
    ///     cargo xtask python
    ///     cargo xtask python --release --peers
    #[command(verbatim_doc_comment)]
    Python(python::Python),
    /// Write a mesh of any size, a torus with bumps, as binary PLY; it is never in memory as a whole
    ///
    ///     cargo xtask giant -o giant.ply --faces 10000000
    #[command(verbatim_doc_comment)]
    Giant(giant::Giant),
    /// Count the instructions of one fixed job of each layer, by callgrind
    ///
    ///     CARGO_INCREMENTAL=0 CARGO_PROFILE_DEV_CODEGEN_UNITS=1 cargo xtask instructions --check
    #[command(verbatim_doc_comment)]
    Instructions(instructions::Instructions),
    #[command(hide = true)]
    InstructionsJob(instructions::InstructionsJob),
    /// Check the licences, versions and sources of all dependencies against deny.toml
    Deny(deny::Deny),
}

fn main() -> ExitCode {
    let result = match Task::parse() {
        Task::Reproduce(options) => reproduce::run(&options),
        Task::ConvexStudy(options) => convex_study::run(&options),
        Task::LimitStudy(options) => limit_study::run(&options),
        Task::ToleranceStudy(options) => tolerance_study::run(&options),
        Task::Circles(options) => circles::run(&options),
        Task::Torture(options) => torture::run(&options),
        Task::Peers(options) => peers::run(&options),
        Task::PeerJob(options) => peers::run_job(&options),
        Task::Python(options) => python::run(&options),
        Task::Giant(options) => giant::run(&options),
        Task::Instructions(options) => instructions::run(&options),
        Task::InstructionsJob(options) => instructions::run_job(&options),
        Task::Deny(options) => deny::run(&options),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}
