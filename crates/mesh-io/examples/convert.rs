//! Converts mesh files: `cargo run --example convert -- in.obj out.glb`. Without arguments, writes a cube in every
//! format, and prints the losses.
#![allow(clippy::print_stdout)]

use mesh_io::{Format, Model, WriteOptions, read, write};
use mesh_shapes::polyhedra;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [input, output] = &arguments[..] {
        let model = read(input)?;
        model.notes.iter().for_each(|note| println!("{input}: {note}"));
        return convert(&model, Path::new(output));
    }
    let mut cube = Model::from(polyhedra::cube());
    let corners = cube.soup.positions().iter();
    cube.vertex_colors = Some(corners.map(|p| [p.x as f32, p.y as f32, p.z as f32, 1.0]).collect());
    let folder = std::env::temp_dir().join("mesh-io-example");
    std::fs::create_dir_all(&folder)?;
    for &format in Format::ALL {
        convert(&cube, &folder.join("cube").with_extension(format.extension()))?;
    }
    Ok(std::fs::remove_dir_all(folder)?)
}

fn convert(model: &Model, output: &Path) -> Result<(), Box<dyn Error>> {
    let report = write(output, model, &WriteOptions::default())?;
    let again = read(output)?.soup;
    let (vertices, faces) = (again.vertex_count(), again.face_count());
    println!("{}: {vertices} vertices, {faces} faces", output.display());
    report.lost.iter().for_each(|lost| println!("  lost {lost}"));
    Ok(())
}
