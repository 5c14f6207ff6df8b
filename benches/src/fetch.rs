//! `cargo run -p benches -- fetch`: the meshes of the benchmark, from a folder or from their public repositories.
//!
//! The list is `benches/data.toml`. A file whose SHA-256 differs from the list is refused.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;
use sha2::{Digest, Sha256};

use crate::command_output::command_output;
use xtask_common::Failure;

/// What to fetch, and where to.
#[derive(Debug, clap::Args)]
pub(crate) struct Fetch {
    /// The folder for the meshes
    #[arg(long, value_name = "DIR")]
    to: PathBuf,
    /// A folder with some of the files already, under their names in the list
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Which meshes, by their names in the list; all by default
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    meshes: Vec<String>,
    /// Another list than benches/data.toml
    #[arg(long, value_name = "FILE")]
    list: Option<PathBuf>,
    /// Use the folder of --cache alone
    #[arg(long)]
    offline: bool,
}

/// The list of meshes.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    mesh: Vec<Mesh>,
}

/// A file of a commit of a public repository.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Mesh {
    /// The name here.
    name: String,
    /// What git clones.
    repository: String,
    commit: String,
    /// The path in the repository.
    path: String,
    /// In hexadecimal digits.
    sha256: String,
    /// As far as it is known.
    licence: String,
    /// The group in which it is compared.
    class: String,
    kind: String,
}

/// The list that is part of this program.
const LIST: &str = include_str!("../data.toml");

/// The class of the file with this hash, if the list has the file.
pub(crate) fn class(sha256: &str) -> Result<Option<String>, Failure> {
    let List { mesh: meshes } = toml::from_str(LIST).map_err(Failure::numbers)?;
    Ok(meshes.into_iter().find(|mesh| mesh.sha256 == sha256).map(|mesh| mesh.class))
}

/// Whether the list has a file of this name.
#[cfg(test)]
pub(crate) fn has(name: &str) -> Result<bool, Failure> {
    let List { mesh: meshes } = toml::from_str(LIST).map_err(Failure::numbers)?;
    Ok(meshes.iter().any(|mesh| mesh.name == name))
}

/// Fetches what is not there yet, and says what could not be had.
pub(crate) fn run(options: &Fetch) -> Result<(), Failure> {
    let text = match &options.list {
        Some(path) => std::fs::read_to_string(path).map_err(Failure::reading(path))?,
        None => LIST.to_owned(),
    };
    let List { mesh: mut meshes } = toml::from_str(&text).map_err(Failure::numbers)?;
    for name in &options.meshes {
        if !meshes.iter().any(|mesh| mesh.name == *name) {
            return Err(Failure::Usage(format!("the list has no mesh {name}")));
        }
    }
    meshes.retain(|mesh| options.meshes.is_empty() || options.meshes.contains(&mesh.name));
    std::fs::create_dir_all(&options.to).map_err(Failure::writing(&options.to))?;
    let mut lacks = 0;
    for mesh in &meshes {
        let Mesh { name, licence, kind, .. } = mesh;
        match fetch(mesh, options) {
            Ok(from) => println!("{name}: {from} ({kind}; licence: {licence})"),
            Err(why) => {
                lacks += 1;
                println!("{name}: {why}");
            }
        }
    }
    match lacks {
        0 => Ok(()),
        _ => Err(Failure::Check(format!("{lacks} of {} meshes could not be had", meshes.len()))),
    }
}

/// Puts a mesh into the folder; returns where it is from.
fn fetch(mesh: &Mesh, options: &Fetch) -> Result<String, String> {
    // The name and the commit become a path and an argument.
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if mesh.name.starts_with(['.', '-']) || !mesh.name.chars().all(is_plain) {
        return Err("refused: the name is no plain name of a file".into());
    }
    if !mesh.commit.chars().all(|c| c.is_ascii_hexdigit()) || mesh.repository.starts_with('-') {
        return Err("refused: the commit or the repository is malformed".into());
    }
    let to = options.to.join(&mesh.name);
    if to.exists() {
        check(mesh, &read(&to)?, &to.display().to_string())?;
        return Ok("there already".into());
    }
    let cached = options.cache.as_ref().map(|folder| folder.join(&mesh.name));
    let (bytes, from) = match cached.filter(|path| path.exists()) {
        Some(path) => (read(&path)?, path.display().to_string()),
        None if options.offline => return Err("not in the folder of --cache".into()),
        None => (from_git(mesh, &options.to)?, mesh.repository.clone()),
    };
    check(mesh, &bytes, &from)?;
    std::fs::write(&to, bytes).map_err(|e| format!("cannot write {}: {e}", to.display()))?;
    Ok(format!("from {from}"))
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(path).map_err(|e| format!("cannot read {}: {e}", path.display()))
}

/// Refuses bytes with another hash than the list has.
fn check(mesh: &Mesh, bytes: &[u8], from: &str) -> Result<(), String> {
    let found = format!("{:x}", Sha256::digest(bytes));
    if found == mesh.sha256 {
        return Ok(());
    }
    Err(format!(
        "refused: {from} has the SHA-256 {found} instead of {}; remove the file, or correct the list",
        mesh.sha256
    ))
}

