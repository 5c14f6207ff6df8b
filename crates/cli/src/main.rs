//! `curvmesh`: curvature-driven work on triangle meshes.
//!
//! One module per command, in `commands`; the others are what commands share. Results go to stdout, everything for people to stderr; with `--json`,
//! stdout carries one JSON object and nothing else.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod arguments;
mod attributes;
mod colormap;
mod commands;
mod console;
mod failure;
mod interrupt;
mod job;
mod load;
mod normals;
mod save;
mod seams;
mod simplify_options;

use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Command};
use commands::{convert, curvature, distance, flip, info, lod, patch, simplify};
use console::Console;
use failure::Failure;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let console = Console::new(&arguments.common);
    interrupt::watch();
    match run(&arguments, &console) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}

fn run(arguments: &Arguments, console: &Console) -> Result<(), Failure> {
    if let Some(threads) = arguments.common.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get());
        pool.build_global().map_err(Failure::threads)?;
    }
    match &arguments.command {
        Command::Info(options) => info::run(options, console),
        Command::Convert(options) => convert::run(options, console),
        Command::Curvature(options) => curvature::run(options, console),
        Command::Flip(options) => flip::run(options, console),
        Command::Patch(options) => patch::run(options, console),
        Command::Simplify(options) => simplify::run(options, console),
        Command::Lod(options) => lod::run(options, console),
        Command::Distance(options) => distance::run(options, console),
    }
}
