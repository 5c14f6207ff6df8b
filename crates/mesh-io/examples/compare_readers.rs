//! Memory and time of three readers on a folder of OBJ, glTF and other files, as two tables in Markdown: one row for
//! each file and reader, and one for each format and reader, with the files that a reader refuses or of which it has
//! another number of triangles than `mesh-io`.
//!
//!     cargo run --release -p mesh-io --example compare_readers --features tobj,gltf-crate -- FOLDER
//!
//! Every reader that supports the format of a file reads it five times; the time is the smallest of the five. Peak
//! memory is heap memory, including the bytes of the file if a reader holds them.
#![allow(clippy::print_stdout, reason = "the table is the result")]

use mesh_io::{Model, ReadOptions, read_with};
use peak_alloc::PeakAlloc;
use std::collections::BTreeMap;
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

/// The document, its buffer, and the positions and indices of every primitive that a node draws, decoded as the
/// crate describes them. Nothing of `mesh-io` takes part.
fn gltf(path: &Path) -> Result<[usize; 2], String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    let gltf::Gltf { document, blob } =
        gltf::Gltf::from_slice(&bytes).map_err(|error| error.to_string())?;
    drop(bytes);
    let blob = blob.ok_or("no buffer in the file")?;
    let (mut vertices, mut triangles) = (0, 0);
    for primitive in document.nodes().filter_map(|node| node.mesh()).flat_map(|m| m.primitives()) {
        if primitive.mode() != gltf::mesh::Mode::Triangles {
            continue;
        }
        let Some(accessor) = primitive.get(&gltf::Semantic::Positions) else { continue };
        let positions: Vec<[f32; 3]> = elements(&accessor, &blob)?.map(float3).collect();
        let corners = match primitive.indices() {
            Some(accessor) => elements(&accessor, &blob)?.map(index).collect::<Vec<u32>>().len(),
            None => positions.len(),
        };
        vertices += positions.len();
        triangles += corners / 3;
    }
    Ok([vertices, triangles])
}

/// The bytes of each element of an accessor.
fn elements<'a>(
    accessor: &gltf::Accessor<'_>,
    blob: &'a [u8],
) -> Result<impl Iterator<Item = &'a [u8]>, String> {
    let view = accessor.view().ok_or("sparse accessor")?;
    let (size, count) = (accessor.size(), accessor.count());
    let stride = view.stride().unwrap_or(size).max(1);
    let start = view.offset() + accessor.offset();
    let end = start + stride * count.saturating_sub(1) + if count > 0 { size } else { 0 };
    let bytes = blob.get(start..end).ok_or("accessor beyond the buffer")?;
    Ok(bytes.chunks(stride).map(move |element| &element[..size.min(element.len())]))
}

fn float3(element: &[u8]) -> [f32; 3] {
    core::array::from_fn(|i| {
        let bytes = element.get(4 * i..4 * i + 4).and_then(|bytes| bytes.try_into().ok());
        f32::from_le_bytes(bytes.unwrap_or_default())
    })
}

fn index(element: &[u8]) -> u32 {
    element.iter().rev().fold(0, |value, &byte| (value << 8) | u32::from(byte))
}

/// What a reader made of the folder.
#[derive(Default)]
struct Totals {
    files: usize,
    bytes: u64,
    seconds: f64,
    peaks: Vec<f64>,
    refused: Vec<String>,
    /// Files of which it has another number of triangles than `mesh-io`.
    different: Vec<String>,
}

impl Totals {
    /// The row of the table of readers.
    fn row(&mut self) -> String {
        self.peaks.sort_by(f64::total_cmp);
        let peak = |share: f64| {
            let last = self.peaks.len().saturating_sub(1) as f64;
            self.peaks.get((share * last).round() as usize).copied().unwrap_or(f64::NAN)
        };
        let list = |names: &[String]| match names {
            [] => "0".to_owned(),
            names => format!("{} ({})", names.len(), names.join("; ")),
        };
        format!(
            "{} | {:.1} | {:.1} | {:.1} | {:.2} | {} | {}",
            self.files,
            peak(0.0),
            peak(0.5),
            peak(1.0),
            1e9 * self.seconds / self.bytes.max(1) as f64,
            list(&self.refused),
            list(&self.different)
        )
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args_os().nth(1).map(PathBuf::from).ok_or("name a folder of meshes")?;
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)?
        .map(|entry| entry.map(|e| e.path()))
        .collect::<Result<_, _>>()?;
    paths.sort();
    let mut totals: BTreeMap<(&str, &str), Totals> = BTreeMap::new();
    println!("| file | bytes | reader | triangles | peak bytes per byte | ms |");
    println!("|---|---:|---|---:|---:|---:|");
    for path in paths {
        let (kind, other): (&str, Option<(&str, Reader)>) =
            match path.extension().and_then(|e| e.to_str()) {
                Some("obj") => ("OBJ", Some(("tobj", tobj))),
                Some("glb" | "gltf") => ("glTF", Some(("gltf", gltf))),
                _ => ("PLY, STL, OFF", None),
            };
        let bytes = std::fs::metadata(&path)?.len();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut expected = None;
        for (reader, read) in [("mesh-io", ours as Reader)].into_iter().chain(other) {
            let Measured { result, peak, seconds } = measure(read, &path);
            let peak = peak as f64 / bytes.max(1) as f64;
            let of_reader = totals.entry((kind, reader)).or_default();
            of_reader.files += 1;
            of_reader.bytes += bytes;
            of_reader.seconds += seconds;
            of_reader.peaks.push(peak);
            let cell = match result {
                Ok([_, triangles]) => {
                    let expected = *expected.get_or_insert(triangles);
                    if expected != triangles {
                        let text = format!("{name}: {triangles}, not {expected} triangles");
                        of_reader.different.push(text);
                    }
                    triangles.to_string()
                }
                Err(why) => {
                    let why: String = why.chars().take(60).filter(|c| *c != '|').collect();
                    of_reader.refused.push(format!("{name}: {why}"));
                    format!("refused: {why}")
                }
            };
            println!("| {name} | {bytes} | {reader} | {cell} | {peak:.1} | {:.1} |", 1e3 * seconds);
        }
    }
    println!();
    println!(
        "| format | reader | files | peak bytes per byte: least | median | most | ns per byte | refused | other triangles |"
    );
    println!("|---|---|---:|---:|---:|---:|---:|---|---|");
    for ((kind, reader), totals) in &mut totals {
        println!("| {kind} | {reader} | {} |", totals.row());
    }
    Ok(())
}

/// What a reader made of a file, the peak of the heap in bytes, and the time.
struct Measured {
    result: Result<[usize; 2], String>,
    peak: usize,
    seconds: f64,
}

fn measure(read: Reader, path: &Path) -> Measured {
    let before = HEAP.current_usage();
    HEAP.reset_peak_usage();
    let result = read(path);
    let peak = HEAP.peak_usage().saturating_sub(before);
    let times = (0..TIMES).map(|_| {
        let start = Instant::now();
        drop(read(path));
        start.elapsed().as_secs_f64()
    });
    Measured { result, peak, seconds: times.fold(f64::INFINITY, f64::min) }
}
