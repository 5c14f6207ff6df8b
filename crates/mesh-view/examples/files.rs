//! Mesh files as a page: `files IN... OUT.html`. Without arguments, a torus before and after noise.
#![allow(clippy::print_stdout)]

use std::path::{Path, PathBuf};

use mesh_core::TriMesh;
use mesh_io::{PictureOptions, Pictures};
use mesh_shapes::{Torus, add_normal_noise};
use mesh_view::{Exhibit, Page};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut paths: Vec<PathBuf> = std::env::args_os().skip(1).map(Into::into).collect();
    let output = paths.pop().unwrap_or_else(|| std::env::temp_dir().join("view.html"));
    let mut exhibits = Vec::new();
    for path in &paths {
        let model = mesh_io::read(path)?;
        let options =
            PictureOptions { folder: path.parent().map(Path::to_owned), ..Default::default() };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let pictures = Pictures::of_model(&model, &options);
        exhibits.push(Exhibit::of_model(name, &model, pictures)?);
    }
    if exhibits.is_empty() {
        let mut soup = Torus { major: 5.0, minor: 2.0 }.mesh(96, 48)?;
        exhibits.push(Exhibit::of_mesh("before", &TriMesh::from_soup(&soup)?));
        add_normal_noise(&mut soup, 0.2, 1);
        exhibits.push(Exhibit::of_mesh("after", &TriMesh::from_soup(&soup)?));
    }
    let title = exhibits.iter().map(|e| &*e.name).collect::<Vec<_>>().join(", ");
    std::fs::write(&output, Page::new(title, exhibits).to_html()?)?;
    println!("{}", output.display());
    Ok(())
}
