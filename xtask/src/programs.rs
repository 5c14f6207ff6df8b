//! Tasks that are separate programs.

use std::env;
use std::ffi::OsString;
use std::process::Command;

use xtask_common::{Failure, check};

/// The arguments of a program, passed on unchanged.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Arguments of the program; `--help` lists them
    #[arg(value_name = "ARGUMENTS", trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// Builds a program of the workspace and runs it, or one of its commands.
pub(crate) fn run(
    package: &str,
    command: Option<&str>,
    arguments: &Arguments,
) -> Result<(), Failure> {
    let mut cargo = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(["run", "--package", package, "--"]).args(command).args(&arguments.arguments);
    check(&mut cargo)
}
