//! Work folders that were changed, forged, or are in use: the result is a typed error or unchanged.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{Done, bits, settings, split, torus, write};
use out_of_core::{Error, Settings, Work, run};
use sha2::{Digest, Sha256};
use simplify::Preset;

/// A run that proves distances, in its own folder.
struct Given {
    folder: tempfile::TempDir,
    input: PathBuf,
    settings: Settings,
}

impl Given {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let input = write(&torus(6000, 0), &folder.path().join("in.ply"));
        let settings = Settings { prove: Some(1e-3), ..settings(Preset::Draft, 300, 1500, 1000) };
        Self { folder, input, settings }
    }

    fn work(&self) -> PathBuf {
        self.folder.path().join("work")
    }

    fn split(&self) -> Work {
        split(&self.work(), &self.input, &self.settings).unwrap()
    }

    /// All JSON files of the folder.
    fn records(&self) -> Vec<PathBuf> {
        let mut found = vec![self.work().join("run.json")];
        for level in 0.. {
            let Ok(files) = fs::read_dir(self.work().join(format!("level-{level}"))) else { break };
            let paths = files.map(|file| file.unwrap().path());
            found.extend(paths.filter(|path| path.extension().is_some_and(|e| e == "json")));
        }
        found.sort();
        found
    }

    /// Opens the folder and does the remaining steps.
    fn run(&self) -> Result<Done, Error> {
        let work = Work::open(&self.work())?;
        work.current()?;
        run(&work, &mut |_| true).map(Done::from)
    }
}

/// The text with a matching checksum, as written by someone who knows the format.
fn sealed(text: &str) -> String {
    let body = text.len() - 3 - 64;
    let zeros = format!("{}{}\"\n}}", &text[..body], "0".repeat(64));
    let sum: String = Sha256::digest(&zeros).iter().map(|byte| format!("{byte:02x}")).collect();
    format!("{}{sum}\"\n}}", &text[..body])
}

fn is_typed(error: &Error, path: &Path) -> bool {
    let is_known = matches!(
        error,
        Error::Damaged { .. }
            | Error::Io { .. }
            | Error::Unsupported(..)
            | Error::TooManyRegions { .. }
            | Error::OtherRun { .. }
            | Error::Simplify(_)
            | Error::NoWorkFolder { .. }
    );
    is_known && !error.to_string().is_empty() && path.exists()
}

#[test]
fn a_proof_cannot_be_lowered_by_a_record() {
    let given = Given::new();
    let work = given.split();
    let whole = Done::from(run(&work, &mut |_| true).unwrap());
    assert!(whole.error.unwrap() > 0.0 && whole.levels.len() > 1);
    drop(work);
    let path = given.work().join("level-0/cell-1.reduced.json");
    let text = fs::read_to_string(&path).unwrap();
    let place = text.find("\"moved\": ").unwrap() + 9;
    let end = place + text[place..].find('\n').unwrap();
    let forged = format!("{}0.0{}", &text[..place], &text[end..]);
    fs::write(&path, &forged).unwrap();
    let refused = given.run();
    let Err(Error::Damaged { path: named, .. }) = refused else { panic!("{refused:?}") };
    assert_eq!(named, path);
    // With a matching checksum, it differs from the input of the next level.
    fs::write(&path, sealed(&forged)).unwrap();
    assert!(matches!(given.run(), Err(Error::Damaged { .. })));
    // The cure is the one named in the message.
    fs::remove_file(&path).unwrap();
    fs::write(&path, &text).unwrap();
    let again = given.run().unwrap();
    assert_eq!((bits(&again.mesh), again.error), (bits(&whole.mesh), whole.error));
}

#[test]
fn records_of_another_run_or_another_place_are_refused() {
    let given = Given::new();
    drop(given.split());
    let other = Given::new();
    drop(other.split());
    for name in ["cell-0.region.json", "cell-1.region.json"] {
        let path = given.work().join("level-0").join(name);
        let own = fs::read(&path).unwrap();
        for source in [
            other.work().join("level-0").join(name),
            given.work().join("level-0/cell-2.region.json"),
        ] {
            fs::copy(source, &path).unwrap();
            assert!(matches!(given.run(), Err(Error::Damaged { .. })), "{name}");
        }
        fs::write(&path, own).unwrap();
    }
    given.run().unwrap();
}

