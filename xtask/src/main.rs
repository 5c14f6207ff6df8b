//! Tasks of the workspace: `cargo xtask circles` checks the modules of each crate, `cargo xtask casts` its casts of
//! integers, `cargo xtask package` packs the crates for the registry, `cargo xtask python` builds and tests the Python
//! package. `cargo xtask reproduce` and `cargo xtask instructions` start separate programs, because those depend on all
//! libraries.
//!
//! One module per command. This is a program, so unlike the libraries it prints.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod casts;
mod circles;
mod files;
mod package;
mod programs;
mod python;
mod release;

use std::process::ExitCode;

use clap::Parser;

#[derive(Debug, Parser)]
#[command(name = "cargo xtask", about = "Tasks of the workspace")]
enum Task {
    /// Compute the papers' tables and figures and compare them with the printed numbers
    ///
    ///     cargo xtask reproduce
    ///     cargo xtask reproduce --help
    #[command(verbatim_doc_comment, disable_help_flag = true)]
    Reproduce(programs::Arguments),
    /// Count the instructions of one fixed job of each layer, with callgrind
    ///
    ///     CARGO_INCREMENTAL=0 CARGO_PROFILE_DEV_CODEGEN_UNITS=1 cargo xtask instructions --check
    #[command(verbatim_doc_comment, disable_help_flag = true)]
    Instructions(programs::Arguments),
    /// Check that the modules of each crate form an acyclic graph
    ///
    ///     cargo xtask circles
    ///     cargo xtask circles crates/simplify
    #[command(verbatim_doc_comment)]
    Circles(circles::Circles),
    /// Check that casts of integers to 32 bits or fewer cannot cut off a number unnoticed
    ///
    ///     cargo xtask casts
    ///     cargo xtask casts crates/mesh-io
    #[command(verbatim_doc_comment)]
    Casts(casts::Casts),
    /// Write crates with names that the registry has free, and build a program from the packed files alone
    ///
    ///     cargo xtask package
    #[command(verbatim_doc_comment)]
    Package(package::Pack),
    /// Build the Python package as a wheel, and test it from outside the source tree
    ///
    ///     cargo xtask python
    ///     cargo xtask python --release --peers
    #[command(verbatim_doc_comment)]
    Python(python::Python),
    /// Build the packages of a release, check them and install them in an empty environment
    ///
    ///     cargo xtask release --dry-run
    #[command(verbatim_doc_comment)]
    Release(release::Release),
}

fn main() -> ExitCode {
    xtask_common::exit_code(match Task::parse() {
        Task::Reproduce(arguments) => programs::run("reproduce", None, &arguments),
        Task::Instructions(arguments) => programs::run("benches", Some("instructions"), &arguments),
        Task::Circles(options) => circles::run(&options),
        Task::Casts(options) => casts::run(&options),
        Task::Package(options) => package::run(&options),
        Task::Python(options) => python::run(&options),
        Task::Release(options) => release::run(&options),
    })
}
