//! `cargo xtask package`: a tree of crates that can be published, and a test that the packed files are sufficient.
//!
//! The registry has other crates called `mesh-core` and `simplify`, so each library gets a name that is free there:
//! `mesh-core` becomes `curvmesh-core`. Programs still import it as `mesh_core`. Every crate of the tree has its own
//! manifest without workspace inheritance, both licences and a link to its documentation; tests, examples and
//! development dependencies are omitted.
//!
//! The test: `cargo package` packs each crate, the archives are unpacked, and `docs/downstream` is built and run
//! against the unpacked files alone. The registry provides third-party crates only.

mod manifest;

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use xtask_common::{Failure, check};

use crate::files::{copy, copy_folder, empty, write};
use manifest::{Package, packages};

/// Where to write the tree, and whether to prove it.
#[derive(Debug, clap::Args)]
pub(crate) struct Pack {
    /// The folder for the tree, the archives and the proof
    #[arg(long, value_name = "DIR", default_value = "target/package")]
    out: PathBuf,
    /// Write the tree only
    #[arg(long)]
    no_build: bool,
    /// Check that the packed files compile, without building the program and running it
    #[arg(long, conflicts_with = "no_build")]
    check: bool,
}

/// The example program that stands for a third-party crate.
const DOWNSTREAM: &str = "docs/downstream";

/// An octahedron.
const INPUT: &str = "OFF\n6 8 0\n1 0 0\n-1 0 0\n0 1 0\n0 -1 0\n0 0 1\n0 0 -1\n3 0 2 4\n3 2 1 4\n3 1 3 4\n\
    3 3 0 4\n3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n";

pub(crate) fn run(options: &Pack) -> Result<(), Failure> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let out = std::path::absolute(&options.out).map_err(Failure::writing(&options.out))?;
    let tree = out.join("tree");
    empty(&tree)?;
    let packages = in_order(packages(&root)?)?;
    for package in &packages {
        write_crate(package, &root, &tree)?;
    }
    let order: Vec<&str> = packages.iter().map(|package| package.published.as_str()).collect();
    let members = order.iter().map(|name| format!("    {name:?},\n")).collect::<String>();
    let workspace = format!("[workspace]\nresolver = \"3\"\nmembers = [\n{members}]\n");
    write(&tree.join("Cargo.toml"), &workspace)?;
    copy(&root.join("Cargo.lock"), &tree.join("Cargo.lock"))?;
    let steps = order.iter().map(|name| format!("cargo publish -p {name}\n")).collect::<String>();
    write(
        &tree.join("publish.sh"),
        &format!(
            "#!/bin/sh\n# In this order: each crate after the ones it needs.\nset -e\n{steps}"
        ),
    )?;
    println!("{}: {} crates, in the order of publication:", tree.display(), order.len());
    println!("{}", order.join(", "));
    if options.no_build { Ok(()) } else { prove(&packages, &root, &out, options.check) }
}

/// Each crate after its dependencies.
fn in_order(mut open: Vec<Package>) -> Result<Vec<Package>, Failure> {
    let mut done: Vec<Package> = Vec::new();
    while !open.is_empty() {
        let known: BTreeSet<&str> = done.iter().map(|package| package.name.as_str()).collect();
        let is_ready =
            |package: &Package| package.needs.iter().all(|name| known.contains(name.as_str()));
        let (ready, rest): (Vec<Package>, Vec<Package>) = open.into_iter().partition(is_ready);
        if ready.is_empty() {
            let names: Vec<String> = rest.into_iter().map(|package| package.name).collect();
            return Err(Failure::Check(format!(
                "{} depend on each other or on crates that are not published",
                names.join(", ")
            )));
        }
        done.extend(ready);
        open = rest;
    }
    Ok(done)
}

/// Copies the sources, the page and the licences, and writes the manifest.
fn write_crate(package: &Package, root: &Path, tree: &Path) -> Result<(), Failure> {
    let folder = tree.join(&package.published);
    copy_folder(&package.folder.join("src"), &folder.join("src"))?;
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
        copy(&root.join(licence), &folder.join(licence))?;
    }
    let page = package.folder.join("README.md");
    let text = fs::read_to_string(&page).map_err(Failure::reading(&page))?;
    write(&folder.join("README.md"), &package.page(&text))?;
    write(&folder.join("Cargo.toml"), &package.manifest)
}

