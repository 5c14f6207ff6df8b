//! `curvmesh`: curvature-driven work on triangle meshes.
//!
//! One module per command. Results go to stdout, everything for people to stderr; with `--json`,
//! stdout carries one JSON object and nothing else.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod attributes;
mod colormap;
mod console;
mod convert;
mod curvature;
mod distance;
mod face_curvature;
mod failure;
mod flip;
mod info;
mod interrupt;
mod job;
mod load;
mod lod;
mod normals;
mod patch;
mod save;
mod seams;
mod simplify;
mod simplify_options;

use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, Command};
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