/// The bytes of one file of one commit. Other files of the repository are not transferred, where the server can do
/// without them.
fn from_git(mesh: &Mesh, to: &Path) -> Result<Vec<u8>, String> {
    let name: String =
        mesh.repository.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let folder = to.join(".repositories").join(name);
    if !folder.exists() {
        std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
        git(&folder, &["init", "--quiet", "--bare"])?;
        git(&folder, &["remote", "add", "origin", &mesh.repository])?;
    }
    let object = format!("{}:{}", mesh.commit, mesh.path);
    let commit = format!("{}^{{commit}}", mesh.commit);
    if git(&folder, &["cat-file", "-e", &commit]).is_err() {
        let fetch = ["fetch", "--quiet", "--depth", "1", "--filter=blob:none", "origin"];
        git(&folder, &[&fetch[..], &[&mesh.commit]].concat())?;
    }
    git(&folder, &["cat-file", "blob", &object])
}

/// The output of git, which asks nobody for a password.
fn git(folder: &Path, arguments: &[&str]) -> Result<Vec<u8>, String> {
    let mut command = Command::new("git");
    command.arg("-C").arg(folder).args(arguments).env("GIT_TERMINAL_PROMPT", "0");
    command_output(&mut command).map_err(|why| format!("git: {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A list with one file of a repository, which is made here.
    fn entry(repository: &Path, content: &str) -> Mesh {
        git(repository, &["init", "--quiet"]).unwrap();
        std::fs::write(repository.join("a.obj"), content).unwrap();
        git(repository, &["add", "a.obj"]).unwrap();
        let who = ["-c", "user.name=a", "-c", "user.email=a@example.org"];
        git(repository, &[&who[..], &["commit", "--quiet", "-m", "a"]].concat()).unwrap();
        let commit = String::from_utf8(git(repository, &["rev-parse", "HEAD"]).unwrap()).unwrap();
        Mesh {
            name: "mesh.obj".into(),
            repository: repository.to_str().unwrap().into(),
            commit: commit.trim().into(),
            path: "a.obj".into(),
            sha256: format!("{:x}", Sha256::digest(content)),
            licence: "none".into(),
            class: "scan".into(),
            kind: "a point".into(),
        }
    }

    #[test]
    fn files_are_taken_from_folders_and_repositories_and_checked() {
        let folder = tempfile::tempdir().unwrap();
        let [repository, to, cache] = ["r", "to", "cache"].map(|name| folder.path().join(name));
        for path in [&repository, &to, &cache] {
            std::fs::create_dir(path).unwrap();
        }
        let mesh = entry(&repository, "v 1 2 3\n");
        let mut options = Fetch {
            to: to.clone(),
            cache: Some(cache.clone()),
            meshes: Vec::new(),
            list: None,
            offline: true,
        };
        assert!(fetch(&mesh, &options).unwrap_err().contains("--cache"));
        std::fs::write(cache.join("mesh.obj"), "v 1 2 4\n").unwrap();
        assert!(fetch(&mesh, &options).unwrap_err().starts_with("refused"));
        assert!(!to.join("mesh.obj").exists());
        std::fs::remove_file(cache.join("mesh.obj")).unwrap();
        options.offline = false;
        assert!(fetch(&mesh, &options).unwrap().starts_with("from "));
        assert_eq!(std::fs::read_to_string(to.join("mesh.obj")).unwrap(), "v 1 2 3\n");
        assert_eq!(fetch(&mesh, &options).unwrap(), "there already");
        let outside = Mesh { name: "../mesh.obj".into(), ..mesh };
        assert!(fetch(&outside, &options).unwrap_err().starts_with("refused"));
    }

    #[test]
    fn the_list_is_complete() {
        const CLASSES: [&str; 10] = [
            "scan",
            "figure",
            "CAD",
            "object",
            "terrain",
            "building",
            "textured",
            "medical",
            "generated",
            "broken",
        ];
        let List { mesh: meshes } = toml::from_str(LIST).unwrap();
        assert!(meshes.len() >= 100);
        assert_eq!(class(&meshes[0].sha256).unwrap().as_ref(), Some(&meshes[0].class));
        assert_eq!(class("00").unwrap(), None);
        for (index, mesh) in meshes.iter().enumerate() {
            assert_eq!((mesh.commit.len(), mesh.sha256.len()), (40, 64), "{}", mesh.name);
            assert!(mesh.repository.starts_with("https://"), "{}", mesh.name);
            let texts = [&mesh.path, &mesh.licence, &mesh.kind];
            assert!(texts.iter().all(|text| !text.is_empty()), "{}", mesh.name);
            assert!(CLASSES.contains(&&*mesh.class), "{}: {}", mesh.name, mesh.class);
            assert!(meshes[..index].iter().all(|other| other.name != mesh.name), "{}", mesh.name);
        }
    }
}
