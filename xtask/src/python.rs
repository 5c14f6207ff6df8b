//! `cargo xtask python`: the Python package, built as a wheel and tested from outside the source tree.
//!
//! A virtual environment under `target/python` gets all packages from the package index by pip. The wheel is installed
//! there like any other package, and tests, doctests, the type checker and the notebooks run on it in a separate
//! folder.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::files::copy_folder;
use xtask_common::Failure;
use xtask_common::{VirtualEnvironment, check};

/// How to build and test the package.
#[derive(Debug, clap::Args)]
pub(crate) struct Python {
    /// Build as users get it, optimised as a whole, which takes some minutes
    #[arg(long)]
    release: bool,
    /// Install the large packages too that tests compare with, open3d, pyvista and Blender, and take all meshes of
    /// `CURVMESH_MODELS` through all packages, not only small ones
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

/// Tools that build and test the package.
const TOOLS: [&str; 5] = ["maturin>=1.9,<2", "pytest", "hypothesis", "mypy", "numpy"];

/// Packages that tests compare with.
const PEERS: [&str; 7] =
    ["trimesh", "meshio", "libigl", "pymeshlab", "scipy", "pillow", "py-rattler-build"];

/// Packages that `curvmesh.batch` uses to distribute tasks, to read and to write.
const ENGINES: [&str; 4] = ["distributed", "ray", "fsspec", "pyarrow"];

/// Further packages to compare with, hundreds of megabytes each.
const LARGE_PEERS: [&str; 3] = ["open3d", "pyvista", "tqdm"];

/// The folder of the package.
const PACKAGE: &str = "crates/python";

pub(crate) fn run(options: &Python) -> Result<(), Failure> {
    let root = env::current_dir().map_err(Failure::reading(Path::new(".")))?;
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let folder = target.join("python");
    fs::create_dir_all(&folder).map_err(Failure::writing(&folder))?;
    let environment = environment(&folder.join("venv"), options)?;

    step("the wheel");
    let wheels = folder.join("wheels");
    let _ = fs::remove_dir_all(&wheels);
    let mut maturin = Command::new(environment.program("maturin"));
    maturin.args(["build", "--quiet", "--out"]).arg(&wheels).arg("--manifest-path");
    maturin.arg(root.join(PACKAGE).join("Cargo.toml")).arg("--target-dir").arg(&target);
    maturin.env("VIRTUAL_ENV", &environment.folder);
    maturin.args(if options.release { &["--release"][..] } else { &["--features", "as-tested"] });
    check(&mut maturin)?;
    let wheel = only_file(&wheels)?;
    let bytes = fs::metadata(&wheel).map_err(Failure::reading(&wheel))?.len();
    println!("{} ({:.1} MB)", wheel.display(), bytes as f64 / 1e6);
    if options.wheel_only {
        return Ok(());
    }
    let mut install = environment.python();
    install.args(["-m", "pip", "install", "--quiet", "--no-deps", "--force-reinstall"]);
    check(install.arg(&wheel))?;

    let program = match &options.program {
        Some(program) => std::path::absolute(program).map_err(Failure::reading(program))?,
        None => build_program(&target, options.release)?,
    };

    // From here on, nothing of the source tree can be imported by accident.
    let outside = folder.join("outside");
    let _ = fs::remove_dir_all(&outside);
    for part in ["tests", "notebooks", "src", "blender", "conda"] {
        copy_folder(&root.join(PACKAGE).join(part), &outside.join(part))?;
    }
    let copy_file = |from: PathBuf, name: &str| {
        let to = outside.join(name);
        fs::copy(from, &to).map(|_| ()).map_err(Failure::writing(&to))
    };
    for name in ["README.md", "pyproject.toml", "Cargo.toml", "LICENSE-MIT", "LICENSE-APACHE"] {
        copy_file(root.join(PACKAGE).join(name), name)?;
    }
    copy_folder(&root.join(PACKAGE).join("docs"), &outside.join("docs"))?;
    copy_file(root.join("docs/tutorials/python.md"), "docs/tutorial.md")?;
    let pyproject = root.join(PACKAGE).join("pyproject.toml");
    let run = |arguments: &[&str]| -> Result<(), Failure> {
        let mut python = environment.python();
        python.current_dir(&outside).args(arguments).env("CURVMESH_PROGRAM", &program);
        if options.peers {
            python.env("CURVMESH_ALL_MODELS", "1");
        }
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
    if options.peers { test_in_blender(&folder, &outside, &wheel, options) } else { Ok(()) }
}

/// Tests the add-on, in an environment of its own: Blender needs older versions of other packages.
fn test_in_blender(
    folder: &Path,
    outside: &Path,
    wheel: &Path,
    options: &Python,
) -> Result<(), Failure> {
    step("the add-on for Blender");
    let environment = VirtualEnvironment::make(&folder.join("blender"), &options.python)?;
    if environment.install(&["bpy"]).is_err() {
        println!("bpy cannot be installed here: the add-on is not tested");
        return Ok(());
    }
    environment.install(&["pytest", &wheel.to_string_lossy()])?;
    let mut python = environment.python();
    python.current_dir(outside).args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]);
    check(python.arg("tests/test_blender.py"))
}

/// The environment with all required packages of the tests, and the optional ones that can be installed.
fn environment(folder: &Path, options: &Python) -> Result<VirtualEnvironment, Failure> {
    step("the environment");
    let made = VirtualEnvironment::make(folder, &options.python)?;
    made.install(&TOOLS)?;
    let without = "nothing is tested with it";
    let large = if options.peers { &LARGE_PEERS[..] } else { &[] };
    made.install_if_there(&[&PEERS[..], &ENGINES[..], large].concat(), without);
    Ok(made)
}

/// Builds the program for comparison of results.
fn build_program(target: &Path, release: bool) -> Result<PathBuf, Failure> {
    step("the program, which results are compared with");
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--quiet", "--package", "curvmesh-cli"]);
    if release {
        cargo.arg("--release");
    }
    check(&mut cargo)?;
    let profile = if release { "release" } else { "debug" };
    Ok(target.join(profile).join(format!("curvmesh{}", env::consts::EXE_SUFFIX)))
}

fn step(name: &str) {
    println!("-- {name}");
}

fn only_file(folder: &Path) -> Result<PathBuf, Failure> {
    let entries = fs::read_dir(folder).map_err(Failure::reading(folder))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    match (files.pop(), files.is_empty()) {
        (Some(file), true) => Ok(file),
        _ => Err(Failure::Usage(format!("{} does not hold one wheel", folder.display()))),
    }
}