/// Packs the tree, unpacks the archives, and compiles them and a program that has nothing else; runs the program,
/// except with `only_check`.
fn prove(packages: &[Package], root: &Path, out: &Path, only_check: bool) -> Result<(), Failure> {
    let target = out.join("target");
    let mut pack = cargo();
    pack.args(["package", "--workspace", "--no-verify", "--allow-dirty", "--quiet"]);
    pack.arg("--manifest-path").arg(out.join("tree").join("Cargo.toml"));
    check(pack.arg("--target-dir").arg(&target))?;
    let unpacked = out.join("unpacked");
    empty(&unpacked)?;
    let (mut members, mut patches) = (String::new(), String::new());
    for package in packages {
        let stem = format!("{}-{}", package.published, package.version);
        let archive = target.join("package").join(format!("{stem}.crate"));
        // With the time of now (`m`): all packed files have one date, so cargo would take changed ones for unchanged.
        check(Command::new("tar").arg("-xmzf").arg(&archive).arg("-C").arg(&unpacked))?;
        require_files(&unpacked.join(&stem))?;
        members += &format!("    {stem:?},\n");
        patches += &format!("{} = {{ path = {stem:?} }}\n", package.published);
    }
    let workspace = format!(
        "[workspace]\nresolver = \"3\"\nmembers = [\n    \"downstream\",\n{members}]\n\n[patch.crates-io]\n{patches}"
    );
    write(&unpacked.join("Cargo.toml"), &workspace)?;
    copy(&root.join("Cargo.lock"), &unpacked.join("Cargo.lock"))?;
    let downstream = unpacked.join("downstream");
    copy_folder(&root.join(DOWNSTREAM).join("src"), &downstream.join("src"))?;
    write(&downstream.join("Cargo.toml"), &manifest::of_user(&root.join(DOWNSTREAM), packages)?)?;
    require_packed(&unpacked, packages)?;
    let (input, output) = (downstream.join("in.off"), downstream.join("out.glb"));
    write(&input, INPUT)?;
    let on_proof = |command: &str| {
        let mut cargo = cargo();
        cargo.args([command, "--quiet", "--manifest-path"]).arg(unpacked.join("Cargo.toml"));
        cargo.arg("--target-dir").arg(&target);
        cargo
    };
    check(on_proof("check").arg("--workspace"))?;
    if only_check {
        println!("the packed files alone compile, and so does a program made from them");
        return Ok(());
    }
    check(on_proof("run").args(["--package", "downstream", "--"]).arg(&input).arg(&output))?;
    let bytes = fs::metadata(&output).map_err(Failure::reading(&output))?.len();
    println!("the packed files alone build; a program made from them wrote {bytes} bytes");
    Ok(())
}

/// Checks that an unpacked crate has its licences and its page.
fn require_files(folder: &Path) -> Result<(), Failure> {
    for name in ["LICENSE-APACHE", "LICENSE-MIT", "README.md"] {
        let path = folder.join(name);
        fs::metadata(&path).map_err(Failure::reading(&path))?;
    }
    Ok(())
}

/// Checks that every crate of ours is the unpacked one, and that no crate from the registry has the name of one of our
/// crates in this repository.
fn require_packed(unpacked: &Path, packages: &[Package]) -> Result<(), Failure> {
    let resolved = manifest::metadata(&unpacked.join("Cargo.toml"), &[])?;
    for found in resolved["packages"].as_array().into_iter().flatten() {
        let name = found["name"].as_str().unwrap_or_default();
        let manifest = Path::new(found["manifest_path"].as_str().unwrap_or_default());
        let is_ours = packages.iter().any(|package| package.published == name);
        if is_ours && !manifest.starts_with(unpacked) {
            return Err(Failure::Check(format!(
                "{name} is {}, not the packed one",
                manifest.display()
            )));
        }
        if !is_ours && packages.iter().any(|package| package.name == name) {
            let source = found["source"].as_str().unwrap_or("a path");
            return Err(Failure::Check(format!("{name} of {source} takes the place of ours")));
        }
    }
    Ok(())
}

fn cargo() -> Command {
    Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}
