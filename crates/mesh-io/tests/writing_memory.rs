//! The memory that writing takes, in proportion to the file that the model came from.
#![cfg(all(feature = "obj", feature = "gltf"))]
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use mesh_io::{Format, ReadOptions, WriteOptions, read_from, write_to};
use peak_alloc::PeakAlloc;
use std::fmt::Write;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// The memory that a file of this size may take, from reading it to having written another.
fn allowed(size: usize) -> usize {
    (64 << 20) + 60 * size
}

/// Only one test, because the allocator counts the allocations of all threads.
#[test]
fn writing_takes_memory_in_proportion_to_the_input() {
    let mut materials = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    for material in 0..300_000 {
        writeln!(materials, "usemtl {material}\nf 1 2 3").unwrap();
    }
    // Every corner has its own texture coordinate and normal.
    let mut seams = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    for corner in 0..60_000 {
        writeln!(seams, "vt {corner} 1\nvn 0 {corner} 1").unwrap();
    }
    for face in 0..20_000 {
        let [a, b, c] = [1, 2, 3].map(|corner| 3 * face + corner);
        writeln!(seams, "f 1/{a}/{a} 2/{b}/{b} 3/{c}/{c}").unwrap();
    }
    // One polygon with very many corners.
    let mut polygon = String::new();
    for vertex in 0..20_000 {
        let angle = f64::from(vertex) * std::f64::consts::TAU / 20_000.0;
        writeln!(polygon, "v {} {} 0", angle.cos(), angle.sin()).unwrap();
    }
    polygon += "f";
    (1..=20_000).for_each(|vertex| write!(polygon, " {vertex}").unwrap());
    for (name, text) in [("materials", materials), ("seams", seams), ("polygon", polygon)] {
        for &format in Format::ALL {
            let before = MEMORY.current_usage();
            MEMORY.reset_peak_usage();
            let model = read_from(&mut text.as_bytes(), &ReadOptions::default()).unwrap();
            write_to(&mut std::io::sink(), &model, format, &WriteOptions::default()).unwrap();
            let taken = MEMORY.peak_usage() - before;
            let limit = allowed(text.len());
            println!("{name}, {} bytes, as {format}: {taken} of {limit} bytes", text.len());
            assert!(taken <= limit, "{name} as {format}: {taken} bytes, {limit} allowed");
        }
    }
}
