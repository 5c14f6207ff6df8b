//! Files and folders that other users can neither plant nor redirect.
//!
//! Folders are created with mode 0700. Files are created under a new name, and never opened through a symbolic
//! link: a link in a work folder would lead reads and writes to files elsewhere.

use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io::{BufWriter, Error, ErrorKind, Result, Write};
use std::path::Path;

/// Bytes that are buffered while a file is written.
const BUFFER: usize = 1 << 16;
/// The names of files that are not yet in their places begin so.
pub(crate) const UNFINISHED: &str = ".new-";

/// Creates a folder that only its owner can enter. Returns `false` if there is a folder already.
pub(crate) fn create_folder(path: &Path) -> Result<bool> {
    let mut builder = DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    match builder.create(path) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            if !fs::symlink_metadata(path)?.is_dir() {
                return Err(invalid("this is not a folder; symbolic links are not followed"));
            }
            Ok(false)
        }
        Err(error) => Err(error),
    }
}

/// Creates a new file; an error if it exists.
pub(crate) fn create_file(path: &Path) -> Result<File> {
    private_options().write(true).create_new(true).open(path)
}

/// Opens a regular file to read it.
pub(crate) fn open(path: &Path) -> Result<File> {
    open_with(path, OpenOptions::new().read(true))
}

/// Opens a regular file to lock it, which some file systems only allow with write access.
pub(crate) fn open_to_lock(path: &Path) -> Result<File> {
    open_with(path, OpenOptions::new().read(true).write(true))
}

fn open_with(path: &Path, options: &mut OpenOptions) -> Result<File> {
    if fs::symlink_metadata(path)?.is_symlink() {
        return Err(invalid("this is a symbolic link, which is not followed here"));
    }
    // The first flag rejects a link that was planted in between, the second prevents a named pipe from blocking.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(options, libc::O_NOFOLLOW | libc::O_NONBLOCK);
    let file = options.open(path)?;
    if !file.metadata()?.is_file() {
        return Err(invalid("this is not a regular file"));
    }
    Ok(file)
}

/// Writes a file under a random name in the same folder, and renames it when it is on the disk. So at any time either
/// the old or the new file exists. A symbolic link at `path` is replaced, not followed.
pub(crate) fn replace<T>(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<T>,
) -> Result<T> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let temporary = tempfile::Builder::new().prefix(UNFINISHED).tempfile_in(folder)?;
    let mut writer = BufWriter::with_capacity(BUFFER, temporary);
    let written = write(&mut writer)?;
    let temporary = writer.into_inner().map_err(std::io::IntoInnerError::into_error)?;
    temporary.as_file().sync_all()?;
    temporary.persist(path)?;
    Ok(written)
}

/// Checks that a folder is not a link, and that the user of this process owns it.
pub(crate) fn check_owner(path: &Path) -> Result<()> {
    owned(path).map(drop)
}

/// Checks a folder as [`check_owner`] does, and that no other user can write to it.
pub(crate) fn check_folder(path: &Path) -> Result<()> {
    let folder = owned(path)?;
    #[cfg(unix)]
    if std::os::unix::fs::MetadataExt::mode(&folder) & 0o022 != 0 {
        return Err(denied(
            "other users can write to this folder; make it private with chmod 700, or name another folder",
        ));
    }
    let _ = folder;
    Ok(())
}

/// The metadata of a folder of this user.
fn owned(path: &Path) -> Result<fs::Metadata> {
    // A file without a name tells who the user is.
    let own = tempfile::tempfile_in(path)?.metadata()?;
    let folder = fs::symlink_metadata(path)?;
    if !folder.is_dir() {
        return Err(invalid("this is not a folder; symbolic links are not followed"));
    }
    if !is_of_same_user(&folder, &own) {
        return Err(denied("this folder belongs to another user; name another folder"));
    }
    Ok(folder)
}

#[cfg(unix)]
fn is_of_same_user(a: &fs::Metadata, b: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    a.uid() == b.uid()
}

#[cfg(not(unix))]
fn is_of_same_user(_: &fs::Metadata, _: &fs::Metadata) -> bool {
    true
}

/// Makes an empty folder of this user private. Another folder may have taken its place meanwhile: it is checked again
/// when it is open.
pub(crate) fn make_private(path: &Path) -> Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
        let own = tempfile::tempfile_in(path)?.metadata()?;
        let flags = libc::O_NOFOLLOW | libc::O_DIRECTORY;
        let folder = OpenOptions::new().read(true).custom_flags(flags).open(path)?;
        if !is_of_same_user(&folder.metadata()?, &own) {
            return Err(denied("this folder belongs to another user; name another folder"));
        }
        folder.set_permissions(fs::Permissions::from_mode(0o700))?;
    }
    let _ = path;
    Ok(())
}

fn private_options() -> OpenOptions {
    let mut options = OpenOptions::new();
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options
}

fn invalid(message: &str) -> Error {
    Error::new(ErrorKind::InvalidInput, message)
}

fn denied(message: &str) -> Error {
    Error::new(ErrorKind::PermissionDenied, message)
}
