//! The layout of a work folder.
//!
//! ```text
//! curvmesh-work               the mark of a work folder, which is locked while a process works in it
//! run.json                    the options, the statistics of the input, the cells
//! level-0/cell-3.region       the faces of a cell of the input
//! level-0/plan.json           the cost up to which the cells of the level are collapsed, or that they fit into memory
//! level-0/cell-3.reduced      the same cell after the collapses
//! level-1/cell-0.region       neighbouring cells joined
//! level-1/cell-0.refined      the same region as a part of a result, refined
//! level-3/cell-2.lod          the third result, made in memory from all regions of level 3
//! ```
//!
//! Beside each region lies its record, `cell-3.region.json`. It is written last: a step whose record is there and fits
//! its file is done.

use std::fs;
use std::path::Path;

use crate::error::Error;
use crate::private_files;

/// The manifest of a run.
pub(crate) const RUN: &str = "run.json";
/// The folder for temporary files while the input is split.
pub(crate) const SCRATCH: &str = "scratch";
/// The prefix of the folders for temporary files of refinement.
pub(crate) const REFINE: &str = "refine-";

/// The content of a file of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A region of a level.
    Region,
    /// A region after its collapses.
    Reduced,
    /// A region of a result, refined.
    Refined,
    /// A result that was made in memory. The number of the result stands in place of the cell.
    LodOutput,
}

impl Kind {
    fn extension(self) -> &'static str {
        match self {
            Self::Region => "region",
            Self::Reduced => "reduced",
            Self::Refined => "refined",
            Self::LodOutput => "lod",
        }
    }
}

/// The path of the plan of a level, within the work folder.
pub(crate) fn plan(level: u32) -> String {
    format!("level-{level}/plan.json")
}

/// The path of the file of a cell, within the work folder.
pub(crate) fn cell(level: u32, cell: u32, kind: Kind) -> String {
    format!("level-{level}/cell-{cell}.{}", kind.extension())
}

/// The path of the record of a cell, within the work folder.
pub(crate) fn record(level: u32, cell: u32, kind: Kind) -> String {
    format!("{}.json", self::cell(level, cell, kind))
}

/// Creates the folder of a level if it is missing.
pub(crate) fn create_level(folder: &Path, level: u32) -> Result<(), Error> {
    let path = folder.join(format!("level-{level}"));
    private_files::create_folder(&path).map(drop).map_err(Error::io(&path))
}

/// The entries of a work folder whose names begin with `prefix`.
fn entries(folder: &Path, prefix: &str) -> impl Iterator<Item = fs::DirEntry> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter(move |entry| entry.file_name().to_string_lossy().starts_with(prefix))
}

/// Checks that the folders of levels are folders, and no links to other places.
pub(crate) fn check_levels(folder: &Path) -> Result<(), Error> {
    for entry in entries(folder, "level-") {
        let path = entry.path();
        if !entry.file_type().map_err(Error::io(&path))?.is_dir() {
            return Err(Error::damaged(&path, "this is not a folder"));
        }
    }
    Ok(())
}

/// Removes the levels and the temporary files of a run, if possible. Links are removed, not followed.
pub(crate) fn remove_content(folder: &Path) {
    remove_leftovers(folder);
    for path in entries(folder, "level-").map(|entry| entry.path()) {
        remove(&path);
    }
    remove(&folder.join(SCRATCH));
}

/// Removes the leftovers of killed processes, if possible: folders of refinements, and files that were not yet in their
/// places. No process may work in the folder.
pub(crate) fn remove_leftovers(folder: &Path) {
    entries(folder, REFINE).for_each(|entry| remove(&entry.path()));
    for level in
        entries(folder, "level-").filter(|entry| entry.file_type().is_ok_and(|t| t.is_dir()))
    {
        for entry in entries(&level.path(), private_files::UNFINISHED) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn remove(path: &Path) {
    // Files that cannot be removed only take space.
    let _ = fs::remove_dir_all(path);
}