/// Numbers that no run writes, with matching checksums.
#[test]
fn forged_numbers_end_in_an_error() {
    let given = Given::new();
    drop(given.split());
    Work::open(&given.work()).unwrap().plan(0).unwrap();
    let forgeries = [
        ("run.json", "\"axis\": 0", "\"axis\": 7"),
        ("run.json", "\"axis\": 1", "\"axis\": 255"),
        ("run.json", "\"triangles\": ", "\"triangles\": 1844674407370955"),
        ("run.json", "\"vertices\": ", "\"vertices\": 1844674407370955"),
        ("run.json", "\"region_faces\": 1500", "\"region_faces\": 0"),
        ("run.json", "\"region_faces\": 1500", "\"region_faces\": 18446744073709551615"),
        ("run.json", "\"prove\": 0.001", "\"prove\": -1.0"),
        ("level-0/plan.json", "\"bits\": ", "\"bits\": 4000"),
        ("level-0/plan.json", "\"cells\": ", "\"cells\": 7"),
        ("level-0/plan.json", "\"cells\": ", "\"cells\": 429496"),
        ("level-0/plan.json", "\"aim\": ", "\"aim\": 1844674407370"),
        ("level-0/plan.json", "\"faces\": ", "\"faces\": 1844674407370"),
        ("level-0/cell-0.region.json", "\"faces\": ", "\"faces\": 1844674407370"),
        ("level-0/cell-0.region.json", "\"bytes\": ", "\"bytes\": 1844674407370"),
    ];
    for (name, from, to) in forgeries {
        let path = given.work().join(name);
        let text = fs::read_to_string(&path).unwrap();
        let forged = text.replacen(from, to, 1);
        if forged == text {
            continue;
        }
        fs::write(&path, sealed(&forged)).unwrap();
        let refused = given.run();
        assert!(refused.as_ref().is_err_and(|e| is_typed(e, &path)), "{name} {to}: {refused:?}");
        fs::write(&path, text).unwrap();
    }
    given.run().unwrap();
}

/// Any change of a record is detected, or has no effect.
#[test]
fn random_changes_never_change_a_result() {
    let given = Given::new();
    let work = given.split();
    let whole = Done::from(run(&work, &mut |_| true).unwrap());
    drop(work);
    let mut random = fastrand::Rng::with_seed(5);
    let records = given.records();
    assert!(records.len() > 8);
    for round in 0..150 {
        let path = &records[random.usize(0..records.len())];
        let bytes = fs::read(path).unwrap();
        let mut changed = bytes.clone();
        match round % 3 {
            0 => changed.truncate(random.usize(0..bytes.len())),
            1 => changed[random.usize(0..bytes.len())] ^= 1 << random.u8(0..8),
            _ => {
                // A changed digit, with a matching checksum.
                let digits: Vec<usize> =
                    (0..bytes.len() - 80).filter(|&place| bytes[place].is_ascii_digit()).collect();
                changed[digits[random.usize(0..digits.len())]] = b'0' + random.u8(0..10);
                changed = sealed(&String::from_utf8(changed).unwrap()).into_bytes();
            }
        }
        fs::write(path, &changed).unwrap();
        match given.run() {
            Err(error) => assert!(is_typed(&error, path), "{round} {}: {error}", path.display()),
            Ok(done) => assert!(bits(&done.mesh) == bits(&whole.mesh), "{}", path.display()),
        }
        fs::write(path, bytes).unwrap();
    }
    assert_eq!(given.run().unwrap().error, whole.error);
}

#[test]
fn a_folder_that_is_in_use_is_told_so() {
    let given = Given::new();
    let work = given.split();
    // Parallel steps are allowed; a whole run needs the folder for itself.
    let beside = Work::open(&given.work()).unwrap();
    beside.plan(0).unwrap();
    beside.reduce(0, 1).unwrap();
    let refused = run(&work, &mut |_| true);
    assert!(matches!(refused, Err(Error::InUse { .. })), "{refused:?}");
    drop(beside);
    let mut met = 0;
    run(&work, &mut |_| {
        let refused = Work::open(&given.work());
        assert!(matches!(refused, Err(Error::InUse { .. })), "{refused:?}");
        met += 1;
        true
    })
    .unwrap();
    assert!(met > 0);
    Work::open(&given.work()).unwrap();
    // While an input is split, no other process can split it.
    let reading = mesh_io::ReadOptions::default();
    let other = given.folder.path().join("other");
    let mut met = 0;
    let input = || out_of_core::Input::Path(&given.input);
    Work::split(&other, input(), &reading, given.settings.clone(), &mut |_| {
        let refused = split(&other, &given.input, &given.settings);
        assert!(matches!(refused, Err(Error::InUse { .. })), "{refused:?}");
        met += 1;
        true
    })
    .unwrap();
    assert!(met > 0);
}

