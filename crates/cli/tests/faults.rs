//! Full disks and killed programs in the middle of writing, for every format: each file is the old one or the new one.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::code;
use mesh_io::{Image, ImageData, Material, Model, WriteOptions};
use mesh_shapes::Torus;

/// A torus with a material, texture coordinates and an embedded picture.
fn painted(around: usize, shade: u8) -> Model {
    let torus = Torus { major: 5.0, minor: 2.0 }.mesh(around, around / 2).unwrap();
    let mut model = Model::from(torus);
    let positions = model.soup.positions();
    let uv = |&vertex: &u32| {
        let p = positions[vertex as usize];
        [p.x as f32 / 16.0 + 0.5, p.y as f32 / 16.0 + 0.5]
    };
    model.corner_uvs = Some(model.soup.corners().iter().map(uv).collect());
    let picture = [b"\x89PNG\r\n\x1a\n".as_slice(), &[shade; 100_000]].concat();
    model.images = vec![Image {
        name: "paint".into(),
        media_type: "image/png".into(),
        data: ImageData::Bytes(picture),
    }];
    model.materials = vec![Material {
        name: "paint".into(),
        base_color: [f32::from(shade) / 255.0, 0.0, 0.0, 1.0],
        base_color_image: Some(0),
        ..Material::default()
    }];
    model.face_materials = Some(vec![0; model.soup.face_count()]);
    model
}

type Files = BTreeMap<String, Vec<u8>>;

fn content(folder: &Path) -> Files {
    let entries = std::fs::read_dir(folder).unwrap().map(Result::unwrap);
    let name = |entry: &std::fs::DirEntry| entry.file_name().into_string().unwrap();
    entries.map(|entry| (name(&entry), std::fs::read(entry.path()).unwrap())).collect()
}

/// A command that is run in a folder of files from an earlier run.
struct Case {
    root: tempfile::TempDir,
    arguments: Vec<&'static str>,
    old: Files,
    new: Files,
    /// The duration of a run.
    time: Duration,
}

