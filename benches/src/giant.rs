//! A mesh of any size, streamed to a file: a torus with bumps of many sizes, closed and without noise, so that the
//! distance from it is meaningful.

use std::f64::consts::TAU;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use clap::Args;
use glam::DVec3;

use xtask_common::Failure;

#[derive(Debug, Args)]
pub(crate) struct Giant {
    /// The binary PLY file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The number of faces, about
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    faces: u64,
}

/// Numbers of rows and columns of vertices for about this number of faces, with square cells on average.
fn rows_and_columns(faces: u64) -> [u64; 2] {
    let rows = ((faces as f64 / 2.0 / RATIO).sqrt().round() as u64).max(3);
    [rows, (faces as f64 / 2.0 / rows as f64).round().max(3.0) as u64]
}

/// The radius of the circle around the axis, relative to the radius of the tube.
const RATIO: f64 = 2.5;

/// The point of the surface at two angles.
fn point(around: f64, along: f64) -> DVec3 {
    // Waves of decreasing length; their heights shrink faster, and some parts are smoother than others.
    let rough = 0.55 + 0.45 * (along + 0.7).sin();
    let bumps: f64 = (0..6)
        .map(|octave| {
            let n = f64::from(1 << octave);
            let (u, v) = (4.0 * n * around + 1.3 * n, 9.0 * n * along + 2.1 * n);
            let size = 0.1 / n.powf(1.25);
            let fades = if octave > 1 { rough } else { 1.0 };
            fades * size * (u.sin() * v.cos() + 0.5 * (u + 2.0 * v).sin())
        })
        .sum();
    let tube = 1.0 + bumps;
    let radius = RATIO + tube * around.cos();
    DVec3::new(radius * along.cos(), radius * along.sin(), tube * around.sin())
}

pub(crate) fn run(options: &Giant) -> Result<(), Failure> {
    let [rows, columns] = rows_and_columns(options.faces);
    let vertices = rows * columns;
    if vertices > u64::from(u32::MAX) {
        let message = "PLY has no numbers for so many vertices; ask for fewer faces";
        return Err(Failure::Usage(message.to_owned()));
    }
    let path = &options.output;
    let file = File::create(path).map_err(Failure::writing(path))?;
    let mut out = BufWriter::with_capacity(1 << 16, file);
    let write = |out: &mut BufWriter<File>| -> std::io::Result<()> {
        writeln!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}")?;
        writeln!(out, "property float x\nproperty float y\nproperty float z")?;
        writeln!(out, "element face {}", 2 * vertices)?;
        writeln!(out, "property list uchar uint vertex_indices\nend_header")?;
        for column in 0..columns {
            for row in 0..rows {
                let around = TAU * row as f64 / rows as f64;
                let along = TAU * column as f64 / columns as f64;
                for x in point(around, along).as_vec3().to_array() {
                    out.write_all(&x.to_le_bytes())?;
                }
            }
        }
        for column in 0..columns {
            for row in 0..rows {
                let at = |row: u64, column: u64| (column % columns * rows + row % rows) as u32;
                let [a, b] = [at(row, column), at(row + 1, column)];
                let [c, d] = [at(row + 1, column + 1), at(row, column + 1)];
                // Alternating diagonals, so that neither direction is preferred.
                let pair = if (row + column) % 2 == 0 {
                    [[a, d, c], [a, c, b]]
                } else {
                    [[a, d, b], [d, c, b]]
                };
                for triangle in pair {
                    out.write_all(&[3])?;
                    for v in triangle {
                        out.write_all(&v.to_le_bytes())?;
                    }
                }
            }
        }
        out.flush()
    };
    write(&mut out).map_err(Failure::writing(path))?;
    println!("{}: {vertices} vertices, {} faces", path.display(), 2 * vertices);
    Ok(())
}
