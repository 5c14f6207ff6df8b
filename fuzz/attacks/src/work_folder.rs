//! Work folders of meshes larger than memory, with changed files.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use mesh_io::ReadOptions;
use out_of_core::{Capacity, Error, Input, Region, Repairs, Settings, Work, run};
use sha2::{Digest, Sha256};
use simplify::{Options, Preset};
use tempfile::TempDir;

/// Changes a file of a finished run and runs it again. The first byte selects the file. The second one tells whether a
/// valid checksum is put at its end. Then follow pairs of a position, in two bytes, and a new byte for it. If the
/// second byte is above 127, the remaining bytes are the whole file.
pub fn attack(data: &[u8]) {
    let &[which, kind, ref changes @ ..] = data else { return };
    let good = good();
    let (name, content) = &good.files[usize::from(which) % good.files.len()];
    let mut bytes = content.clone();
    if kind > 127 {
        bytes = changes.to_vec();
    } else {
        for &[high, low, value] in changes.as_chunks::<3>().0 {
            let at = usize::from(u16::from_be_bytes([high, low])) % bytes.len();
            bytes[at] = value;
        }
    }
    if kind % 2 == 1 {
        seal(name, &mut bytes);
    }
    let folder = tempfile::tempdir().expect("a folder for the attack");
    copy(&good.folder.path().join("work"), &folder.path().join("work"));
    let work = folder.path().join("work");
    fs::write(work.join(name), &bytes).expect("the file is written");
    match again(&work) {
        Ok(mesh) => assert_eq!(mesh, good.result, "{} has changed the result", name.display()),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    let _ = Region::read(&work.join(name));
}

/// A finished run.
struct Good {
    folder: TempDir,
    /// The records, plans and regions, by their paths in the work folder.
    files: Vec<(PathBuf, Vec<u8>)>,
    result: Vec<[u64; 3]>,
}

fn good() -> &'static Good {
    static GOOD: OnceLock<Good> = OnceLock::new();
    GOOD.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        let input = folder.path().join("in.ply");
        fs::write(&input, waves(24)).expect("the input is written");
        let work = folder.path().join("work");
        let settings = Settings {
            options: Options::preset(Preset::Draft).to_faces(60),
            finer_levels: Vec::new(),
            repairs: Repairs::default(),
            capacity: Capacity { region_faces: 300, in_memory_faces: 250, stream: 1 << 16 },
            prove: Some(1e-2),
        };
        let reading = ReadOptions::default();
        let split = Work::split(&work, Input::Path(&input), &reading, settings, &mut |_| true);
        drop(split.expect("the input is split"));
        let result = again(&work).expect("the run ends");
        let mut files = Vec::new();
        list(&work, Path::new(""), &mut files);
        files.sort();
        Good { folder, files, result }
    })
}

/// Opens a work folder, and finishes the run.
fn again(work: &Path) -> Result<Vec<[u64; 3]>, Error> {
    let work = Work::open(work)?;
    work.current()?;
    let mesh = run(&work, &mut |_| true)?.into_mesh();
    let positions = mesh.map(|mesh| mesh.positions().to_vec()).unwrap_or_default();
    Ok(positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect())
}

/// A sheet of waves with n by n quadrilaterals, as PLY.
fn waves(n: usize) -> String {
    let (vertices, faces) = ((n + 1) * (n + 1), n * n);
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    for i in 0..vertices {
        let (x, y) = ((i / (n + 1)) as f64, (i % (n + 1)) as f64);
        text += &format!("{x} {y} {}\n", (0.7 * x).sin() + (0.4 * y).cos());
    }
    for i in 0..faces {
        let corner = i / n * (n + 1) + i % n;
        text += &format!("4 {corner} {} {} {}\n", corner + n + 1, corner + n + 2, corner + 1);
    }
    text
}

/// Puts the checksum of a file at its end; in a record it is written in digits before the last three bytes.
fn seal(name: &Path, bytes: &mut Vec<u8>) {
    if name.extension().is_some_and(|extension| extension == "json") {
        let Some(start) = bytes.len().checked_sub(67) else { return };
        bytes.truncate(start);
        bytes.extend([b'0'; 64]);
        bytes.extend(b"\"\n}");
        let sum = Sha256::digest(&*bytes);
        let digits: String = sum.iter().map(|byte| format!("{byte:02x}")).collect();
        bytes[start..start + 64].copy_from_slice(digits.as_bytes());
    } else if let Some(start) = bytes.len().checked_sub(32) {
        let sum = Sha256::digest(&bytes[..start]);
        bytes[start..].copy_from_slice(&sum);
    }
}

fn list(folder: &Path, below: &Path, files: &mut Vec<(PathBuf, Vec<u8>)>) {
    for entry in fs::read_dir(folder.join(below)).expect("the folder is listed") {
        let name = below.join(entry.expect("an entry").file_name());
        if folder.join(&name).is_dir() {
            list(folder, &name, files);
        } else if name != Path::new("curvmesh-work") {
            let content = fs::read(folder.join(&name)).expect("a file is read");
            files.push((name, content));
        }
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).expect("a new folder");
    for entry in fs::read_dir(from).expect("the folder is listed") {
        let entry = entry.expect("an entry");
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            // `fs::copy` does not go on after a signal, such as the timer of the fuzzer.
            let content = fs::read(entry.path()).expect("a file is read");
            fs::write(target, content).expect("a file is written");
        }
    }
}