impl Case {
    /// The command reads `../in.glb` and writes into the folder that it runs in.
    fn new(arguments: &[&'static str], around: usize) -> Self {
        let root = tempfile::tempdir().unwrap();
        let arguments = arguments.to_vec();
        let (old, new) = (Files::new(), Files::new());
        let mut case = Self { root, arguments, old, new, time: Duration::ZERO };
        std::fs::create_dir(case.folder()).unwrap();
        let mut run = |around, shade| {
            let model = painted(around, shade);
            mesh_io::write(case.root.path().join("in.glb"), &model, &WriteOptions::default())
                .unwrap();
            let start = Instant::now();
            let output = case.command(&[]).output().unwrap();
            assert!(output.status.success(), "{:?}: {}", case.arguments, said(&output));
            case.time = start.elapsed();
            content(&case.folder())
        };
        let old = run(around / 2, 100);
        let new = run(around, 200);
        (case.old, case.new) = (old, new);
        let names = |files: &Files| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&case.old), names(&case.new));
        assert!(case.old.iter().all(|(name, bytes)| case.new[name] != *bytes));
        case
    }

    fn folder(&self) -> PathBuf {
        self.root.path().join("out")
    }

    fn command(&self, before: &[&str]) -> Command {
        let program = env!("CARGO_BIN_EXE_curvmesh");
        let mut words =
            before.iter().copied().chain([program]).chain(self.arguments.iter().copied());
        let mut command = Command::new(words.next().unwrap());
        command.args(words).current_dir(self.folder());
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    /// Restores the files of the earlier run.
    fn reset(&self) {
        std::fs::remove_dir_all(self.folder()).unwrap();
        std::fs::create_dir(self.folder()).unwrap();
        for (name, bytes) in &self.old {
            std::fs::write(self.folder().join(name), bytes).unwrap();
        }
    }

    /// Asserts that every file is the old one or the new one. Returns the number of new files and the number of other
    /// files.
    fn check(&self, when: &str) -> (usize, usize) {
        let found = content(&self.folder());
        for (name, old) in &self.old {
            let is = found.get(name).unwrap_or_else(|| panic!("{when}: {name} is gone"));
            assert!(is == old || *is == self.new[name], "{when}: {name} is neither old nor new");
        }
        let strays = found.keys().filter(|name| !self.old.contains_key(*name));
        strays.clone().for_each(|name| assert!(name.starts_with(".mesh-io-"), "{when}: {name}"));
        (found.iter().filter(|(name, is)| self.new.get(*name) == Some(*is)).count(), strays.count())
    }

    /// Runs with files limited to this number of blocks of 512 bytes. Returns whether that was enough.
    fn on_a_full_disk(&self, blocks: usize) -> bool {
        self.reset();
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
        let output = self.command(&["sh", "-c", &script, "sh"]).output().unwrap();
        let when = format!("{:?} with {blocks} blocks: {}", self.arguments, said(&output));
        let (new, strays) = self.check(&when);
        assert_eq!(strays, 0, "{when}");
        if output.status.success() {
            assert_eq!(new, self.new.len(), "{when}");
            return true;
        }
        assert_eq!(output.status.code(), Some(1), "{when}");
        assert!(said(&output).contains("cannot write"), "{when}");
        // All are complete before the first is replaced.
        assert_eq!(new, 0, "{when}");
        false
    }

    /// Runs and sends a signal after a share of the usual time.
    fn with_signal(&self, signal: &str, part: f64) {
        self.reset();
        let mut run = self.command(&[]).spawn().unwrap();
        std::thread::sleep(self.time.mul_f64(part));
        let _ = Command::new("kill").args([signal, &run.id().to_string()]).output().unwrap();
        let status = run.wait().unwrap();
        let when = format!("{:?} {signal} at {part:.2}: {status}", self.arguments);
        let (new, strays) = self.check(&when);
        assert!(signal == "-KILL" || strays == 0, "{when}: {strays} stray files");
        assert!(!status.success() || new == self.new.len(), "{when}");
        // The next run removes what a killed one has left.
        if strays > 0 {
            assert!(self.command(&[]).output().unwrap().status.success(), "{when}");
            assert_eq!(self.check(&when), (self.new.len(), 0), "{when}");
        }
    }

    /// Every way of failing.
    fn fail(&self) {
        println!("{:?}: {:?}", self.arguments, self.time);
        let largest = self.new.values().map(Vec::len).max().unwrap();
        let blocks = largest.div_ceil(512);
        let mut limits: Vec<usize> = (0..8).map(|eighth| blocks * eighth / 8).collect();
        limits.extend([1, blocks - 1]);
        for limit in limits {
            assert!(!self.on_a_full_disk(limit), "{:?}: {limit} of {blocks}", self.arguments);
        }
        // Some shells count blocks of 1024 bytes.
        assert!(self.on_a_full_disk(2 * blocks + 2));
        for step in 0..24 {
            // Files are written near the end of a run.
            let part = 0.3 + 0.8 * f64::from(step) / 24.0;
            self.with_signal("-KILL", part);
            if step % 2 == 0 {
                self.with_signal("-INT", part);
            }
        }
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn every_format_is_whole_after_any_failure() {
    for output in ["out.ply", "out.stl", "out.off", "out.gltf", "out.glb"] {
        Case::new(&["convert", "../in.glb", "-o", output], 120).fail();
    }
}

#[test]
fn an_obj_file_and_its_companions_are_whole_after_any_failure() {
    let case = Case::new(&["convert", "../in.glb", "-o", "out.obj"], 120);
    let names: Vec<_> = case.new.keys().collect();
    assert_eq!(names, ["out-0.png", "out.mtl", "out.obj"]);
    case.fail();
}

#[test]
fn folders_of_levels_and_records_are_whole_after_any_failure() {
    let common = ["lod", "../in.glb", "--levels", "0.5,0.2", "--record", "run.lod", "-o"];
    let case = Case::new(&[&common[..], &[".", "--format", "obj"]].concat(), 40);
    let names: Vec<_> = case.new.keys().collect();
    let expected = ["in-1-0.png", "in-1.mtl", "in-1.obj", "in-2-0.png", "in-2.mtl", "in-2.obj"];
    assert_eq!(names[..6], expected);
    case.fail();
    Case::new(&[&common[..], &["levels.glb"]].concat(), 40).fail();
}

#[test]
fn companions_of_others_are_replaced_only_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    mesh_io::write(path("in.glb"), &painted(12, 100), &WriteOptions::default()).unwrap();
    std::fs::write(path("in-1.mtl"), "mine").unwrap();
    let levels = ["lod", &path("in.glb"), "-o", &path("."), "--format", "obj", "--levels", "0.5"];
    let (exit, said) = code(&levels);
    assert_eq!(exit, 1);
    assert!(said.contains("--overwrite-companions"), "{said}");
    assert_eq!(content(folder.path()).len(), 2);
    let (exit, said) = code(&[&levels[..], &["--overwrite-companions"]].concat());
    assert_eq!(exit, 0, "{said}");
    assert_eq!(content(folder.path()).len(), 4);
}

/// A mesh that is valid in 64 bits.
#[test]
fn coordinates_that_the_format_cannot_hold_end_in_exit_4() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let mut torus = Torus { major: 5.0, minor: 2.0 }.mesh(24, 12).unwrap();
    torus.positions_mut().iter_mut().for_each(|p| *p *= 1e38);
    mesh_io::write(path("far.ply"), &torus, &WriteOptions::default()).unwrap();
    for output in ["x.glb", "x.gltf", "x.stl"] {
        let (exit, said) = code(&["convert", &path("far.ply"), "-o", &path(output)]);
        assert_eq!(exit, 4, "{output}: {said}");
    }
    let lod = ["lod", &path("far.ply"), "--levels", "0.5", "--record", &path("x.lod"), "-o"];
    for output in [&[path("x.glb")][..], &[path("."), "--format".into(), "stl".into()]] {
        let output: Vec<&str> = output.iter().map(String::as_str).collect();
        let (exit, said) = code(&[&lod[..], &output[..]].concat());
        assert_eq!(exit, 4, "{output:?}: {said}");
    }
    assert_eq!(content(folder.path()).len(), 1);
}

