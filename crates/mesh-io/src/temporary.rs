//! Temporary files that outlive no run: the next run in the same folder removes those of killed processes.
//!
//! The name of a temporary file tells its owner: `.mesh-io-MACHINE-PROCESS-START-` and random letters. So no lock is
//! needed, and a complete file can be closed while it waits for its place.

use std::collections::BTreeSet;
use std::fs::{self, Metadata};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::NamedTempFile;

const PREFIX: &str = ".mesh-io-";

/// The folders that were searched for leftovers. One search in each is enough: a folder of many results would be read
/// once for each of them.
static SEARCHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Creates a temporary file with the permissions of any new file, not the private ones of `tempfile`.
pub(crate) fn create(folder: &Path) -> std::io::Result<NamedTempFile> {
    let owner = Owner::of_this_process();
    let prefix = owner.as_ref().map_or_else(|| PREFIX.to_owned(), Owner::prefix);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let temporary = builder.tempfile_in(folder)?;
    if let Some(owner) = owner
        && SEARCHED.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.to_owned())
    {
        remove_leftovers(folder, &owner, &temporary.as_file().metadata()?);
    }
    Ok(temporary)
}

/// A process, distinct from all others of all machines at any time.
struct Owner {
    /// The start of the machine, and the processes that see each other on it.
    machine: String,
    process: u32,
    /// The time of its start, since the start of the machine.
    start: String,
}

impl Owner {
    /// `None` if the system does not tell, as outside Linux. Then no leftovers are removed.
    fn of_this_process() -> Option<Self> {
        let process = std::process::id();
        // Otherwise the numbers of processes in this folder are those of another container.
        if fs::read_link("/proc/self").ok()? != Path::new(&process.to_string()) {
            return None;
        }
        let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
        let space = fs::read_link("/proc/self/ns/pid").ok()?;
        let is_digit = |c: &char| c.is_ascii_alphanumeric();
        let machine = boot.chars().chain(space.to_str()?.chars()).filter(is_digit).collect();
        Some(Self { machine, process, start: start_of(process).ok()?? })
    }

    fn prefix(&self) -> String {
        let Self { machine, process, start } = self;
        format!("{PREFIX}{machine}-{process}-{start}-")
    }

    /// Whether a temporary file of this name belongs to a process that has ended on this machine.
    fn has_outlived(&self, name: &str) -> bool {
        let own = name.strip_prefix(PREFIX).and_then(|rest| rest.strip_prefix(&self.machine));
        let parts: Vec<&str> = own.unwrap_or_default().split('-').collect();
        let ["", process, start, _] = parts[..] else { return false };
        let Ok(process) = process.parse() else { return false };
        start_of(process).is_ok_and(|of_now| of_now.is_none_or(|of_now| of_now != start))
    }
}

/// The time at which a process was started; `None` if it does not exist.
fn start_of(process: u32) -> std::io::Result<Option<String>> {
    let text = match fs::read(format!("/proc/{process}/stat")) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        text => String::from_utf8_lossy(&text?).into_owned(),
    };
    // The name of the program, in brackets, may contain anything.
    let start = text.rsplit_once(')').and_then(|(_, rest)| rest.split_whitespace().nth(19));
    start.map(|start| Some(start.to_owned())).ok_or_else(|| ErrorKind::InvalidData.into())
}

/// Removes the temporary files of this user in a folder whose processes have ended. Files that cannot be removed stay.
///
/// `own` is metadata of a file that this process has just created.
fn remove_leftovers(folder: &Path, owner: &Owner, own: &Metadata) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_left = entry.file_name().to_str().is_some_and(|name| owner.has_outlived(name));
        // The metadata of the entry itself: no link is followed.
        if is_left
            && entry.metadata().is_ok_and(|file| file.is_file() && is_of_same_user(&file, own))
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(unix)]
fn is_of_same_user(file: &Metadata, own: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    file.uid() == own.uid()
}

#[cfg(not(unix))]
fn is_of_same_user(_: &Metadata, _: &Metadata) -> bool {
    false
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// Names of files that only look like leftovers: other machines, processes that exist, other programs.
    #[test]
    fn only_files_of_ended_processes_of_this_machine_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let owner = Owner::of_this_process().unwrap();
        let Owner { machine, process, start } = &owner;
        let mut child = std::process::Command::new("sleep").arg("600").spawn().unwrap();
        let of_child = start_of(child.id()).unwrap().unwrap();
        let alive = format!("{PREFIX}{machine}-{}-{of_child}-aaaaaa", child.id());
        let left = [
            alive.clone(),
            format!("{PREFIX}{machine}-{process}-1{start}-aaaaaa"),
            format!("{PREFIX}{machine}-4194305-77-aaaaaa"),
        ];
        let others = [
            format!("{}aaaaaa", owner.prefix()),
            format!("{PREFIX}0{machine}-4194305-77-aaaaaa"),
            format!("{PREFIX}{machine}-4194305-77"),
            format!("{PREFIX}{machine}-4194305-77-aaaaaa-b"),
            format!("{PREFIX}{machine}--77-aaaaaa"),
            format!("{PREFIX}aaaaaa"),
            "mesh.ply".to_owned(),
        ];
        let is_there = |name: &String| folder.path().join(name).symlink_metadata().is_ok();
        let all = left.iter().chain(&others);
        all.for_each(|name| fs::write(folder.path().join(name), "x").unwrap());
        let link = format!("{PREFIX}{machine}-4194305-77-bbbbbb");
        std::os::unix::fs::symlink("mesh.ply", folder.path().join(&link)).unwrap();
        let own = fs::metadata(folder.path().join("mesh.ply")).unwrap();
        remove_leftovers(folder.path(), &owner, &own);
        assert!(is_there(&alive) && others.iter().chain([&link]).all(is_there));
        assert!(!is_there(&left[1]) && !is_there(&left[2]));
        child.kill().unwrap();
        child.wait().unwrap();
        remove_leftovers(folder.path(), &owner, &own);
        assert!(!is_there(&alive) && others.iter().chain([&link]).all(is_there));
    }
}
