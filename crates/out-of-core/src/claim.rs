//! Folders that hold files of this crate alone.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::Error;

/// A file that says what the folder is for.
pub(crate) const MARK: &str = "curvmesh-work";
/// What is needed for a while, in a folder of this name.
pub(crate) const SCRATCH: &str = "scratch";

/// Makes a folder that of a run: it has to be empty, or to be one already.
pub(crate) fn claim(folder: &Path) -> Result<(), Error> {
    let mark = folder.join(MARK);
    if mark.exists() {
        return Ok(());
    }
    if fs::read_dir(folder).map_err(Error::io(folder))?.next().is_some() {
        return Err(Error::NotEmpty { path: folder.to_owned() });
    }
    // Not through another file: if that were left when this is killed, the folder would be one of others.
    let text = b"The files of a mesh that is larger than memory; see run.json, if it is there.\n";
    fs::write(&mark, text).map_err(Error::io(&mark))
}

/// A folder for what is needed as long as this lives; then it is removed, if nothing else is in it.
#[derive(Debug)]
pub struct ScratchFolder {
    folder: PathBuf,
}

impl ScratchFolder {
    /// In a folder that is made if it is not there. What an earlier run has left in it is removed.
    ///
    /// # Errors
    /// The folder holds other files, or cannot be written.
    pub fn new(folder: &Path) -> Result<Self, Error> {
        fs::create_dir_all(folder).map_err(Error::io(folder))?;
        claim(folder)?;
        let scratch = folder.join(SCRATCH);
        let _ = fs::remove_dir_all(&scratch);
        fs::create_dir(&scratch).map_err(Error::io(&scratch))?;
        Ok(Self { folder: folder.to_owned() })
    }

    /// A folder in it, which is made.
    pub(crate) fn inner(&self, name: &str) -> Result<PathBuf, Error> {
        let path = self.folder.join(SCRATCH).join(name);
        fs::create_dir(&path).map_err(Error::io(&path))?;
        Ok(path)
    }
}

impl ScratchFolder {
    /// Removes what lies in such a folder, and the folder itself if nothing else is in it: for a program
    /// that ends before its folder is dropped.
    pub fn remove(folder: &Path) {
        // What cannot be removed is in nobody's way but that of the disk.
        let _ = fs::remove_dir_all(folder.join(SCRATCH));
        // A run that can be resumed keeps its folder.
        if fs::read_dir(folder).is_ok_and(|left| left.count() == 1) {
            let _ = fs::remove_file(folder.join(MARK));
            let _ = fs::remove_dir(folder);
        }
    }
}

impl Drop for ScratchFolder {
    fn drop(&mut self) {
        Self::remove(&self.folder);
    }
}