#[cfg(unix)]
#[test]
fn nothing_is_read_or_written_through_links() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let given = Given::new();
    let private = given.folder.path().join("private.txt");
    fs::write(&private, "keep").unwrap();
    // The mark as a link.
    fs::create_dir(given.work()).unwrap();
    symlink(&private, given.work().join("curvmesh-work")).unwrap();
    let refused = split(&given.work(), &given.input, &given.settings);
    assert!(matches!(refused, Err(Error::Io { .. })), "{refused:?}");
    fs::remove_dir_all(given.work()).unwrap();
    // The folder as a link.
    let elsewhere = given.folder.path().join("elsewhere");
    fs::create_dir(&elsewhere).unwrap();
    symlink(&elsewhere, given.work()).unwrap();
    assert!(split(&given.work(), &given.input, &given.settings).is_err());
    assert_eq!(fs::read_dir(&elsewhere).unwrap().count(), 0);
    fs::remove_file(given.work()).unwrap();
    // A region and a level as links.
    drop(given.split());
    Work::open(&given.work()).unwrap().plan(0).unwrap();
    let [region, record] = ["cell-0.reduced", "cell-0.reduced.json"]
        .map(|name| given.work().join("level-0").join(name));
    symlink(&private, &region).unwrap();
    assert!(given.run().is_err());
    fs::remove_file(&region).unwrap();
    symlink(&elsewhere, given.work().join("level-1")).unwrap();
    assert!(matches!(given.run(), Err(Error::Damaged { .. })));
    assert_eq!(fs::read_dir(&elsewhere).unwrap().count(), 0);
    assert_eq!(fs::read_to_string(&private).unwrap(), "keep");
    fs::remove_file(given.work().join("level-1")).unwrap();
    // The record of an unfinished step is written again, in place of the link.
    symlink(&private, &record).unwrap();
    Work::open(&given.work()).unwrap().reduce(0, 0).unwrap();
    assert!(fs::symlink_metadata(&record).unwrap().is_file());
    assert_eq!(fs::read_to_string(&private).unwrap(), "keep");
    // A folder that others can write to.
    fs::set_permissions(given.work(), fs::Permissions::from_mode(0o777)).unwrap();
    assert!(matches!(Work::open(&given.work()), Err(Error::Io { .. })));
    fs::set_permissions(given.work(), fs::Permissions::from_mode(0o700)).unwrap();
    given.run().unwrap();
    for entry in fs::read_dir(given.work()).unwrap() {
        let mode = entry.unwrap().metadata().unwrap().permissions().mode();
        assert_eq!(mode & 0o077, 0, "only the owner reads a work folder");
    }
}

/// A process that was killed while it wrote a region leaves a file that has no name yet.
#[test]
fn unfinished_files_of_a_killed_process_are_removed() {
    let given = Given::new();
    let whole = Done::from(run(&given.split(), &mut |_| true).unwrap());
    for level in ["level-0", "level-1"] {
        fs::write(given.work().join(level).join(".new-AbCdEf"), "half a region").unwrap();
    }
    let again = given.run().unwrap();
    assert_eq!((bits(&again.mesh), again.error), (bits(&whole.mesh), whole.error));
    for level in ["level-0", "level-1"] {
        let files = fs::read_dir(given.work().join(level)).unwrap();
        let names: Vec<_> = files.map(|file| file.unwrap().file_name()).collect();
        assert!(names.iter().all(|name| !name.to_string_lossy().starts_with('.')), "{names:?}");
    }
}

/// Only root can give a folder to another user, so the test does nothing for others.
#[cfg(unix)]
#[test]
fn a_folder_of_another_user_stays_as_it_is() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let given = Given::new();
    let folder = given.work();
    fs::create_dir(&folder).unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o777)).unwrap();
    if std::os::unix::fs::chown(&folder, Some(4321), None).is_err() {
        return;
    }
    let before = fs::metadata(&folder).unwrap();
    let refused = split(&folder, &given.input, &given.settings);
    let Err(Error::Io { path, source }) = refused else { panic!("{refused:?}") };
    assert_eq!((path, source.kind()), (folder.clone(), std::io::ErrorKind::PermissionDenied));
    let after = fs::metadata(&folder).unwrap();
    assert_eq!((after.mode(), after.mtime_nsec()), (before.mode(), before.mtime_nsec()));
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
}
