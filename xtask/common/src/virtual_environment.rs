//! A Python virtual environment, with packages from the index.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::failure::Failure;

/// A folder with its own Python.
#[derive(Debug)]
pub struct VirtualEnvironment {
    /// The folder of the environment.
    pub folder: PathBuf,
}

impl VirtualEnvironment {
    /// Makes the environment with a Python of the system, unless it exists.
    pub fn make(folder: &Path, python: &str) -> Result<Self, Failure> {
        let made = Self { folder: folder.to_owned() };
        if !made.program("python").exists() {
            check(Command::new(python).args(["-m", "venv"]).arg(folder))?;
        }
        Ok(made)
    }

    /// Installs required packages.
    pub fn install(&self, packages: &[&str]) -> Result<(), Failure> {
        let mut pip = self.python();
        pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        check(pip.args(packages))
    }

    /// Installs packages; one by one if they cannot all be installed on this system. Prints the consequence for each
    /// that cannot be installed.
    pub fn install_if_there(&self, packages: &[&str], without: &str) {
        if self.install(packages).is_ok() {
            return;
        }
        for package in packages {
            if self.install(&[package]).is_err() {
                println!("{package} cannot be installed here: {without}");
            }
        }
    }

    /// A command that starts the Python of the environment.
    #[must_use]
    pub fn python(&self) -> Command {
        Command::new(self.program("python"))
    }

    /// The path of a program of the environment.
    pub fn program(&self, name: &str) -> PathBuf {
        let folder = if cfg!(windows) { "Scripts" } else { "bin" };
        self.folder.join(folder).join(format!("{name}{}", env::consts::EXE_SUFFIX))
    }
}

/// Runs a command that must succeed; it inherits our output.
pub fn check(command: &mut Command) -> Result<(), Failure> {
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
