//! `cargo xtask release --dry-run`: builds and tests the Python package as published.
//!
//! The committed files are exported to `target/publish/tree`; wheel and source distribution are built there. Both must
//! contain the licences and pass `twine check --strict`. The wheel is installed in an empty environment, runs the first
//! lines of its README and the program, and is uninstalled. The source distribution is built once by pip. At the end
//! the commands are printed that only a maintainer can run.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use xtask_common::{Failure, VirtualEnvironment, check};

/// How to build and try a release.
#[derive(Debug, clap::Args)]
pub(crate) struct Release {
    /// Publish nothing; required, since only a maintainer can publish
    #[arg(long, required = true)]
    dry_run: bool,
    /// Build in the dev profile, which takes a tenth of the time
    #[arg(long)]
    quick: bool,
    /// The address of the repository, for the links of the package
    #[arg(long, value_name = "URL")]
    repository: Option<String>,
    /// The oldest C library that the wheel runs on
    #[arg(long, value_name = "TAG", default_value = "manylinux_2_28")]
    manylinux: String,
    /// Do not build the source distribution with pip
    #[arg(long)]
    skip_source_build: bool,
    /// The Python that environments are made with
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: String,
}

/// The tools that build and check; zig links against an old C library.
const TOOLS: [&str; 3] = ["maturin>=1.9,<2", "ziglang", "twine"];

/// The files that both packages must contain.
const LICENCES: [&str; 2] = ["LICENSE-MIT", "LICENSE-APACHE"];

pub(crate) fn run(options: &Release) -> Result<(), Failure> {
    let root = env::current_dir().map_err(Failure::reading(Path::new(".")))?;
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let folder = target.join("publish");
    let (tree, packages) = (folder.join("tree"), folder.join("dist"));
    for old in [&tree, &packages] {
        let _ = fs::remove_dir_all(old);
    }
    fs::create_dir_all(&tree).map_err(Failure::writing(&tree))?;
    step("the committed files");
    let archive = folder.join("tree.tar");
    check(Command::new("git").args(["archive", "--format=tar", "-o"]).arg(&archive).arg("HEAD"))?;
    check(Command::new("tar").arg("-xf").arg(&archive).arg("-C").arg(&tree))?;
    let package = tree.join("crates/python");
    if let Some(repository) = &options.repository {
        add_links(&package, repository.trim_end_matches('/'))?;
    }

    step("tools");
    let tools = VirtualEnvironment::make(&folder.join("tools"), &options.python)?;
    tools.install(&TOOLS)?;
    step("the wheel");
    let mut wheel = Command::new(tools.program("maturin"));
    wheel.args(["build", "--quiet", "--out"]).arg(&packages).arg("--manifest-path");
    wheel.arg(package.join("Cargo.toml")).arg("--target-dir").arg(&target);
    wheel.args(["--profile", if options.quick { "dev" } else { "release" }, "--strip"]);
    if cfg!(target_os = "linux") {
        wheel.args(["--zig", "--compatibility", &options.manylinux]);
    }
    check(with_tools(&mut wheel, &tools))?;
    step("the source distribution");
    let mut source = Command::new(tools.program("maturin"));
    source.args(["sdist", "--out"]).arg(&packages).arg("--manifest-path");
    check(source.arg(package.join("Cargo.toml")))?;

    let (wheel, source) = (built(&packages, "whl")?, built(&packages, "gz")?);
    step("checks");
    let list = "import sys, tarfile, zipfile; p = sys.argv[1]; \
                print(*(zipfile.ZipFile(p).namelist() if p.endswith('whl') else tarfile.open(p).getnames()), sep='\\n')";
    for package in [&wheel, &source] {
        let listing = tools.python().args(["-c", list]).arg(package).output();
        let names = listing.map_err(Failure::reading(package))?.stdout;
        let names = String::from_utf8_lossy(&names);
        for licence in LICENCES {
            if !names.lines().any(|name| name.ends_with(licence)) {
                return Err(Failure::Usage(format!("{} has no {licence}", package.display())));
            }
        }
    }
    check(tools.python().args(["-m", "twine", "check", "--strict"]).args([&wheel, &source]))?;
    try_wheel(&folder, &package, &wheel, options)?;
    if !options.skip_source_build {
        step("the source distribution, built by pip");
        let mut pip = tools.python();
        pip.args(["-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir"]);
        pip.arg(folder.join("from-source")).arg(&source).env("CARGO_TARGET_DIR", &target);
        check(pip.env("MATURIN_PEP517_ARGS", if options.quick { "--profile dev" } else { "" }))?;
    }
    what_is_left(&wheel, &source, options);
    Ok(())
}

