//! `cargo xtask deny`: whether the dependencies are what `deny.toml` allows.
//!
//! The file is that of `cargo-deny`, which can be run on it as well. This is the part of it that
//! needs no database: licences, versions and sources, from `cargo metadata`. It takes a second
//! where building `cargo-deny` takes minutes, so that it can be part of every check. A setting that
//! is not known here is an error, never passed over.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::process::Command;

use serde::Deserialize;
use spdx::{Expression, LicenseReq, ParseMode};

use crate::failure::Failure;

/// Where the rules are.
#[derive(Debug, clap::Args)]
pub(crate) struct Deny {
    /// The rules
    #[arg(long, value_name = "FILE", default_value = "deny.toml")]
    rules: PathBuf,
}

/// The rules, named as in `cargo-deny`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Rules {
    graph: Graph,
    licenses: Licenses,
    bans: Bans,
    sources: Sources,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Graph {
    all_features: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Licenses {
    allow: Vec<String>,
    private: Private,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Private {
    ignore: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Bans {
    multiple_versions: Denied,
    wildcards: Denied,
    allow_wildcard_paths: bool,
    skip: Vec<Skip>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Sources {
    unknown_registry: Denied,
    unknown_git: Denied,
    /// Only that of cargo when none is named.
    #[serde(default)]
    allow_registry: BTreeSet<String>,
}

/// What has no other setting here.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Denied {
    Deny,
}

/// A version that may be there beside another.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Skip {
    #[serde(rename = "crate")]
    package: String,
    reason: String,
}

/// What `cargo metadata` prints, as far as it matters.
#[derive(Debug, Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    resolve: Resolve,
}

#[derive(Debug, Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Debug, Deserialize)]
struct Node {
    id: String,
}

#[derive(Debug, Deserialize)]
struct Package {
    id: String,
    name: String,
    version: String,
    license: Option<String>,
    /// None for crates of this workspace.
    source: Option<String>,
    /// Empty for crates that are not published.
    publish: Option<Vec<String>>,
    dependencies: Vec<Dependency>,
}

#[derive(Debug, Deserialize)]
struct Dependency {
    name: String,
    req: String,
    path: Option<PathBuf>,
}

impl Package {
    fn full_name(&self) -> String {
        format!("{}@{}", self.name, self.version)
    }

    fn is_private(&self) -> bool {
        self.publish.as_ref().is_some_and(Vec::is_empty)
    }
}

/// What is built by itself, each with a Cargo.lock.
const WORKSPACES: [&str; 2] = ["Cargo.toml", "crates/python/Cargo.toml"];

/// Prints what breaks the rules.
pub(crate) fn run(options: &Deny) -> Result<(), Failure> {
    let text = std::fs::read_to_string(&options.rules)
        .map_err(|source| Failure::Input { path: options.rules.clone(), source })?;
    let rules: Rules = toml::from_str(&text).map_err(Failure::mesh)?;
    let workspaces = WORKSPACES
        .iter()
        .map(|manifest| packages(manifest, rules.graph.all_features))
        .collect::<Result<Vec<_>, _>>()?;
    let breaches = breaches(&rules, &workspaces);
    breaches.iter().for_each(|breach| eprintln!("{breach}"));
    println!("{} crates, {} breaches of a rule", distinct(&workspaces).len(), breaches.len());
    if breaches.is_empty() { Ok(()) } else { Err(Failure::Denied(breaches.len())) }
}

/// All crates that a workspace is made of on any platform, those for tests included.
fn packages(manifest: &str, all_features: bool) -> Result<Vec<Package>, Failure> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(["metadata", "--format-version", "1", "--locked", "--manifest-path", manifest]);
    if all_features {
        command.arg("--all-features");
    }
    let output = command.stderr(std::process::Stdio::inherit()).output();
    let output = output.map_err(|error| Failure::Usage(format!("cannot run cargo: {error}")))?;
    if !output.status.success() {
        return Err(Failure::Usage("cargo metadata failed".into()));
    }
    let metadata: Metadata = serde_json::from_slice(&output.stdout).map_err(Failure::mesh)?;
    let used: BTreeSet<String> = metadata.resolve.nodes.into_iter().map(|node| node.id).collect();
    Ok(metadata.packages.into_iter().filter(|package| used.contains(&package.id)).collect())
}

