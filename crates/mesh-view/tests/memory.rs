//! The memory of pages.
#![allow(clippy::unwrap_used)]

use std::fmt::Write;

use mesh_io::{Pictures, ReadOptions, read_from};
use mesh_view::{Exhibit, Page};
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Reading a file and making its page takes the memory that reading alone may take. One test, because the allocator
/// counts for all threads.
#[test]
fn pages_take_the_memory_of_reading() {
    let mut materials = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    (0..400_000).for_each(|i| writeln!(materials, "usemtl {i}").unwrap());
    materials += "f 1 2 3\n";
    let mut numbers = "ply\nformat binary_little_endian 1.0\nelement vertex 3\n".to_owned();
    ["x", "y", "z"].iter().for_each(|x| writeln!(numbers, "property char {x}").unwrap());
    (0..150_000).for_each(|i| writeln!(numbers, "property char {i}").unwrap());
    numbers += "element face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
    let mut numbers = numbers.into_bytes();
    for [x, y] in [[0, 0], [1, 0], [0, 1]] {
        numbers.extend([x, y, 0]);
        numbers.extend([1; 150_000]);
    }
    numbers.extend([3, 0, 1, 2]);
    for file in [materials.into_bytes(), numbers] {
        let before = MEMORY.current_usage();
        MEMORY.reset_peak_usage();
        let options = ReadOptions { size: Some(file.len() as u64), ..ReadOptions::default() };
        let model = read_from(&mut &file[..], &options).unwrap();
        let exhibit = Exhibit::of_model("", &model, Pictures::default()).unwrap();
        let html = Page::new("", vec![exhibit]).to_html().unwrap();
        let (peak, allowed) = (MEMORY.peak_usage() - before, (64 << 20) + 60 * file.len());
        eprintln!("{} bytes, a page of {}: {peak} of {allowed}", file.len(), html.len());
        assert!(peak <= allowed, "{peak} of {allowed} for {} bytes", file.len());
    }
}
