#![doc = include_str!("../README.md")]
//!
//! # The code
//!
//! The program is this library with a `main`, so that the Python package has it too.
//!
//! One module per command, in `commands`; the others are what commands share. Results go to stdout,
//! everything for people to stderr; with `--json`, stdout carries one JSON object and nothing else,
//! or one per line for many files.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod arguments;
mod batch;
mod carry;
mod colormap;
mod commands;
mod console;
mod failure;
mod given;
mod interrupt;
mod inventory;
mod large;
mod load;
mod save;
mod session;
mod simplify_options;
mod streaming;
mod task;
mod text;
mod view;
mod watertight;

use std::ffi::OsString;

use clap::{CommandFactory, FromArgMatches};

use arguments::{Arguments, Command};
use commands::{
    completions, convert, curvature, distance, flip, info, lod, man, patch, region, render, repair,
    simplify, subdivide, view as view_command,
};
use console::Console;
use failure::Failure;
use given::Given;
use interrupt::{INTERRUPTED, KEEP_PARTIAL};
use session::{Outcome, Session};

/// Runs the program with this command line, whose first word is the name of the program, and gives
/// its exit code. Once in a process: it takes over Ctrl-C and the threads.
#[must_use]
pub fn run_program(command_line: &[OsString]) -> u8 {
    let (arguments, session) = match parse(command_line) {
        Ok(parsed) => parsed,
        Err(error) => return usage_error(&error, command_line),
    };
    interrupt::watch(session.given.has(KEEP_PARTIAL));
    let outcome = session.given.check_relative().and_then(|()| run(arguments, &session));
    match outcome {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::SomeFailed) => 4,
        Ok(Outcome::Interrupted) => INTERRUPTED,
        Err(failure) => report(&failure, &session.console),
    }
}

/// The command line, or why it makes no sense.
fn parse(command_line: &[OsString]) -> Result<(Arguments, Session), clap::Error> {
    let mut command = Arguments::command();
    let matches = command.try_get_matches_from_mut(command_line)?;
    let (name, given) = match matches.subcommand() {
        Some((name, mut matches)) => {
            let mut found = command.find_subcommand(name);
            // Steps of a command have options of their own.
            while let (Some(command), Some((step, below))) = (found, matches.subcommand()) {
                (found, matches) = (command.find_subcommand(step), below);
            }
            (name, found.map_or_else(Given::default, |command| Given::new(command, matches)))
        }
        None => ("", Given::default()),
    };
    let arguments = Arguments::from_arg_matches(&matches)?;
    let threads = arguments.common.threads;
    let console = Console::new(&arguments.common, name, &given);
    Ok((arguments, Session { console, given, threads }))
}

/// Says what is wrong with the command line, or the help that was asked for.
fn usage_error(error: &clap::Error, command_line: &[OsString]) -> u8 {
    let is_help = !error.use_stderr();
    if !is_help && command_line.iter().any(|word| word == "--json") {
        let text = error.render().to_string();
        let text = text.trim_end().trim_start_matches("error: ");
        return report(&Failure::usage(text), &Console::without_command(true));
    }
    // Nobody reads it if it cannot be printed.
    let _ = error.print();
    if is_help { 0 } else { 2 }
}

/// Says what went wrong: to people, and to programs if asked to.
fn report(failure: &Failure, console: &Console) -> u8 {
    console.error(format_args!("error: {}", failure.message()));
    if console.is_json() {
        // What cannot be printed has been said on stderr.
        let _ = console.failed(None, failure).and_then(|line| console.print(line));
    }
    failure.exit_code()
}

fn run(arguments: Arguments, session: &Session) -> Result<Outcome, Failure> {
    match arguments.command {
        Command::Info(options) => info::run(&options, session),
        Command::Convert(options) => convert::run(&options.with_output()?, session),
        Command::Curvature(options) => curvature::run(&options, session),
        Command::Flip(options) => flip::run(&options, session),
        Command::Patch(options) => patch::run(&options, session),
        Command::Simplify(options) => simplify::run(&options, session),
        Command::Lod(options) => lod::run(&options, session.on_one_thing()?),
        Command::Distance(options) => distance::run(&options, session.on_one_thing()?),
        Command::Subdivide(options) => subdivide::run(&options, session),
        Command::Repair(options) => repair::run(&options, session),
        Command::View(options) => view_command::run(&options, session.on_one_thing()?),
        Command::Render(options) => render::run(&options, session.on_one_thing()?),
        Command::Region(options) => region::run(&options, session.on_one_thing()?),
        Command::Completions(options) => completions::run(&options, Arguments::command()),
        Command::Man(options) => man::run(&options, Arguments::command()),
    }
}
