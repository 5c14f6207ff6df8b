//! A virtual environment of Python, with packages of the index.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::failure::Failure;

/// A folder with a Python of its own.
#[derive(Debug)]
pub struct VirtualEnvironment {
    /// The folder of the environment.
    pub folder: PathBuf,
}

impl VirtualEnvironment {
    /// Makes the environment with a Python of the system, unless it is there.
    pub fn make(folder: &Path, python: &str) -> Result<Self, Failure> {
        let made = Self { folder: folder.to_owned() };
        if !made.program("python").exists() {
            check(Command::new(python).args(["-m", "venv"]).arg(folder))?;
        }
        Ok(made)
    }

    /// Installs packages that are needed.
    pub fn install(&self, packages: &[&str]) -> Result<(), Failure> {
        let mut pip = self.python();
        pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        check(pip.args(packages))
    }

    /// Installs packages, each by itself if not all can be had on this system. Prints what is left out for
    /// each that cannot be installed.
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

    /// Where a program of the environment is.
    pub fn program(&self, name: &str) -> PathBuf {
        let folder = if cfg!(windows) { "Scripts" } else { "bin" };
        self.folder.join(folder).join(format!("{name}{}", env::consts::EXE_SUFFIX))
    }
}

/// Runs a command that has to succeed; its output goes where ours goes.
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
