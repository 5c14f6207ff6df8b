//! The program `curvmesh`.

use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    let command_line: Vec<OsString> = std::env::args_os().collect();
    ExitCode::from(curvmesh_cli::run_program(&command_line))
}
