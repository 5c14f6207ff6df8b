//! Copying the pictures that a file names to the folder of another file that names them.

use std::fs::{self, File};
use std::io::{ErrorKind, Read, copy};
use std::path::{Path, PathBuf};

use crate::atomic::{folder_of, prepare_unlinked};
use crate::error::WriteError;
use crate::external::{below, open};
use crate::picture_format::PictureFormat;
use crate::pictures::{HEAD, PictureError, PictureOptions, resolve};

/// The result of [`copy_pictures`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CopiedPictures {
    /// The new files.
    pub copied: Vec<PathBuf>,
    /// The names of the pictures that `to` has no copy of, and why.
    pub left_out: Vec<(String, PictureError)>,
}

/// Copies pictures from the folder `from` to the same names below the folder `to`. The names are relative, as
/// [`Model::file_pictures`](crate::Model::file_pictures) and `Scene::file_pictures` list them.
///
/// A file is copied if it begins as a picture, is not hidden, and is below `from`. Nothing is replaced: if `to` has the
/// same picture already, it stays, and another file of that name is a [`PictureError::Taken`]. Nothing is written
/// through a link. If both folders are the same, there is nothing to do.
///
/// ```no_run
/// let pictures = mesh_io::copy_pictures(&["wood.png"], "models".as_ref(), "small".as_ref());
/// for (name, error) in pictures.left_out {
///     eprintln!("{name}: {error}");
/// }
/// ```
#[must_use]
pub fn copy_pictures(names: &[impl AsRef<str>], from: &Path, to: &Path) -> CopiedPictures {
    let mut result = CopiedPictures::default();
    let folders = (fs::canonicalize(named(from)), fs::canonicalize(named(to)));
    if matches!(&folders, (Ok(from), Ok(to)) if from == to) {
        return result;
    }
    let mut names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    names.sort_unstable();
    names.dedup();
    let options = PictureOptions { folder: Some(from.to_owned()), ..PictureOptions::default() };
    for name in names {
        let copied = resolve(&options, folders.0.as_deref().ok(), name)
            .and_then(|source| copy_picture(&source, named(to), name));
        match copied {
            Ok(Some(path)) => result.copied.push(path),
            Ok(None) => {}
            Err(error) => result.left_out.push((name.to_owned(), error)),
        }
    }
    result
}

/// Copies a picture. `None` if it is there already.
fn copy_picture(source: &Path, to: &Path, name: &str) -> Result<Option<PathBuf>, PictureError> {
    let failed = |error: std::io::Error| PictureError::Read(error.to_string());
    let (mut file, _) = open(source).map_err(PictureError::Read)?;
    let mut head = Vec::new();
    (&mut file).take(HEAD).read_to_end(&mut head).map_err(failed)?;
    PictureFormat::of(&head).ok_or(PictureError::NoPicture)?;
    let target = to.join(below(name).map_err(PictureError::Read)?);
    make_folders(to, folder_of(&target))?;
    if fs::symlink_metadata(&target).is_ok() {
        return is_same(source, &target).map(|()| None);
    }
    let written = prepare_unlinked(&target, None, |writer| {
        writer.write_all(&head)?;
        copy(&mut file, writer)?;
        Ok(())
    });
    match written.and_then(crate::atomic::Beside::commit) {
        Ok(()) => Ok(Some(target)),
        // Another run was faster.
        Err(WriteError::Io { source: error, .. }) if error.kind() == ErrorKind::AlreadyExists => {
            is_same(source, &target).map(|()| None)
        }
        Err(error) => Err(PictureError::Read(error.to_string())),
    }
}

/// Makes the folders between `to` and `folder`, which is below it. A link on the way is refused.
fn make_folders(to: &Path, folder: &Path) -> Result<(), PictureError> {
    let mut path = to.to_owned();
    for part in folder.strip_prefix(to).unwrap_or(Path::new("")) {
        path.push(part);
        let is_folder = match fs::create_dir(&path) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                fs::symlink_metadata(&path).is_ok_and(|metadata| metadata.is_dir())
            }
            made => made.map(|()| true).map_err(|error| PictureError::Read(error.to_string()))?,
        };
        if !is_folder {
            return Err(PictureError::Taken);
        }
    }
    Ok(())
}

/// Compares two files.
fn is_same(source: &Path, target: &Path) -> Result<(), PictureError> {
    let compared = || -> std::io::Result<bool> {
        if !fs::symlink_metadata(target)?.is_file() {
            return Ok(fs::canonicalize(target)? == source);
        }
        let (mut a, mut b) = (File::open(source)?, File::open(target)?);
        if a.metadata()?.len() != b.metadata()?.len() {
            return Ok(false);
        }
        let (mut left, mut right) = (Vec::new(), Vec::new());
        loop {
            left.clear();
            right.clear();
            (&mut a).take(CHUNK).read_to_end(&mut left)?;
            (&mut b).take(CHUNK).read_to_end(&mut right)?;
            if left != right || left.is_empty() {
                return Ok(left == right);
            }
        }
    };
    match compared() {
        Ok(true) => Ok(()),
        Ok(false) => Err(PictureError::Taken),
        Err(error) => Err(PictureError::Read(error.to_string())),
    }
}

/// The bytes that are compared at once.
const CHUNK: u64 = 1 << 16;

fn named(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}
