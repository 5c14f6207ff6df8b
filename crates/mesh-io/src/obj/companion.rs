//! The ownership of the files beside an OBJ file.
//!
//! Users do not name the material library and the pictures beside an OBJ file, so these files replace only files of
//! earlier runs. The first line of a library written by this crate contains the name of the OBJ file and a checksum of
//! the lines that follow; the library also lists the pictures written with it, with their checksums. A file is from an
//! earlier run of the same output if all of this matches. A file that was changed since, or that has another origin, is
//! replaced only on request.

use crate::atomic::{Beside, prepare_unlinked};
use crate::error::WriteError;
use mesh_core::Checksum;
use std::fs::{self, File, Metadata};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

/// The longest line that is examined here.
const LONGEST_LINE: u64 = 1 << 16;

/// The first line of the library for the OBJ file of this name.
pub(super) fn first_line(output: &str, rest: Checksum) -> String {
    format!("# Material library of {output}, written by mesh-io, checksum {rest}")
}

/// The line for a picture that was written with the library.
pub(super) fn picture_line(name: &str, content: Checksum) -> String {
    format!("# picture {content} {name}")
}

/// The library of an earlier run of the same output, if it is unchanged.
pub(super) struct Earlier {
    pictures: Vec<String>,
}

impl Earlier {
    /// Reads the library at `path`. If it cannot be read, it counts as a file of other origin.
    pub(super) fn find(path: &Path, output: &str) -> Option<Self> {
        if !fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_file()) {
            return None;
        }
        let mut reader = BufReader::new(File::open(path).ok()?);
        let mut line = Vec::new();
        let mut next = |line: &mut Vec<u8>| {
            line.clear();
            reader.by_ref().take(LONGEST_LINE).read_until(b'\n', line)
        };
        next(&mut line).ok()?;
        let first = String::from_utf8(line.trim_ascii_end().to_vec()).ok()?;
        if first.rsplit_once(' ')?.0 != first_line(output, Checksum::default()).rsplit_once(' ')?.0
        {
            return None;
        }
        let (mut rest, mut pictures) = (Checksum::default(), Vec::new());
        while next(&mut line).ok()? > 0 {
            rest.add(&line);
            if line.starts_with(b"# picture ") {
                pictures.push(String::from_utf8_lossy(&line).trim_end().to_owned());
            }
        }
        (first == first_line(output, rest)).then_some(Self { pictures })
    }

    /// The line of the picture with this name, if it was written with the library.
    pub(super) fn line_of(&self, name: &str) -> Option<&str> {
        let is_of = |line: &&String| line.splitn(4, ' ').nth(3) == Some(name);
        self.pictures.iter().find(is_of).map(String::as_str)
    }

    /// Whether the picture with this name is unchanged since it was written with the library.
    fn has_picture(&self, name: &str, content: Checksum) -> bool {
        self.pictures.contains(&picture_line(name, content))
    }
}

/// The companions of an output, and the rules for existing files.
pub(super) struct Companions<'p> {
    folder: &'p Path,
    pub(super) earlier: Option<Earlier>,
    overwrite: bool,
    /// The prepared files.
    pub(super) prepared: Vec<Beside>,
    /// Their paths, and the paths of existing files with the same content.
    pub(super) paths: Vec<PathBuf>,
}

impl<'p> Companions<'p> {
    pub(super) fn new(folder: &'p Path, earlier: Option<Earlier>, overwrite: bool) -> Self {
        Self { folder, earlier, overwrite, prepared: Vec::new(), paths: Vec::new() }
    }

    /// Prepares a picture, unless it exists already.
    pub(super) fn picture(&mut self, name: &str, bytes: &[u8]) -> Result<(), WriteError> {
        let path = self.folder.join(name);
        let old = there(&path)?;
        let same = |old: &Metadata| -> Result<bool, WriteError> {
            Ok(old.is_file()
                && old.len() == bytes.len() as u64
                && checksum_of(&path)? == Checksum::of(bytes))
        };
        let is_there = old.as_ref().map(same).transpose()?.unwrap_or(false);
        if !is_there {
            let ours = match (&self.earlier, &old) {
                (Some(earlier), Some(old)) if old.is_file() => {
                    earlier.has_picture(name, checksum_of(&path)?)
                }
                _ => false,
            };
            self.check(&path, old.as_ref(), ours)?;
            let write = |writer: &mut dyn Write| Ok(writer.write_all(bytes)?);
            self.prepared.push(prepare_unlinked(&path, old.as_ref(), write)?);
        }
        self.paths.push(path);
        Ok(())
    }

    /// Prepares the library.
    pub(super) fn library(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> Result<(), WriteError>,
    ) -> Result<(), WriteError> {
        let path = self.folder.join(name);
        let old = there(&path)?;
        self.check(&path, old.as_ref(), self.earlier.is_some())?;
        self.prepared.push(prepare_unlinked(&path, old.as_ref(), write)?);
        self.paths.push(path);
        Ok(())
    }

    /// Checks whether a file may replace an existing one.
    fn check(&self, path: &Path, old: Option<&Metadata>, ours: bool) -> Result<(), WriteError> {
        let Some(old) = old else { return Ok(()) };
        if !old.is_file() && !old.is_symlink() {
            let source = std::io::Error::other(
                "a companion of the output goes there, but what is there is no file",
            );
            return Err(WriteError::Io { path: Some(path.to_owned()), source });
        }
        if self.overwrite || (ours && old.is_file()) {
            if old.is_file() && old.permissions().readonly() {
                return Err(WriteError::ReadOnly(path.to_owned()));
            }
            return Ok(());
        }
        let why = if old.is_symlink() {
            "is a link"
        } else {
            "is not from an earlier run of this output, or was changed since"
        };
        Err(WriteError::Companion { path: path.to_owned(), why })
    }
}

/// The metadata of a path, without following links.
fn there(path: &Path) -> Result<Option<Metadata>, WriteError> {
    match fs::symlink_metadata(path) {
        Ok(metadata) => Ok(Some(metadata)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(source) => Err(WriteError::Io { path: Some(path.to_owned()), source }),
    }
}

fn checksum_of(path: &Path) -> Result<Checksum, WriteError> {
    let mut sum = Checksum::default();
    let read = File::open(path).and_then(|mut file| std::io::copy(&mut file, &mut sum));
    read.map_err(|source| WriteError::Io { path: Some(path.to_owned()), source })?;
    Ok(sum)
}