/// The standard error is a file on a full disk: the message is lost, and nothing else.
#[test]
fn messages_that_cannot_be_written_change_no_exit_code() {
    let full = || std::fs::File::options().write(true).open("/dev/full").unwrap();
    for (arguments, code) in [(&["info", "missing.ply"][..], 3), (&["info"], 2)] {
        let mut run = Command::new(env!("CARGO_BIN_EXE_curvmesh"));
        let status = run.args(arguments).stdout(full()).stderr(full()).status().unwrap();
        assert_eq!(status.code(), Some(code), "{arguments:?}");
    }
}

/// `/dev/stdout` leads to a pipe, which has a name that is no path.
#[test]
fn the_device_of_the_standard_output_takes_a_mesh() {
    let root = tempfile::tempdir().unwrap();
    let input = root.path().join("in.glb");
    mesh_io::write(&input, &painted(12, 100), &WriteOptions::default()).unwrap();
    let [by_name, by_dash] = ["/dev/stdout", "-"].map(|output| {
        let mut run = Command::new(env!("CARGO_BIN_EXE_curvmesh"));
        run.args(["convert", "-q", "--to", "stl", "-o", output]).arg(&input).output().unwrap()
    });
    assert!(by_name.status.success(), "{}", said(&by_name));
    assert!(by_name.stdout.starts_with(&by_dash.stdout) && !by_dash.stdout.is_empty());
}
