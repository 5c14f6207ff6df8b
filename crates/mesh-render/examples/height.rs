//! A height field coloured by height, with a colour bar: writes `height.png` to the folder for temporary files.
#![allow(clippy::print_stdout)]

use mesh_core::{TriMesh, VertexMap};
use mesh_render::{ColorBar, Paint, ScaleOptions, Scene, Side, Style, View, render};
use mesh_shapes::Torus;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = TriMesh::from_soup(&Torus { major: 5.0, minor: 2.0 }.mesh(96, 48)?)?;
    let scale = ScaleOptions { signed: true, ..ScaleOptions::default() }
        .fit(mesh.positions().iter().map(|p| p.z));
    let colors = VertexMap::from_vec(mesh.positions().iter().map(|p| scale.color(p.z)).collect());
    let scene = Scene { paint: Paint::Vertices(&colors), ..Scene::of(&mesh) };
    let view = View::of_side(&mesh, Side::Corner).ok_or("the mesh has no vertices")?;
    let style = Style { smooth: true, silhouette_width: 1.5, ..Style::default() };
    let picture = render(&scene, &view, &style)?;
    let path = std::env::temp_dir().join("height.png");
    let with_bar = ColorBar::new(scale, "height").beside(&picture, style.background)?;
    std::fs::write(&path, with_bar.to_png()?)?;
    println!("{}", path.display());
    Ok(())
}
