//! Gives every vertex a colour and a number by its height, and writes PLY and GLB for any viewer:
//! `cargo run --example paint_heights -- in.stl out`. Without arguments, a torus.
#![allow(clippy::print_stdout)]

use mesh_io::{Format, Model, Scalars, WriteOptions, read, stage};
use mesh_shapes::Torus;
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (mut model, output) = match &arguments[..] {
        [input, output] => (read(input)?, PathBuf::from(output)),
        _ => {
            let torus = Torus { major: 5.0, minor: 2.0 }.mesh(48, 24)?;
            (Model::from(torus), std::env::temp_dir().join("heights"))
        }
    };
    let heights: Vec<f64> = model.soup.positions().iter().map(|p| p.z).collect();
    let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let color = |height: &f64| {
        let share = ((height - low) / (high - low).max(f64::MIN_POSITIVE)) as f32;
        [share, 0.2, 1.0 - share, 1.0]
    };
    model.vertex_colors = Some(heights.iter().map(color).collect());
    model.vertex_scalars.push(Scalars::new("height", heights));

    // Both files or none.
    let staged = [Format::Ply, Format::Glb].map(|format| {
        let path = output.with_extension(format.extension());
        stage(&path, &model, &WriteOptions::default()).map(|staged| (path, staged))
    });
    for ready in staged.into_iter().collect::<Result<Vec<_>, _>>()? {
        let (path, staged) = ready;
        let report = staged.commit()?;
        println!("{}: rounded by {:.1e}", path.display(), report.rounding);
    }
    Ok(())
}
