#![doc = include_str!("../README.md")]
//!
//! # The code
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
mod large;
mod load;
mod save;
mod session;
mod simplify_options;
mod streaming;
mod task;
mod text;
mod view;

use std::process::ExitCode;

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

fn main() -> ExitCode {
    let (arguments, session) = match parse() {
        Ok(parsed) => parsed,
        Err(error) => return usage_error(&error),
    };
    interrupt::watch(session.given.has(KEEP_PARTIAL));
    let outcome = session.given.check_relative().and_then(|()| run(arguments, &session));
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::SomeFailed) => ExitCode::from(4),
        Ok(Outcome::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(failure) => report(&failure, &session.console),
    }
}

/// The command line, or why it makes no sense.
fn parse() -> Result<(Arguments, Session), clap::Error> {
    let mut command = Arguments::command();
    let matches = command.try_get_matches_from_mut(std::env::args_os())?;
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
fn usage_error(error: &clap::Error) -> ExitCode {
    let is_help = !error.use_stderr();
    if !is_help && std::env::args_os().any(|argument| argument == "--json") {
        let text = error.render().to_string();
        let text = text.trim_end().trim_start_matches("error: ");
        return report(&Failure::usage(text), &Console::without_command(true));
    }
    // Nobody reads it if it cannot be printed.
    let _ = error.print();
    if is_help { ExitCode::SUCCESS } else { ExitCode::from(2) }
}

/// Says what went wrong: to people, and to programs if asked to.
fn report(failure: &Failure, console: &Console) -> ExitCode {
    console.error(format_args!("error: {}", failure.message()));
    if console.is_json() {
        // What cannot be printed has been said on stderr.
        let _ = console.failed(None, failure).and_then(|line| console.print(line));
    }
    ExitCode::from(failure.exit_code())
}

fn run(arguments: Arguments, session: &Session) -> Result<Outcome, Failure> {
    match arguments.command {
        Command::Info(options) => info::run(&options, session.on_one_thing()?),
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
