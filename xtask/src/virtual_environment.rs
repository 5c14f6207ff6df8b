//! A virtual environment of Python, with packages of the index.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::failure::Failure;

/// A folder with a Python of its own.
#[derive(Debug)]
pub(crate) struct VirtualEnvironment {
    pub(crate) folder: PathBuf,
}

impl VirtualEnvironment {
    /// Makes the environment with a Python of the system, unless it is there.
    pub(crate) fn make(folder: &Path, python: &str) -> Result<Self, Failure> {
        let made = Self { folder: folder.to_owned() };
        if !made.program("python").exists() {
            check(Command::new(python).args(["-m", "venv"]).arg(folder))?;
        }
        Ok(made)
    }

    /// Installs packages that are needed.
    pub(crate) fn install(&self, packages: &[&str]) -> Result<(), Failure> {
        let mut pip = self.python();
        pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        check(pip.args(packages))
    }

    /// Installs packages one by one: not all of them are there for every system. What is done without
    /// one that cannot be had is printed.
    pub(crate) fn install_if_there(&self, packages: &[&str], without: &str) {
        for package in packages {
            if self.install(&[package]).is_err() {
                println!("{package} cannot be installed here: {without}");
            }
        }
    }

    pub(crate) fn python(&self) -> Command {
        Command::new(self.program("python"))
    }

    /// Where a program of the environment is.
    pub(crate) fn program(&self, name: &str) -> PathBuf {
        let folder = if cfg!(windows) { "Scripts" } else { "bin" };
        self.folder.join(folder).join(format!("{name}{}", env::consts::EXE_SUFFIX))
    }
}

/// Runs a command that has to succeed; its output goes where ours goes.
pub(crate) fn check(command: &mut Command) -> Result<(), Failure> {
    let name = command.get_program().to_string_lossy().into_owned();
    let status = command.status().map_err(|source| {
        Failure::Usage(format!("{name} cannot be run: {source}; this command needs Python 3.10"))
    })?;
    if status.success() {
        return Ok(());
    }
    let arguments: Vec<_> = command.get_args().map(|a| a.to_string_lossy()).collect();
    Err(Failure::Usage(format!("{name} {} has failed", arguments.join(" "))))
}
