//! Writes a custom mesh type without a conversion to another type.
#![allow(clippy::print_stdout)]

use mesh_core::PolygonSoup;
use mesh_io::{Format, Model, ModelError, ReadOptions, ToModel, WriteOptions, read_from, write_to};
use std::borrow::Cow;
use std::error::Error;

/// Heights over a square grid, as a scanner or a terrain file gives them.
struct Heights {
    columns: usize,
    values: Vec<f32>,
}

impl ToModel for Heights {
    fn to_model(&self) -> Result<Cow<'_, Model>, ModelError> {
        let rows = self.values.len() / self.columns;
        let mut soup = PolygonSoup::new();
        for (place, &height) in self.values.iter().enumerate() {
            let (column, row) = (place % self.columns, place / self.columns);
            soup.push_vertex([column as f64, row as f64, f64::from(height)]);
        }
        for row in 1..rows {
            for column in 1..self.columns {
                let last = (row * self.columns + column) as u32;
                let below = last - self.columns as u32;
                soup.push_face(&[below - 1, below, last, last - 1])?;
            }
        }
        Ok(Cow::Owned(soup.into()))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let wave = |place: usize| ((place % 40) as f32 * 0.3).sin() * ((place / 40) as f32 * 0.2).cos();
    let terrain = Heights { columns: 40, values: (0..40 * 30).map(wave).collect() };
    for &format in Format::ALL {
        let mut bytes = Vec::new();
        write_to(&mut bytes, &terrain, format, &WriteOptions::default())?;
        let known = ReadOptions { format: Some(format), ..ReadOptions::default() };
        let faces = read_from(&mut bytes.as_slice(), &known)?.soup.face_count();
        println!("{format}: {} bytes, {faces} faces", bytes.len());
    }
    Ok(())
}
