//! Folders for temporary files in places that others can write to.

#![allow(clippy::unwrap_used)]

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use out_of_core::ScratchFolder;

fn entries(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
}

#[test]
fn a_scratch_folder_is_new_private_and_removed() {
    let parent = tempfile::tempdir().unwrap();
    let name = OsStr::new("out.ply");
    let [first, second] = [(); 2].map(|()| ScratchFolder::new(parent.path(), name).unwrap());
    // A folder whose owner exists is left alone.
    assert!(first.path() != second.path() && first.path().exists());
    for scratch in [&first, &second] {
        assert!(scratch.path().file_name().unwrap().to_string_lossy().starts_with(".out.ply-"));
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = fs::metadata(scratch.path()).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o700);
        }
    }
    drop((first, second));
    assert!(entries(parent.path()).is_empty());
}

#[test]
fn what_a_killed_run_has_left_is_removed_by_the_next_one_of_the_same_output() {
    let parent = tempfile::tempdir().unwrap();
    let killed = ScratchFolder::new(parent.path(), OsStr::new("out.ply")).unwrap();
    let name = killed.path().file_name().unwrap().to_owned();
    let mark = fs::read(killed.path().join("curvmesh-work")).unwrap();
    drop(killed);
    // The lock ends with its holder; the folder stays.
    let make = |name: &OsStr, mark: Option<&[u8]>| {
        let folder = parent.path().join(name);
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("points"), "x").unwrap();
        if let Some(mark) = mark {
            fs::write(folder.join("curvmesh-work"), mark).unwrap();
        }
        folder
    };
    let left = make(&name, Some(&mark));
    let of_other_output = make(OsStr::new(".other.ply-abcdefabcdef.curvmesh"), Some(&mark));
    let of_other_machine = make(OsStr::new(".out.ply-000000000000.curvmesh"), Some(b"machine 7"));
    let unmarked = make(OsStr::new(".out.ply-111111111111.curvmesh"), None);
    let scratch = ScratchFolder::new(parent.path(), OsStr::new("out.ply")).unwrap();
    assert!(!left.exists());
    assert!(of_other_output.exists() && of_other_machine.exists() && unmarked.exists());
    assert!(scratch.path().exists());
}

/// The name of a folder has at most 255 bytes, and so has the name of the output that is part of it.
#[test]
fn an_output_of_any_name_has_a_scratch_folder() {
    let parent = tempfile::tempdir().unwrap();
    for name in ["x".repeat(255), "é".repeat(127), format!("x{}", "é".repeat(127))] {
        let scratch = ScratchFolder::new(parent.path(), OsStr::new(&name)).unwrap();
        assert!(scratch.path().is_dir());
    }
    assert!(entries(parent.path()).is_empty());
}

/// A link with the name of a leftover is not followed.
#[cfg(unix)]
#[test]
fn links_to_other_folders_are_not_followed() {
    let parent = tempfile::tempdir().unwrap();
    let private = tempfile::tempdir().unwrap();
    fs::write(private.path().join("letter.txt"), "dear").unwrap();
    let killed = ScratchFolder::new(parent.path(), OsStr::new("out.ply")).unwrap();
    fs::copy(killed.path().join("curvmesh-work"), private.path().join("curvmesh-work")).unwrap();
    drop(killed);
    let link = parent.path().join(".out.ply-000000000000.curvmesh");
    std::os::unix::fs::symlink(private.path(), &link).unwrap();
    drop(ScratchFolder::new(parent.path(), OsStr::new("out.ply")).unwrap());
    assert_eq!(fs::read_to_string(private.path().join("letter.txt")).unwrap(), "dear");
}
