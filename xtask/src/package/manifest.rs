//! Manifests of the packed crates, generated from the output of `cargo metadata`.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use xtask_common::Failure;

/// A crate of the workspace to be published.
pub(crate) struct Package {
    /// The name in this repository.
    pub(crate) name: String,
    /// The name in the registry.
    pub(crate) published: String,
    pub(crate) version: String,
    pub(crate) folder: PathBuf,
    /// Its dependencies in this repository, by their names here.
    pub(crate) needs: Vec<String>,
    /// The text of `Cargo.toml`.
    pub(crate) manifest: String,
}

impl Package {
    /// The README of the crate, with its name in the registry.
    pub(crate) fn page(&self, text: &str) -> String {
        let (title, rest) = text.split_once('\n').unwrap_or((text, ""));
        if self.published == self.name {
            return text.to_owned();
        }
        let imported = self.name.replace('-', "_");
        let note = format!(
            "The registry has this crate as `{}`; code imports it as `{imported}`.",
            self.published
        );
        format!("{title}\n\n{note}\n{rest}")
    }
}

/// The name of a crate in the registry: `mesh-io` is `curvmesh-io`, `dcurv` is `curvmesh-dcurv`.
pub(crate) fn published_name(name: &str) -> String {
    match name.strip_prefix("curvmesh") {
        Some("") => name.to_owned(),
        Some(rest) if rest.starts_with('-') => name.to_owned(),
        _ => format!("curvmesh-{}", name.strip_prefix("mesh-").unwrap_or(name)),
    }
}

/// The output of `cargo metadata`.
pub(crate) fn metadata(manifest: &Path, options: &[&str]) -> Result<Value, Failure> {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo
        .args(["metadata", "--format-version", "1", "--manifest-path"])
        .arg(manifest)
        .args(options);
    let output = cargo.output().map_err(Failure::reading(manifest))?;
    if !output.status.success() {
        return Err(Failure::Check(String::from_utf8_lossy(&output.stderr).into_owned()));
    }
    serde_json::from_slice(&output.stdout).map_err(Failure::reading(manifest))
}

/// All crates of the workspace that may be published.
pub(crate) fn packages(root: &Path) -> Result<Vec<Package>, Failure> {
    let metadata = metadata(&root.join("Cargo.toml"), &["--no-deps"])?;
    let all = metadata["packages"].as_array().cloned().unwrap_or_default();
    Ok(all.iter().filter(|package| package["publish"].is_null()).map(package).collect())
}

fn package(package: &Value) -> Package {
    let name = text(&package["name"]);
    let needs = dependencies(package).filter(|d| d["path"].is_string());
    Package {
        published: published_name(&name),
        version: text(&package["version"]),
        folder: Path::new(&text(&package["manifest_path"])).with_file_name(""),
        needs: needs.map(|dependency| text(&dependency["name"])).collect(),
        manifest: manifest(package, &published_name(&name)),
        name,
    }
}

/// The manifest of `docs/downstream`, with the packed crates of the registry in place of paths.
pub(crate) fn of_user(folder: &Path, packages: &[Package]) -> Result<String, Failure> {
    let metadata = metadata(&folder.join("Cargo.toml"), &["--no-deps"])?;
    let mut manifest = String::from(
        "[package]\nname = \"downstream\"\nversion = \"0.0.0\"\nedition = \"2024\"\npublish = false\n\n[dependencies]\n",
    );
    for dependency in dependencies(&metadata["packages"][0]) {
        let name = text(&dependency["name"]);
        let package = packages.iter().find(|package| package.name == name).ok_or_else(|| {
            Failure::Check(format!("{} depends on {name}, which is not packed", folder.display()))
        })?;
        let Package { published, version, .. } = package;
        manifest += &format!("{name} = {{ package = {published:?}, version = {version:?} }}\n");
    }
    Ok(manifest)
}

/// The dependencies that users of the crate need too.
fn dependencies(package: &Value) -> impl Iterator<Item = &Value> {
    package["dependencies"].as_array().into_iter().flatten().filter(|d| d["kind"] != "dev")
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

/// Strings and arrays of strings have the same notation in JSON and TOML.
fn manifest(package: &Value, published: &str) -> String {
    let mut manifest = format!("[package]\nname = {published:?}\n");
    let fields = [
        "version",
        "edition",
        "rust_version",
        "description",
        "license",
        "authors",
        "keywords",
        "categories",
    ];
    for field in fields {
        let value = &package[field];
        if !value.is_null() {
            manifest += &format!("{} = {value}\n", field.replace('_', "-"));
        }
    }
    manifest +=
        &format!("documentation = \"https://docs.rs/{published}\"\nreadme = \"README.md\"\n");
    manifest += "autotests = false\nautoexamples = false\nautobenches = false\n\n";
    manifest += "[package.metadata.docs.rs]\nall-features = true\n";
    for target in package["targets"].as_array().into_iter().flatten() {
        match target["kind"][0].as_str() {
            Some("lib") => manifest += &format!("\n[lib]\nname = {}\n", target["name"]),
            Some("bin") => {
                manifest +=
                    &format!("\n[[bin]]\nname = {}\npath = \"src/main.rs\"\n", target["name"]);
            }
            _ => {}
        }
    }
    manifest += "\n[features]\n";
    for (name, enabled) in package["features"].as_object().into_iter().flatten() {
        manifest += &format!("{name} = {enabled}\n");
    }
    for dependency in dependencies(package) {
        manifest += &entry(dependency);
    }
    manifest
}

/// A dependency under its name in the code.
fn entry(dependency: &Value) -> String {
    let name = text(&dependency["name"]);
    let key = dependency["rename"].as_str().unwrap_or(&name);
    let section = match dependency["kind"].as_str() {
        Some("build") => "build-dependencies",
        _ => "dependencies",
    };
    let target = dependency["target"].as_str().map(|target| format!("target.'{target}'."));
    let mut entry = format!("\n[{}{section}.{key}]\n", target.unwrap_or_default());
    entry += &format!("version = {}\n", dependency["req"]);
    if dependency["path"].is_string() {
        let published = published_name(&name);
        entry += &format!("package = {published:?}\npath = \"../{published}\"\n");
    } else if key != name {
        entry += &format!("package = {name:?}\n");
    }
    if dependency["uses_default_features"] == false {
        entry += "default-features = false\n";
    }
    if dependency["features"].as_array().is_some_and(|features| !features.is_empty()) {
        entry += &format!("features = {}\n", dependency["features"]);
    }
    if dependency["optional"] == true {
        entry += "optional = true\n";
    }
    entry
}

#[cfg(test)]
mod tests {
    use super::published_name;

    #[test]
    fn names_of_the_registry_begin_with_curvmesh() {
        for (name, published) in [
            ("mesh-core", "curvmesh-core"),
            ("dcurv", "curvmesh-dcurv"),
            ("out-of-core", "curvmesh-out-of-core"),
            ("curvmesh", "curvmesh"),
            ("curvmesh-cli", "curvmesh-cli"),
        ] {
            assert_eq!(published_name(name), published);
        }
    }
}
