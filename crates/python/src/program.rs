//! The program `curvmesh`, which the wheel puts on the path.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program with this command line, and gives its exit code.
#[pyfunction]
pub(crate) fn run_program(py: Python<'_>, command_line: Vec<OsString>) -> u8 {
    py.detach(|| curvmesh_cli::run_program(&command_line))
}