/// Installs the wheel in an empty environment, uses it, and uninstalls it.
fn try_wheel(
    folder: &Path,
    package: &Path,
    wheel: &Path,
    options: &Release,
) -> Result<(), Failure> {
    step("the wheel in an empty environment");
    let empty = folder.join("empty");
    let _ = fs::remove_dir_all(&empty);
    let environment = VirtualEnvironment::make(&empty, &options.python)?;
    let bare = |command: &mut Command| -> Result<(), Failure> {
        command.env_clear().env("PATH", "/usr/bin:/bin").env("HOME", folder).current_dir(folder);
        check(command)
    };
    let pip = || {
        let mut pip = environment.python();
        pip.args(["-m", "pip", "--quiet", "--disable-pip-version-check"]);
        pip
    };
    bare(pip().arg("install").arg(wheel))?;
    let readme = package.join("README.md");
    let text = fs::read_to_string(&readme).map_err(Failure::reading(&readme))?;
    let first = text.split("```python\n").nth(1).and_then(|part| part.split("```").next());
    let first = first.ok_or_else(|| Failure::Usage("the README has no example".into()))?;
    let lines =
        format!("import curvmesh\ncurvmesh.write('scan.ply', curvmesh.examples.scan(4))\n{first}");
    bare(environment.python().args(["-c", &lines]))?;
    bare(Command::new(environment.program("curvmesh")).args(["info", "small.glb"]))?;
    bare(pip().args(["uninstall", "--yes", "curvmesh"]))?;
    if environment.program("curvmesh").exists() {
        return Err(Failure::Usage("the program is left after `pip uninstall`".into()));
    }
    Ok(())
}

/// Adds links to the repository to the package, and turns links of its README into addresses.
fn add_links(package: &Path, repository: &str) -> Result<(), Failure> {
    let edit = |name: &str, change: &dyn Fn(String) -> String| {
        let path = package.join(name);
        let text = fs::read_to_string(&path).map_err(Failure::reading(&path))?;
        fs::write(&path, change(text)).map_err(Failure::writing(&path))
    };
    let pages = format!("{repository}/blob/main");
    edit("pyproject.toml", &|text| {
        format!(
            "{text}\n[project.urls]\nRepository = \"{repository}\"\n\
             Documentation = \"{pages}/crates/python/README.md\"\n\
             Changelog = \"{pages}/CHANGELOG.md\"\nIssues = \"{repository}/issues\"\n"
        )
    })?;
    edit("README.md", &|text| text.replace("](docs/", &format!("]({pages}/crates/python/docs/")))
}

/// Prints the commands for a maintainer.
fn what_is_left(wheel: &Path, source: &Path, options: &Release) {
    let version = env!("CARGO_PKG_VERSION");
    println!("-- left for a maintainer");
    if options.repository.is_none() {
        println!(
            "cargo xtask release --dry-run --repository URL    # the packages above have no links"
        );
    }
    if options.quick {
        println!(
            "cargo xtask release --dry-run                     # the packages above are not optimised"
        );
    }
    println!("git tag -s v{version} && git push origin v{version}");
    println!("twine upload {} {}", wheel.display(), source.display());
    println!("sha256sum {}    # for the recipe of conda-forge:", source.display());
    println!("    crates/python/conda/recipe.yaml says what a feedstock changes in it");
}

/// The only package of this kind.
fn built(folder: &Path, extension: &str) -> Result<PathBuf, Failure> {
    let entries = fs::read_dir(folder).map_err(Failure::reading(folder))?;
    let paths = entries.flatten().map(|entry| entry.path());
    let found = paths.filter(|path| path.extension().is_some_and(|found| found == extension));
    let path = found.last();
    let path = path.ok_or_else(|| Failure::Usage(format!("no .{extension} file was built")))?;
    let bytes = fs::metadata(&path).map_err(Failure::reading(&path))?.len();
    println!("{} ({:.1} MB)", path.display(), bytes as f64 / 1e6);
    Ok(path)
}

/// The command with the tools of the environment on its path.
fn with_tools<'a>(command: &'a mut Command, tools: &VirtualEnvironment) -> &'a mut Command {
    let programs = tools.program("python").parent().map(Path::to_path_buf).unwrap_or_default();
    let path = env::var_os("PATH").unwrap_or_default();
    let all = env::join_paths([programs].into_iter().chain(env::split_paths(&path)));
    command.env("PATH", all.unwrap_or(path)).env("VIRTUAL_ENV", &tools.folder)
}

fn step(name: &str) {
    println!("-- {name}");
}
