//! Folders for temporary files: private, with a random name, removed at the end.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::error::Error;
use crate::lock::FolderLock;
use crate::private_files;

/// The suffix of the name of each scratch folder.
const SUFFIX: &str = ".curvmesh";
/// The number of bytes of a described name that become part of the name of the folder, which has at most 255.
const LONGEST_NAME: usize = 200;

/// A folder for temporary files, which is removed when this is dropped.
///
/// The folder is new, has a random name and mode 0700, and is locked as long as its owner exists.
#[derive(Debug)]
pub struct ScratchFolder {
    folder: TempDir,
    _lock: FolderLock,
}

impl ScratchFolder {
    /// Creates a scratch folder in `parent`, which is created if it is missing. `name` describes the files, for example
    /// by the name of the output; it becomes part of the name of the folder.
    ///
    /// Leftover scratch folders of the same name are removed if this user created them on this machine since its last
    /// start, and if no process holds their lock: their process was killed.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn new(parent: &Path, name: &OsStr) -> Result<Self, Error> {
        let parent = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
        fs::create_dir_all(parent).map_err(Error::io(parent))?;
        let name = name.to_string_lossy();
        let prefix = format!(".{}-", &name[..name.floor_char_boundary(LONGEST_NAME)]);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(SUFFIX).rand_bytes(12);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o700));
        }
        let folder = builder.tempdir_in(parent).map_err(Error::io(parent))?;
        let lock = FolderLock::of_new_folder(folder.path())?;
        remove_leftovers(parent, &prefix, folder.path());
        Ok(Self { folder, _lock: lock })
    }

    /// The path of the folder. A program that ends without dropping this value must remove the folder itself.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Creates a folder inside.
    pub(crate) fn inner(&self, name: &str) -> Result<PathBuf, Error> {
        let path = self.folder.path().join(name);
        private_files::create_folder(&path).map_err(Error::io(&path))?;
        Ok(path)
    }
}

/// Removes scratch folders with this prefix whose owner has ended. Folders that cannot be removed stay.
fn remove_leftovers(parent: &Path, prefix: &str, own: &Path) {
    for entry in fs::read_dir(parent).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_scratch =
            name.to_str().is_some_and(|n| n.starts_with(prefix) && n.ends_with(SUFFIX));
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        let path = entry.path();
        if is_scratch
            && is_folder
            && path != own
            && let Some(_lock) = FolderLock::of_dead_owner(&path)
        {
            let _ = fs::remove_dir_all(&path);
        }
    }
}
