//! `cargo xtask python`: the Python package, built as a wheel and tested from outside the source tree.
//!
//! A virtual environment under `target/python` gets everything from the package index by pip. The
//! wheel is installed there like any other, and tests, doctests, the type checker and the notebooks
//! run on it in a folder of their own. Clippy looks at the crate, which no other command does.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::failure::Failure;

/// How to build and test the package.
#[derive(Debug, clap::Args)]
pub(crate) struct Python {
    /// Build as users get it, optimised as a whole, which takes some minutes
    #[arg(long)]
    release: bool,
    /// Install the large packages too that tests compare with: open3d and pyvista
    #[arg(long)]
    peers: bool,
    /// The Python that the environment is made with
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: String,
    /// The program that results are compared with, instead of one that is built for it
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// Build the wheel, and nothing else
    #[arg(long)]
    wheel_only: bool,
}

/// What builds and tests the package.
const TOOLS: [&str; 5] = ["maturin>=1.9,<2", "pytest", "hypothesis", "mypy", "numpy"];

/// What tests compare with.
const PEERS: [&str; 5] = ["trimesh", "meshio", "libigl", "pymeshlab", "scipy"];

/// What `curvmesh.batch` hands its tasks to, and reads and writes with.
const ENGINES: [&str; 4] = ["distributed", "ray", "fsspec", "pyarrow"];

/// More to compare with, hundreds of megabytes each.
const LARGE_PEERS: [&str; 3] = ["open3d", "pyvista", "tqdm"];

/// Where the package is.
const PACKAGE: &str = "crates/python";

pub(crate) fn run(options: &Python) -> Result<(), Failure> {
    let root = env::current_dir().map_err(Failure::source(Path::new(".")))?;
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let folder = target.join("python");
    fs::create_dir_all(&folder).map_err(Failure::writing(&folder))?;
    let environment = Environment::make(&folder.join("venv"), options)?;

    step("the wheel");
    let wheels = folder.join("wheels");
    let _ = fs::remove_dir_all(&wheels);
    let mut maturin = environment.command("maturin");
    maturin.args(["build", "--quiet", "--out"]).arg(&wheels).arg("--manifest-path");
    maturin.arg(root.join(PACKAGE).join("Cargo.toml")).arg("--target-dir").arg(&target);
    maturin.env("VIRTUAL_ENV", &environment.folder);
    if options.release {
        maturin.arg("--release");
    }
    check(&mut maturin)?;
    let wheel = only_file(&wheels)?;
    let bytes = fs::metadata(&wheel).map_err(Failure::source(&wheel))?.len();
    println!("{} ({:.1} MB)", wheel.display(), bytes as f64 / 1e6);
    if options.wheel_only {
        return Ok(());
    }
    let mut install = environment.python();
    install.args(["-m", "pip", "install", "--quiet", "--no-deps", "--force-reinstall"]);
    check(install.arg(&wheel))?;

    step("lints");
    let mut clippy = Command::new("cargo");
    clippy.args(["clippy", "--locked", "--quiet", "--manifest-path"]);
    clippy.arg(root.join(PACKAGE).join("Cargo.toml")).arg("--target-dir").arg(&target);
    check(clippy.args(["--", "-D", "warnings"]))?;

    let program = match &options.program {
        Some(program) => std::path::absolute(program).map_err(Failure::source(program))?,
        None => build_program(&target, options.release)?,
    };

    // From here on nothing of the source tree can be imported by accident.
    let outside = folder.join("outside");
    let _ = fs::remove_dir_all(&outside);
    for part in ["tests", "notebooks"] {
        copy_folder(&root.join(PACKAGE).join(part), &outside.join(part))?;
    }
    let readme = outside.join("README.md");
    fs::copy(root.join(PACKAGE).join("README.md"), &readme).map_err(Failure::writing(&readme))?;
    copy_folder(&root.join(PACKAGE).join("docs"), &outside.join("docs"))?;
    let pyproject = root.join(PACKAGE).join("pyproject.toml");
    let run = |arguments: &[&str]| -> Result<(), Failure> {
        let mut python = environment.python();
        python.current_dir(&outside).args(arguments).env("CURVMESH_PROGRAM", &program);
        check(&mut python)
    };

    step("types");
    let config = pyproject.to_string_lossy();
    let stubs = ["-m", "mypy", "--config-file", &config, "-p", "curvmesh"];
    run(&stubs)?;
    run(&["-m", "mypy", "--config-file", &config, "tests"])?;
    run(&["-m", "mypy", "--config-file", &config, "notebooks"])?;

    step("tests");
    run(&["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests"])?;

    step("examples in the documentation");
    run(&["tests/examples.py"])?;

    step("notebooks");
    let gallery = folder.join("gallery");
    run(&["notebooks/gallery.py", &gallery.to_string_lossy()])?;
    println!("{}", gallery.join("index.html").display());
    Ok(())
}

/// Builds the program that results are compared with.
fn build_program(target: &Path, release: bool) -> Result<PathBuf, Failure> {
    step("the program, which results are compared with");
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--quiet", "--package", "curvmesh"]);
    if release {
        cargo.arg("--release");
    }
    check(&mut cargo)?;
    let profile = if release { "release" } else { "debug" };
    Ok(target.join(profile).join(format!("curvmesh{}", env::consts::EXE_SUFFIX)))
}

/// A virtual environment.
struct Environment {
    folder: PathBuf,
}

impl Environment {
    fn make(folder: &Path, options: &Python) -> Result<Self, Failure> {
        step("the environment");
        let made = Self { folder: folder.to_owned() };
        if !made.program("python").exists() {
            check(Command::new(&options.python).args(["-m", "venv"]).arg(folder))?;
        }
        let mut install = made.python();
        install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        check(install.args(TOOLS))?;
        made.install_peers(&PEERS)?;
        made.install_peers(&ENGINES)?;
        if options.peers {
            made.install_peers(&LARGE_PEERS)?;
        }
        Ok(made)
    }

    /// Tests that need a package that is not there say so and are skipped.
    fn install_peers(&self, peers: &[&str]) -> Result<(), Failure> {
        for peer in peers {
            let mut install = self.python();
            install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", peer]);
            if check(&mut install).is_err() {
                println!("{peer} cannot be installed here: nothing is tested with it");
            }
        }
        Ok(())
    }

    fn python(&self) -> Command {
        self.command("python")
    }

    fn command(&self, name: &str) -> Command {
        Command::new(self.program(name))
    }

    fn program(&self, name: &str) -> PathBuf {
        let folder = if cfg!(windows) { "Scripts" } else { "bin" };
        self.folder.join(folder).join(format!("{name}{}", env::consts::EXE_SUFFIX))
    }
}

fn step(name: &str) {
    println!("-- {name}");
}

/// Runs a command that has to succeed.
fn check(command: &mut Command) -> Result<(), Failure> {
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

fn only_file(folder: &Path) -> Result<PathBuf, Failure> {
    let entries = fs::read_dir(folder).map_err(Failure::source(folder))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    match (files.pop(), files.is_empty()) {
        (Some(file), true) => Ok(file),
        _ => Err(Failure::Usage(format!("{} does not hold one wheel", folder.display()))),
    }
}

fn copy_folder(from: &Path, to: &Path) -> Result<(), Failure> {
    fs::create_dir_all(to).map_err(Failure::writing(to))?;
    for entry in fs::read_dir(from).map_err(Failure::source(from))?.flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), &target).map_err(Failure::writing(&target))?;
        }
    }
    Ok(())
}
