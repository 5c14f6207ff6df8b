//! Laplacian smoothing in a few lines: a noisy sphere before and after, by the spread of its radii.
//!
//! `cargo run -p mesh-core --example smooth`
#![allow(clippy::print_stdout)]

use std::error::Error;

use mesh_core::glam::DVec3;
use mesh_core::{TriMesh, VertexMap};
use mesh_shapes::{Sphere, add_normal_noise};

fn main() -> Result<(), Box<dyn Error>> {
    let mut soup = Sphere::UNIT.icosphere(4)?;
    add_normal_noise(&mut soup, 0.2, 1);
    let mut mesh = TriMesh::from_soup(&soup)?;
    println!("before: radii differ by {:.4}", spread(&mesh));
    for _ in 0..10 {
        step(&mut mesh);
    }
    println!("after ten steps: {:.4}", spread(&mesh));
    Ok(())
}

/// Moves every vertex half way to the mean of its neighbours, weighted by cotangents.
fn step(mesh: &mut TriMesh) {
    let topology = mesh.topology();
    let mut sums: VertexMap<(DVec3, f64)> = topology.vertex_map((DVec3::ZERO, 0.0));
    for entry in mesh.cotangent_laplacian() {
        if entry.row != entry.column && entry.value > 0.0 {
            sums[entry.row].0 += entry.value * mesh.position(entry.column);
            sums[entry.row].1 += entry.value;
        }
    }
    for (vertex, (sum, weight)) in sums.iter() {
        if *weight > 0.0 {
            let position = &mut mesh.positions_mut()[vertex.index()];
            *position = 0.5 * *position + 0.5 * *sum / *weight;
        }
    }
}

/// The standard deviation of the distances from the centre.
fn spread(mesh: &TriMesh) -> f64 {
    let radii: Vec<f64> = mesh.positions().iter().map(|p| p.length()).collect();
    let mean = radii.iter().sum::<f64>() / radii.len() as f64;
    let squares = radii.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>();
    (squares / radii.len() as f64).sqrt()
}
