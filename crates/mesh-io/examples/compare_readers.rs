//! Memory and time of three readers on a folder of OBJ, glTF and other files, as a table in Markdown.
//!
//!     cargo run --release -p mesh-io --example compare_readers --features tobj,gltf-crate -- FOLDER
//!
//! Every reader that supports the format of a file reads it five times; the time is the smallest of the five. Peak
//! memory is heap memory, including the bytes of the file if a reader holds them.
#![allow(clippy::print_stdout, reason = "the table is the result")]

use mesh_io::{Model, ReadOptions, read_with};
use peak_alloc::PeakAlloc;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// The number of times that each file is read.
const TIMES: usize = 5;

/// A reader: returns the numbers of vertices and triangles of a file, or the reason for a rejection.
type Reader = fn(&Path) -> Result<[usize; 2], String>;

fn counts(model: &Model) -> [usize; 2] {
    let triangles = model.soup.faces().map(|face| face.len() - 2).sum();
    [model.soup.vertex_count(), triangles]
}

fn ours(path: &Path) -> Result<[usize; 2], String> {
    let model = read_with(path, &ReadOptions::default()).map_err(|error| error.to_string())?;
    Ok(counts(&model))
}

fn tobj(path: &Path) -> Result<[usize; 2], String> {
    let loaded = tobj::load_obj(path, &tobj::LoadOptions::default());
    let (models, _) = loaded.map_err(|error| error.to_string())?;
    let meshes = || models.iter().map(|model| &model.mesh);
    let of_mesh = |mesh: &tobj::Mesh| match mesh.face_arities.as_slice() {
        [] => mesh.indices.len() / 3,
        arities => arities.iter().map(|&arity| arity.saturating_sub(2) as usize).sum(),
    };
    let vertices = meshes().map(|mesh| mesh.positions.len() / 3).sum();
    Ok([vertices, meshes().map(of_mesh).sum()])
}

/// The document, its buffers, and the positions and indices of every primitive that a node draws.
fn gltf(path: &Path) -> Result<[usize; 2], String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    let gltf::Gltf { document, blob } =
        gltf::Gltf::from_slice(&bytes).map_err(|error| error.to_string())?;
    let buffers: Vec<Vec<u8>> = blob.into_iter().collect();
    Model::from_gltf(&document, &buffers).map(|m| counts(&m)).map_err(|error| error.to_string())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args_os().nth(1).map(PathBuf::from).ok_or("name a folder of meshes")?;
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)?
        .map(|entry| entry.map(|e| e.path()))
        .collect::<Result<_, _>>()?;
    paths.sort();
    println!("| file | bytes | reader | triangles | peak bytes per byte | ms |");
    println!("|---|---:|---|---:|---:|---:|");
    for path in paths {
        let other: Option<(&str, Reader)> = match path.extension().and_then(|e| e.to_str()) {
            Some("obj") => Some(("tobj", tobj)),
            Some("glb" | "gltf") => Some(("gltf", gltf)),
            _ => None,
        };
        let bytes = std::fs::metadata(&path)?.len();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        for (reader, read) in [("mesh-io", ours as Reader)].into_iter().chain(other) {
            let row = measure(read, &path, bytes);
            println!("| {name} | {bytes} | {reader} | {row} |");
        }
    }
    Ok(())
}

/// The last three cells of a row.
fn measure(read: Reader, path: &Path, bytes: u64) -> String {
    let before = HEAP.current_usage();
    HEAP.reset_peak_usage();
    let first = read(path);
    let peak = HEAP.peak_usage().saturating_sub(before) as f64 / bytes.max(1) as f64;
    let seconds = (0..TIMES).map(|_| {
        let start = Instant::now();
        drop(read(path));
        start.elapsed().as_secs_f64()
    });
    let ms = 1e3 * seconds.fold(f64::INFINITY, f64::min);
    match first {
        Ok([_, triangles]) => format!("{triangles} | {peak:.1} | {ms:.1}"),
        Err(why) => {
            let why: String = why.chars().take(60).filter(|c| *c != '|').collect();
            format!("refused: {why} | {peak:.1} | {ms:.1}")
        }
    }
}
