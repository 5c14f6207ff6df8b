//! Tests of the command line.
#![allow(clippy::unwrap_used)]

use std::process::Command;

fn xtask(arguments: &[&str]) -> (bool, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_xtask")).args(arguments).output().unwrap();
    (output.status.success(), String::from_utf8_lossy(&output.stdout).into_owned())
}

#[test]
fn the_modules_of_this_workspace_form_no_circle() {
    let (is_good, said) = xtask(&["circles"]);
    assert!(is_good, "{said}");
    let packages: usize = said.split_whitespace().next().unwrap().parse().unwrap();
    assert!(packages > 15, "{said}");
}

/// Only the tree; `.ci/run` builds a program from it.
#[test]
fn packed_crates_have_names_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let (is_good, said) =
        xtask(&["package", "--no-build", "--out", &folder.path().to_string_lossy()]);
    assert!(is_good, "{said}");
    let order: Vec<&str> = said.lines().last().unwrap().split(", ").collect();
    let place = |name: &str| order.iter().position(|found| *found == name).unwrap();
    assert!(order.iter().all(|name| name.starts_with("curvmesh")), "{order:?}");
    assert!(place("curvmesh-core") < place("curvmesh-dcurv"));
    assert!(place("curvmesh-simplify") < place("curvmesh"));
    for name in &order {
        let krate = folder.path().join("tree").join(name);
        for file in ["Cargo.toml", "LICENSE-APACHE", "LICENSE-MIT", "README.md", "src"] {
            assert!(krate.join(file).exists(), "{name}: {file}");
        }
    }
}
