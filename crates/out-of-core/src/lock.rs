//! Locks on folders: who works in one, and whether that process is still alive.
//!
//! A lock is held on a file of the folder. The operating system releases it when the process ends, however it ends.

use std::fs::{self, File, TryLockError};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::private_files;

/// The file whose lock represents the folder. It also marks the folder as one of this crate.
pub(crate) const MARK: &str = "curvmesh-work";

/// A lock on a folder. It is shared by processes that do different steps of one run.
#[derive(Debug)]
pub(crate) struct FolderLock {
    folder: PathBuf,
    file: File,
}

impl FolderLock {
    /// Takes a folder for a run, and locks it for this process alone. The folder is created, or is empty, or was
    /// taken for a run before.
    pub(crate) fn claim(folder: &Path) -> Result<Self, Error> {
        if let Some(parent) = folder.parent() {
            fs::create_dir_all(parent).map_err(Error::io(parent))?;
        }
        let is_new = private_files::create_folder(folder).map_err(Error::io(folder))?;
        let mark = folder.join(MARK);
        // Another process may take the folder at any moment.
        let is_marked = || fs::symlink_metadata(&mark).is_ok();
        if !is_new {
            // Nothing changes in the folder of another user, not even its permissions.
            private_files::check_owner(folder).map_err(Error::io(folder))?;
        }
        if !is_new && !is_marked() {
            let is_empty = fs::read_dir(folder).map_err(Error::io(folder))?.next().is_none();
            if !is_empty && !is_marked() {
                return Err(Error::NotEmpty { path: folder.to_owned() });
            }
            if is_empty {
                private_files::make_private(folder).map_err(Error::io(folder))?;
            }
        }
        let lock = match Self::create(folder, &mark) {
            Err(Error::Io { source, .. }) if source.kind() == ErrorKind::AlreadyExists => {
                Self::open(folder)?
            }
            created => {
                let lock = created?;
                lock.check_folder()?;
                lock
            }
        };
        lock.lock_alone()?;
        Ok(lock)
    }

    /// Opens the folder of a run, and locks it together with others that do steps of the run.
    pub(crate) fn share(folder: &Path) -> Result<Self, Error> {
        let lock = Self::open(folder)?;
        lock.lock_shared()?;
        Ok(lock)
    }

    /// Locks a new folder that no other process knows yet. The mark gets its name only when the lock is held: so a
    /// folder with an unlocked mark has lost its owner.
    pub(crate) fn of_new_folder(folder: &Path) -> Result<Self, Error> {
        let (unfinished, mark) = (folder.join(".mark"), folder.join(MARK));
        let lock = Self::create(folder, &unfinished)?;
        lock.lock_alone()?;
        fs::rename(&unfinished, &mark).map_err(Error::io(&mark))?;
        Ok(lock)
    }

    /// The lock of a scratch folder whose owner has ended on this machine. `None` if that is not certain.
    pub(crate) fn of_dead_owner(folder: &Path) -> Option<Self> {
        let lock = Self::open(folder).ok()?;
        let text = std::io::read_to_string((&lock.file).take(4096)).ok()?;
        let is_ours = text == mark_text();
        (is_ours && lock.file.try_lock().is_ok()).then_some(lock)
    }

    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    fn create(folder: &Path, mark: &Path) -> Result<Self, Error> {
        let mut file = private_files::create_file(mark).map_err(Error::io(mark))?;
        file.write_all(mark_text().as_bytes()).map_err(Error::io(mark))?;
        Ok(Self { folder: folder.to_owned(), file })
    }

    fn open(folder: &Path) -> Result<Self, Error> {
        let mark = folder.join(MARK);
        let file = private_files::open_to_lock(&mark).map_err(|source| match source.kind() {
            ErrorKind::NotFound => Error::NoWorkFolder { path: folder.to_owned() },
            _ => Error::io(&mark)(source),
        })?;
        let lock = Self { folder: folder.to_owned(), file };
        lock.check_folder()?;
        Ok(lock)
    }

    fn check_folder(&self) -> Result<(), Error> {
        private_files::check_folder(&self.folder).map_err(Error::io(&self.folder))
    }

    /// Keeps all other processes out of the folder until the returned guard is dropped.
    pub(crate) fn alone(&self) -> Result<Alone<'_>, Error> {
        self.file.unlock().map_err(Error::io(&self.folder))?;
        match self.lock_alone() {
            Ok(()) => Ok(Alone { lock: self }),
            Err(error) => {
                self.lock_shared()?;
                Err(error)
            }
        }
    }

    /// Lets other processes into the folder.
    pub(crate) fn admit_others(&self) -> Result<(), Error> {
        self.file.unlock().map_err(Error::io(&self.folder))?;
        self.lock_shared()
    }

    fn lock_alone(&self) -> Result<(), Error> {
        self.result(self.file.try_lock())
    }

    fn lock_shared(&self) -> Result<(), Error> {
        self.result(self.file.try_lock_shared())
    }

    fn result(&self, locked: Result<(), TryLockError>) -> Result<(), Error> {
        match locked {
            Ok(()) => Ok(()),
            Err(TryLockError::WouldBlock) => Err(Error::InUse { path: self.folder.clone() }),
            // Some network file systems have no locks. Runs in the same folder cannot exclude each other there.
            Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => Ok(()),
            Err(TryLockError::Error(error)) => Err(Error::io(&self.folder)(error)),
        }
    }
}

/// A time in which no other process works in a folder.
pub(crate) struct Alone<'l> {
    lock: &'l FolderLock,
}

impl Drop for Alone<'_> {
    fn drop(&mut self) {
        // If another process was faster, the next step fails to open the folder with an error.
        let _ = self.lock.admit_others();
    }
}

/// The content of the mark. It names the machine and its last start, because a lock held on another machine may not be
/// visible on this one.
fn mark_text() -> String {
    let machine = fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    format!(
        "Files of curvmesh for a mesh that is larger than memory.\nmachine {}\n",
        machine.trim()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_many_processes_takes_a_folder_and_the_others_are_told_so() {
        let parent = tempfile::tempdir().unwrap();
        for round in 0..200 {
            let folder = parent.path().join(round.to_string());
            if round % 2 == 0 {
                fs::create_dir(&folder).unwrap();
            }
            let start = std::sync::Barrier::new(4);
            let claim = || {
                start.wait();
                FolderLock::claim(&folder)
            };
            let claimed: Vec<Result<FolderLock, Error>> = std::thread::scope(|scope| {
                let threads = [(); 4].map(|()| scope.spawn(claim));
                threads.into_iter().map(|thread| thread.join().unwrap()).collect()
            });
            assert_eq!(claimed.iter().filter(|lock| lock.is_ok()).count(), 1, "{claimed:?}");
            let told = |lock: &Result<FolderLock, Error>| matches!(lock, Err(Error::InUse { .. }));
            assert_eq!(claimed.iter().filter(|lock| told(lock)).count(), 3, "{claimed:?}");
        }
    }
}
