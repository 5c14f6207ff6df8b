//! Reads a mesh file and writes it as another: `cargo run --example roundtrip -- in.obj out.glb`.
#![allow(clippy::print_stdout)]

use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let (Some(from), to) = (arguments.next(), arguments.next()) else {
        return Err("expected the file to read, and perhaps the file to write".into());
    };
    let start = Instant::now();
    let model = mesh_io::read(&from)?;
    let (vertices, faces) = (model.soup.vertex_count(), model.soup.face_count());
    println!("{vertices} vertices and {faces} faces in {:?}", start.elapsed());
    model.notes.iter().for_each(|note| println!("note: {note}"));
    if let Some(to) = to {
        let start = Instant::now();
        let report = mesh_io::write(&to, &model, &mesh_io::WriteOptions::default())?;
        println!("written in {:?}, rounding {}", start.elapsed(), report.rounding);
        report.lost.iter().for_each(|lost| println!("lost: {lost}"));
    }
    Ok(())
}
