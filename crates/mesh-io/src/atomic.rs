//! Atomic replacement of files: the old file stays complete until the new one is.

use crate::error::{WriteError, shown};
use crate::temporary;
use std::fs::{self, File, Metadata};
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// A complete file on the disk, under a temporary name in the folder of its target. It is removed when this is dropped.
#[derive(Debug)]
pub(crate) struct Beside {
    /// `None` if the target is a device, which has received the bytes already.
    temporary: Option<TempPath>,
    target: PathBuf,
    /// Whether an existing file at the target is replaced.
    replaces: bool,
}

impl Beside {
    /// Moves the file to its target. At any time, and after any failure, the target is either the old file or the new
    /// one.
    pub(crate) fn commit(self) -> Result<(), WriteError> {
        let Some(temporary) = self.temporary else { return Ok(()) };
        let renamed = if self.replaces {
            temporary.persist(&self.target)
        } else {
            temporary.persist_noclobber(&self.target)
        };
        renamed.map_err(|error| at(&self.target, error.error))?;
        // The rename survives a power failure only after the folder is synchronised as well. Not every file system
        // supports that; the file is complete in either case.
        #[cfg(unix)]
        let _ = File::open(folder_of(&self.target)).and_then(|folder| folder.sync_all());
        Ok(())
    }
}

/// Prepares the file at `path` with what `write` produces.
///
/// The new file keeps the permissions of the old one; a symbolic link stays a link, and its target
/// is replaced. A target that is not a regular file (a pipe, a device) is written directly.
///
/// # Errors
/// The errors of `write`, and all errors of the creation of the file.
pub(crate) fn prepare<T>(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<T, WriteError>,
) -> Result<(Beside, T), WriteError> {
    match fs::metadata(path) {
        // Before links are resolved: `/dev/stdout` leads to a pipe that has no path.
        Ok(old) if !old.is_file() && !old.is_dir() => {
            let result = write_device(path, write).map_err(|error| error.in_file(path))?;
            let file = Beside { temporary: None, target: path.to_owned(), replaces: true };
            return Ok((file, result));
        }
        // The system may forbid to follow a link that another user has put into a shared folder.
        Err(source) if source.kind() == ErrorKind::PermissionDenied => {
            return Err(at(path, source));
        }
        _ => {}
    }
    let target = resolve_link(path).map_err(|source| at(path, source))?;
    let old = match fs::metadata(&target) {
        Ok(metadata) => Some(metadata),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => return Err(at(path, error)),
    };
    match &old {
        Some(old) if old.is_dir() => Err(at(path, ErrorKind::IsADirectory.into())),
        Some(old) if old.permissions().readonly() => Err(WriteError::ReadOnly(target)),
        _ => {
            let written = write_beside(&target, old.as_ref(), write);
            let (temporary, result) = written.map_err(|error| error.in_file(path))?;
            Ok((Beside { temporary: Some(temporary), target, replaces: true }, result))
        }
    }
}

/// As [`prepare`], for a companion file that the user has not named: it is never written through a link. If `old` is
/// given, this file is replaced; otherwise no file may exist there.
pub(crate) fn prepare_unlinked(
    path: &Path,
    old: Option<&Metadata>,
    write: impl FnOnce(&mut dyn Write) -> Result<(), WriteError>,
) -> Result<Beside, WriteError> {
    let old_file = old.filter(|old| old.is_file());
    let (temporary, ()) =
        write_beside(path, old_file, write).map_err(|error| error.in_file(path))?;
    Ok(Beside { temporary: Some(temporary), target: path.to_owned(), replaces: old.is_some() })
}

/// Whether the path is a pipe, a terminal or another device, to which bytes are written directly.
pub(crate) fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

fn at(path: &Path, source: std::io::Error) -> WriteError {
    WriteError::Io { path: Some(path.to_owned()), source }
}

/// The target of a symbolic link, or `path` itself; the file need not exist.
fn resolve_link(path: &Path) -> std::io::Result<PathBuf> {
    const MOST_LINKS: usize = 40;
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::symlink_metadata(&target) {
            Ok(metadata) if metadata.is_symlink() => {
                let link = fs::read_link(&target)?;
                target = folder_of(&target).join(link);
            }
            _ => return Ok(target),
        }
    }
    Err(std::io::Error::other("too many symbolic links lead on from here"))
}

/// The path of a file without links, or of a file that does not exist yet in a folder that does.
pub(crate) fn place_of(path: &Path) -> Option<PathBuf> {
    let new = || Some(folder_of(path).canonicalize().ok()?.join(path.file_name()?));
    path.canonicalize().ok().or_else(new)
}

pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn write_device<T>(
    target: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<T, WriteError>,
) -> Result<T, WriteError> {
    let mut writer = BufWriter::new(File::options().write(true).open(target)?);
    let result = write(&mut writer)?;
    writer.flush()?;
    Ok(result)
}

fn write_beside<T>(
    target: &Path,
    old: Option<&Metadata>,
    write: impl FnOnce(&mut dyn Write) -> Result<T, WriteError>,
) -> Result<(TempPath, T), WriteError> {
    // An early return drops the temporary file, which removes it.
    let temporary = new_temporary(folder_of(target))?;
    let mut writer = BufWriter::with_capacity(1 << 16, temporary);
    let result = write(&mut writer)?;
    let temporary = writer.into_inner().map_err(std::io::IntoInnerError::into_error)?;
    if let Some(old) = old {
        temporary.as_file().set_permissions(plain(&old.permissions()))?;
    }
    temporary.as_file().sync_all()?;
    // The file is closed, so that any number of files can wait.
    Ok((temporary.into_temp_path(), result))
}

/// The permissions without the right to run as the owner or group, who may be others than before.
fn plain(permissions: &fs::Permissions) -> fs::Permissions {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::Permissions::from_mode(permissions.mode() & 0o777)
    }
    #[cfg(not(unix))]
    permissions.clone()
}

/// A temporary file in a folder that has to exist.
fn new_temporary(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    temporary::create(folder).map_err(|error| match error.kind() {
        ErrorKind::NotFound => {
            let message = format!("there is no folder {}; make it first", shown(folder));
            std::io::Error::new(ErrorKind::NotFound, message)
        }
        _ => error,
    })
}
