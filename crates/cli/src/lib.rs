#![doc = include_str!("../README.md")]
//!
//! # The code
//!
//! The program is this library with a `main`, so that the Python package contains it too.
//!
//! One module per command, in `commands`; the other modules are shared. Results go to stdout, all messages to stderr;
//! with `--json`, stdout carries only one JSON object, or one per line for many files.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod arguments;
mod batch;
mod carry;
mod colormap;
mod commands;
mod console;
mod counted;
mod decimal;
mod failure;
mod given;
mod interrupt;
mod inventory;
mod large;
mod load;
mod replaced;
mod save;
mod scene;
mod scene_tree;
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
    compare, completions, convert, curvature, distance, flip, info, lod, man, patch, region,
    render, repair, simplify, subdivide, view as view_command,
};
use console::Console;
use failure::Failure;
use given::Given;
use interrupt::{INTERRUPTED, KEEP_PARTIAL};
use session::{Outcome, Session};
use text::printable;

/// Runs the program with this command line, which starts with the name of the program, and returns its exit code. Call
/// it once in a process: it handles Ctrl-C and configures the threads.
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

/// Parses the command line.
fn parse(command_line: &[OsString]) -> Result<(Arguments, Session), clap::Error> {
    let mut command = Arguments::command();
    let matches = command.try_get_matches_from_mut(command_line)?;
    let (name, given) = match matches.subcommand() {
        Some((name, mut matches)) => {
            let mut found = command.find_subcommand(name);
            // Subcommands of a command have their own options.
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

/// Prints a usage error or the requested help.
fn usage_error(error: &clap::Error, command_line: &[OsString]) -> u8 {
    let is_help = !error.use_stderr();
    if !is_help && command_line.iter().any(|word| word == "--json") {
        let text = error.render().to_string();
        let text = text.trim_end().trim_start_matches("error: ");
        return report(&Failure::usage(text), &Console::without_command(true));
    }
    // A name of a file among the words, such as one that the shell found for `*`, may hold control characters.
    let is_safe = |word: &OsString| printable(word.display()) == word.to_string_lossy();
    if !is_help && !command_line.iter().all(is_safe) {
        Console::without_command(false).error(error.render());
        return 2;
    }
    // An error of printing cannot be reported.
    let _ = error.print();
    if is_help { 0 } else { 2 }
}

/// Reports a failure: as text, and as JSON if asked for.
fn report(failure: &Failure, console: &Console) -> u8 {
    console.error(format_args!("error: {}", failure.message()));
    if console.is_json() {
        // If printing fails, the message is on stderr anyway.
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
        Command::Compare(options) => compare::run(&options, session.on_one_thing()?),
        Command::Subdivide(options) => subdivide::run(&options, session),
        Command::Repair(options) => repair::run(&options, session),
        Command::View(options) => view_command::run(&options, session.on_one_thing()?),
        Command::Render(options) => render::run(&options, session.on_one_thing()?),
        Command::Region(options) => region::run(&options, session.on_one_thing()?),
        Command::Completions(options) => completions::run(&options, Arguments::command()),
        Command::Man(options) => man::run(&options, Arguments::command()),
    }
}