fn breaches(rules: &Rules, workspaces: &[Vec<Package>]) -> Vec<String> {
    let packages = distinct(workspaces);
    let mut breaches = licences(&rules.licenses, &packages);
    breaches.extend(versions(&rules.bans, workspaces));
    breaches.extend(wildcards(&rules.bans, &packages));
    breaches.extend(sources(&rules.sources, &packages));
    breaches
}

/// Each crate once, however many workspaces use it.
fn distinct(workspaces: &[Vec<Package>]) -> Vec<&Package> {
    let mut seen = BTreeSet::new();
    workspaces.iter().flatten().filter(|package| seen.insert(package.id.as_str())).collect()
}

fn licences(rules: &Licenses, packages: &[&Package]) -> Vec<String> {
    let mut breaches = Vec::new();
    let mut used = BTreeSet::new();
    for package in packages {
        if rules.private.ignore && package.is_private() {
            continue;
        }
        let name = package.full_name();
        let Some(license) = &package.license else {
            breaches.push(format!("{name} names no licence"));
            continue;
        };
        let Ok(expression) = Expression::parse_mode(license, ParseMode::LAX) else {
            breaches.push(format!("{name} has a licence that is no SPDX expression: {license}"));
            continue;
        };
        let is_allowed = |required: &LicenseReq| rules.allow.contains(&required.to_string());
        if !expression.evaluate(is_allowed) {
            breaches.push(format!("{name} is under {license}, which is not allowed"));
        }
        used.extend(expression.requirements().map(|required| required.req.to_string()));
    }
    let unused = rules.allow.iter().filter(|license| !used.contains(*license));
    breaches.extend(unused.map(|license| format!("nothing is under {license}: do not allow it")));
    breaches
}

/// Nothing is there twice that is built together.
fn versions(rules: &Bans, workspaces: &[Vec<Package>]) -> Vec<String> {
    let Denied::Deny = rules.multiple_versions;
    let skipped: BTreeSet<&str> = rules.skip.iter().map(|skip| skip.package.as_str()).collect();
    let mut breaches = BTreeSet::new();
    let mut needed = BTreeSet::new();
    for packages in workspaces {
        let mut versions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for package in packages.iter().filter(|p| !skipped.contains(p.full_name().as_str())) {
            versions.entry(&package.name).or_default().push(&package.version);
        }
        let several = versions.iter().filter(|(_, versions)| versions.len() > 1);
        breaches.extend(several.map(|(name, versions)| {
            format!("{name} is there in versions {}", versions.join(", "))
        }));
        let names = packages.iter().map(Package::full_name);
        needed.extend(names.filter(|name| {
            let name = name.split('@').next().unwrap_or_default();
            versions.contains_key(name)
        }));
    }
    for Skip { package, reason } in &rules.skip {
        if !workspaces.iter().flatten().any(|p| p.full_name() == *package) {
            breaches.insert(format!("{package} is not there any more: do not skip it ({reason})"));
        } else if !needed.contains(package) {
            breaches.insert(format!("{package} is the only version: do not skip it ({reason})"));
        }
    }
    breaches.into_iter().collect()
}

/// Crates of this workspace say which versions they work with.
fn wildcards(rules: &Bans, packages: &[&Package]) -> Vec<String> {
    let Denied::Deny = rules.wildcards;
    let own = packages.iter().filter(|package| package.source.is_none());
    let is_wild = |package: &Package, dependency: &Dependency| {
        let is_path = dependency.path.is_some() && rules.allow_wildcard_paths;
        dependency.req == "*" && !(is_path && package.is_private())
    };
    own.flat_map(|package| {
        let wild = package.dependencies.iter().filter(move |d| is_wild(package, d));
        wild.map(|dependency| format!("{} takes any version of {}", package.name, dependency.name))
    })
    .collect()
}

fn sources(rules: &Sources, packages: &[&Package]) -> Vec<String> {
    let (Denied::Deny, Denied::Deny) = (rules.unknown_registry, rules.unknown_git);
    let is_allowed = |source: &str| {
        let registry = source.strip_prefix("registry+").or(source.strip_prefix("sparse+"));
        registry.is_some_and(|registry| match rules.allow_registry.is_empty() {
            true => registry.ends_with("/crates.io-index"),
            false => rules.allow_registry.contains(registry),
        })
    };
    let foreign = packages.iter().filter_map(|package| {
        let source = package.source.as_deref().filter(|source| !is_allowed(source))?;
        Some(format!("{} comes from {source}", package.full_name()))
    });
    foreign.collect()
}

