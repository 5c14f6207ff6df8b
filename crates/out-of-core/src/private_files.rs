//! Files and folders that other users can neither plant nor redirect.
//!
//! Folders are created with mode 0700. Files are created under a new name, and never opened through a symbolic
//! link: a link in a work folder would lead reads and writes to files elsewhere.

use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io::{BufWriter, Error, ErrorKind, Result, Write};
use std::path::Path;

/// Bytes that are buffered while a file is written.
const BUFFER: usize = 1 << 16;

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
    let temporary = tempfile::Builder::new().prefix(".new-").tempfile_in(folder)?;
    let mut writer = BufWriter::with_capacity(BUFFER, temporary);
    let written = write(&mut writer)?;
    let temporary = writer.into_inner().map_err(std::io::IntoInnerError::into_error)?;
    temporary.as_file().sync_all()?;
    temporary.persist(path)?;
    Ok(written)
}

/// Checks that a folder is not a link, that the user of this process owns it, and that no other user can write to it.
///
/// `own` is metadata of a file that this process has just created.
#[cfg(unix)]
pub(crate) fn check_folder(path: &Path, own: &fs::Metadata) -> Result<()> {
    use std::os::unix::fs::MetadataExt;
    let folder = fs::symlink_metadata(path)?;
    if !folder.is_dir() {
        return Err(invalid("this is not a folder; symbolic links are not followed"));
    }
    if folder.uid() != own.uid() {
        return Err(denied("this folder belongs to another user; name another folder"));
    }
    if folder.mode() & 0o022 != 0 {
        return Err(denied(
            "other users can write to this folder; make it private with chmod 700, or name another folder",
        ));
    }
    Ok(())
}

/// Checks that a folder is not a link.
#[cfg(not(unix))]
pub(crate) fn check_folder(path: &Path, _own: &fs::Metadata) -> Result<()> {
    let is_folder = fs::symlink_metadata(path)?.is_dir();
    if is_folder { Ok(()) } else { Err(invalid("this is not a folder")) }
}

/// Makes an empty folder of this user private.
pub(crate) fn make_private(path: &Path) -> Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(path, fs::Permissions::from_mode(0o700))?;
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
