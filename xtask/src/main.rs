//! Tasks around the workspace: `cargo xtask reproduce` computes what the papers print,
//! `cargo xtask convex-study` tries the costs of DHKL01 on convex data, `cargo xtask limits-study`
//! counts the faces within a largest error, and `cargo xtask circles` holds the files of each crate to be in layers.
//!
//! One module per command. This is a program, so unlike the libraries it prints.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod circles;
mod convex_study;
mod failure;
mod limits_study;
mod plot;
mod reproduce;

use std::process::ExitCode;

use clap::Parser;

#[derive(Debug, Parser)]
#[command(name = "cargo xtask", about = "Reproduces the papers")]
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
    ///     cargo xtask limits-study --models meshes
    ///     cargo xtask limits-study --models meshes --meshes cow.obj --presets fast,default,paper-l1
    #[command(verbatim_doc_comment)]
    LimitsStudy(limits_study::LimitsStudy),
    /// Look for circles among the files of each crate: what a file uses shall lie below it
    ///
    ///     cargo xtask circles
    ///     cargo xtask circles crates/simplify
    #[command(verbatim_doc_comment)]
    Circles(circles::Circles),
}

fn main() -> ExitCode {
    let result = match Task::parse() {
        Task::Reproduce(options) => reproduce::run(&options),
        Task::ConvexStudy(options) => convex_study::run(&options),
        Task::LimitsStudy(options) => limits_study::run(&options),
        Task::Circles(options) => circles::run(&options),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}