#[cfg(test)]
mod tests {
    use super::{Dependency, Package, Rules, breaches};

    const RULES: &str = r#"
        graph.all-features = true
        licenses = { allow = ["MIT", "Zlib"], private.ignore = true }
        bans = { multiple-versions = "deny", wildcards = "deny", allow-wildcard-paths = true, skip = [{ crate = "b@1.0.0", reason = "old" }] }
        sources = { unknown-registry = "deny", unknown-git = "deny", allow-registry = ["https://crates"] }
    "#;

    fn package(name: &str, version: &str, license: Option<&str>, source: Option<&str>) -> Package {
        Package {
            id: format!("{name} {version}"),
            name: name.into(),
            version: version.into(),
            license: license.map(str::to_owned),
            source: source.map(str::to_owned),
            publish: None,
            dependencies: Vec::new(),
        }
    }

    fn found(packages: Vec<Package>) -> Vec<String> {
        found_in(&[packages])
    }

    fn found_in(workspaces: &[Vec<Package>]) -> Vec<String> {
        let rules: Rules = toml::from_str(RULES).expect("the rules are well-formed");
        breaches(&rules, workspaces)
    }

    #[test]
    fn every_rule_is_checked() {
        let home = Some("registry+https://crates");
        let good = || {
            vec![
                package("a", "1.0.0", Some("MIT OR GPL-3.0"), home),
                package("b", "1.0.0", Some("MIT/Apache-2.0"), home),
                package("b", "2.0.0", Some("(MIT OR Apache-2.0) AND Zlib"), home),
            ]
        };
        assert_eq!(found(good()), Vec::<String>::new());

        let with = |package: Package| {
            let mut packages = good();
            packages.push(package);
            found(packages)
        };
        let one = |breaches: Vec<String>, text: &str| {
            assert!(breaches.len() == 1 && breaches[0].contains(text), "{breaches:?}");
        };
        one(with(package("c", "1.0.0", Some("GPL-3.0"), home)), "c@1.0.0 is under GPL-3.0");
        one(with(package("c", "1.0.0", Some("MIT AND GPL-3.0"), home)), "which is not allowed");
        one(with(package("c", "1.0.0", None, home)), "names no licence");
        one(with(package("c", "1.0.0", Some("good"), home)), "no SPDX expression");
        one(with(package("a", "2.0.0", Some("MIT"), home)), "a is there in versions 1.0.0, 2.0.0");
        one(with(package("c", "1.0.0", Some("MIT"), Some("git+https://crates"))), "comes from git");
        one(with(package("c", "1.0.0", Some("MIT"), Some("registry+https://x"))), "comes from");
        let mut wild = package("c", "1.0.0", Some("MIT"), None);
        wild.dependencies = vec![Dependency { name: "a".into(), req: "*".into(), path: None }];
        one(with(wild), "c takes any version of a");

        let mut private = package("c", "1.0.0", None, None);
        private.publish = Some(Vec::new());
        assert_eq!(with(private), Vec::<String>::new());

        let fewer = || {
            let mut fewer = good();
            fewer.remove(1);
            fewer
        };
        one(found(fewer()), "b@1.0.0 is not there any more");
        let mut fewest = fewer();
        fewest.pop();
        assert_eq!(found(fewest).len(), 2);

        // Another workspace may have another version, but no other licence.
        let other = || vec![package("a", "2.0.0", Some("MIT"), home)];
        assert_eq!(found_in(&[good(), other()]), Vec::<String>::new());
        let bad = vec![package("c", "1.0.0", Some("GPL-3.0"), home)];
        one(found_in(&[good(), bad]), "c@1.0.0 is under GPL-3.0");
        // What is skipped in one of them only is skipped.
        let alone = vec![package("b", "1.0.0", Some("MIT"), home)];
        assert_eq!(found_in(&[good(), alone]), Vec::<String>::new());
    }

    #[test]
    fn settings_that_are_not_known_are_refused() {
        let more = format!("{RULES}\nadvisories.yanked = \"deny\"");
        assert!(toml::from_str::<Rules>(&more).is_err());
    }
}
