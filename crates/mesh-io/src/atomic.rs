//! Writing a file so that the old one is whole until the new one is.

use crate::WriteError;
use std::fs::{self, File, Metadata};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Replaces the file at `path` by what `write` produces.
///
/// The bytes go to a temporary file in the same folder, which is flushed to the disk and then
/// renamed onto `path`: whoever looks at `path`, at any time and after any failure, sees the old
/// file or the new one. The new file keeps the permissions of the old one; a symbolic link stays a
/// link, and its target is replaced. A target that is not a regular file (a pipe, a device) is
/// written directly.
///
/// # Errors
/// Those of `write`, and whatever keeps the file from being made or renamed.
pub(crate) fn replace<T>(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<T, WriteError>,
) -> Result<T, WriteError> {
    let failed = |source| WriteError::Io { path: Some(path.to_owned()), source };
    let target = resolve_link(path).map_err(failed)?;
    let old = match fs::metadata(&target) {
        Ok(metadata) => Some(metadata),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => None,
        Err(error) => return Err(failed(error)),
    };
    let written = match &old {
        Some(old) if old.is_dir() => {
            Err(std::io::Error::from(std::io::ErrorKind::IsADirectory).into())
        }
        Some(old) if old.permissions().readonly() => return Err(WriteError::ReadOnly(target)),
        Some(old) if !old.is_file() => write_device(&target, write),
        _ => write_beside(&target, old.as_ref(), write),
    };
    written.map_err(|error| match error {
        WriteError::Io { path: None, source } => failed(source),
        other => other,
    })
}

/// The file that a symbolic link leads to, or `path` itself; the file need not exist.
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

fn folder_of(path: &Path) -> &Path {
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
) -> Result<T, WriteError> {
    let folder = folder_of(target);
    // Dropping the temporary file, as every early return does, removes it.
    let temporary = new_temporary(folder)?;
    let mut writer = BufWriter::with_capacity(1 << 16, temporary);
    let result = write(&mut writer)?;
    let temporary = writer.into_inner().map_err(std::io::IntoInnerError::into_error)?;
    if let Some(old) = old {
        temporary.as_file().set_permissions(old.permissions())?;
    }
    temporary.as_file().sync_all()?;
    temporary.persist(target).map_err(|error| error.error)?;
    // The rename itself survives a power failure once the folder is on the disk too. Not every
    // file system can do that, and the file is whole either way.
    #[cfg(unix)]
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(result)
}

/// A temporary file with the permissions of any new file, not the private ones of `tempfile`.
fn new_temporary(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".mesh-io-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}
