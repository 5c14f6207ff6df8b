//! Six sides of a mesh file on one sheet: `six_sides IN OUT.png`. Without arguments, a cube.
#![allow(clippy::print_stdout)]

use mesh_core::build::{Repair, build};
use mesh_render::{Scene, SheetOptions, Side, Style, View, render, sheet};
use mesh_shapes::inset_cube;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let soup = match arguments.next() {
        Some(input) => mesh_io::read(std::path::Path::new(&input))?.soup,
        None => inset_cube(0.25)?,
    };
    let output =
        arguments.next().map_or_else(|| std::env::temp_dir().join("sides.png"), Into::into);
    let mesh = build(&soup, &Repair::lenient())?.mesh;
    let style = Style {
        size: [360, 360],
        edge_width: 0.8,
        silhouette_width: 2.0,
        background: None,
        ..Style::default()
    };
    let mut pictures = Vec::new();
    for &side in &Side::ALL[..6] {
        let view = View::of_side(&mesh, side).ok_or("the mesh has no vertices")?;
        pictures.push((render(&Scene::of(&mesh), &view, &style)?, side.name().to_owned()));
    }
    let options = SheetOptions { columns: 3, background: None, ..SheetOptions::default() };
    std::fs::write(&output, sheet(&pictures, &options)?.to_png()?)?;
    println!("{}", output.display());
    Ok(())
}
